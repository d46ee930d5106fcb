"use strict";
// The study file of what is set: pure functions from numbers to TOML.

const studyText = (() => {
  // A number to so many significant digits, as a decimal that a study file reads: no power of ten.
  function decimal(value, digits = 12) {
    const text = String(Number(value.toPrecision(digits)));
    if (!/e/.test(text)) return text;
    const places = Math.min(100, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value)))));
    const fixed = value.toFixed(places);
    return fixed.includes(".") ? fixed.replace(/\.?0+$/, "") : fixed;
  }

  const signed = (value) => (value < 0 ? decimal(value) : `+${decimal(value)}`);
  const quantity = (value, unit) => (unit ? `"${decimal(value)} ${unit}"` : decimal(value));

  // Deviations that differ by rounding alone are the same.
  const same = (a, b, scale) => Math.abs(a - b) <= 1e-9 * scale;

  // What a dimension is in the study file. dimension: word, unit, factor (of the unit), isSize, options ([key, text or number and
  // whether it is a place or a width]), nominal, lower, upper of the study; set: nominal, width, size (ISO 286 class or null).
  function entry(dimension, set) {
    const { unit, factor } = dimension;
    const ratio = set.width / (dimension.upper - dimension.lower);
    const moved = (value) => set.nominal + ratio * (value - dimension.nominal);
    const rest = dimension.options.map(({ key, text, place, width, shapes }) => {
      if (text !== undefined) return `${key} = ${text}`;
      if (shapes) {
        const parts = Object.entries(shapes).map(([name, value]) => `${name} = ${value}`);
        const [loc, scale] = [quantity(factor * moved(place), unit), quantity(factor * ratio * width, dimension.differenceUnit)];
        return `${key} = { ${[`loc = ${loc}`, `scale = ${scale}`, ...parts].join(", ")} }`;
      }
      return `${key} = ${place === undefined ? quantity(factor * ratio * width, dimension.differenceUnit) : quantity(factor * moved(place), unit)}`;
    });
    const table = (...first) => `{ ${[...first, ...rest].join(", ")} }`;
    if (set.size) return rest.length || !dimension.isDrawn ? table(`diameter = "${set.size}"`) : `"${set.size}"`;
    const nominal = factor * set.nominal, scale = factor * set.width;
    const low = factor * (moved(dimension.lower) - set.nominal), high = factor * (moved(dimension.upper) - set.nominal);
    const isSymmetric = same(-low, high, scale);
    if (dimension.isSize) {
      const zone = isSymmetric ? `±${decimal(high, 10)}` : `${signed(round(high, scale))}/${signed(round(low, scale))}`;
      const size = `"${decimal(nominal)} ${zone} ${unit}"`;
      return rest.length ? table(`size = ${size}`) : size;
    }
    if (set.nominal !== dimension.nominal) {
      return table(`lower = ${quantity(factor * moved(dimension.lower), unit)}`, `upper = ${quantity(factor * moved(dimension.upper), unit)}`);
    }
    const ends = isSymmetric ? quantity(high, dimension.differenceUnit) : `[${quantity(low, dimension.differenceUnit)}, ${quantity(high, dimension.differenceUnit)}]`;
    return table(`tolerance = ${ends}`);
  }

  // A deviation without the rounding of the nominal value.
  const round = (value, scale) => (Math.abs(value) <= 1e-9 * scale ? 0 : Number((value / scale).toPrecision(10)) * scale);

  // Lines in place of one of the study's lines, for the dimensions that it gives; null: the line stays.
  function lines(slot, dimensions, sets) {
    const changed = slot.names.filter((name) => {
      const d = dimensions[name], set = sets[name];
      return set.nominal !== d.nominal || set.width !== d.upper - d.lower || set.size !== d.size;
    });
    if (changed.length === 0) return null;
    const sizes = slot.names.map((name) => sets[name].size);
    if (slot.word === "fit" && sizes.every(Boolean)) {
      const [hole, shaft] = sizes.map((size) => size.split(" "));
      return [`fit = "${hole[0]} ${hole[1]}/${shaft[1]}"`];
    }
    if (slot.spin && sets[slot.names[0]].nominal === dimensions[slot.names[0]].nominal) {
      return [`unbalance = "G${decimal(1e3 * slot.spin * sets[slot.names[0]].width, 6)}"`];
    }
    return slot.names.map((name) => `${dimensions[name].word} = ${entry(dimensions[name], sets[name])}`);
  }

  // Limits of an output as a study file has them: output (unit, factor, min and max of the study), ends {min, max}.
  function limitEntry(output, ends) {
    const words = ["min", "max"].filter((side) => ends[side] !== null).map((side) => `${side} = ${quantity(output.factor * ends[side], output.unit)}`);
    return `${output.name} = { ${words.join(", ")} }`;
  }

  // [specification] in `text`, lines of the study file: those of other limits or of another target replaced or, where there were
  // none, written below. asked: ends ({min, max} of every output), target.
  function require(text, { lines: written, after }, outputs, studyTarget, asked) {
    const fresh = [];
    const put = (word, line) => {
      if (!(word in written)) return fresh.push(line);
      const [number, comment] = written[word];
      text[number] = line && line + (comment ? `  ${comment}` : "");
    };
    if (asked.target !== studyTarget) put("target", `target = "${decimal(100 * asked.target)} %"`);
    outputs.forEach((output, i) => {
      const { min, max } = asked.ends[i];
      if (min === output.min && max === output.max) return;
      put(output.name, min === null && max === null ? null : limitEntry(output, asked.ends[i]));
    });
    if (fresh.length === 0) return;
    if (after === null) text.push("[specification]", ...fresh, "");
    else text[after] = [...(text[after] === null ? [] : [text[after]]), ...fresh].join("\n");
  }

  // The study file: its lines, those of dimensions and limits that are set otherwise replaced, comments kept.
  function study(data, dimensions, sets, asked = null) {
    const text = data.source.split("\n");
    for (const slot of data.slots) {
      const instead = lines(slot, dimensions, sets);
      if (!instead) continue;
      text[slot.line] = instead.join("\n") + (slot.comment ? `  ${slot.comment}` : "");
      if (!instead[0].startsWith("fit =")) slot.drops.forEach((line) => { text[line] = null; });
    }
    if (asked) require(text, data.requirements, data.outputs, data.target, asked);
    return text.filter((line) => line !== null).join("\n");
  }

  return { decimal, entry, study };
})();
