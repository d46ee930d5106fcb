"use strict";
// The limits of an output where they are moved.

const limitControls = (() => {
  const { element, number, round, clean } = elements;
  // Of a histogram, in its own units.
  const WIDTH = 300, HEIGHT = 84;
  const SIDES = { min: ["\u2265", "smallest allowed"], max: ["\u2264", "largest allowed"] };

  // Ends and step of a histogram's axis, in the unit shown: the study's values with room, what is set, limits near them.
  function around(output, ends, now, study) {
    const { factor } = output, width = study.max - study.min || Math.abs(study.max) || 1;
    const near = [output.min, output.max, ends.min, ends.max]
      .filter((x) => x !== null && x > study.min - width && x < study.max + width);
    const floor = study.min >= 0 ? 0 : -Infinity;
    const low = factor * Math.min(Math.max(study.min - 0.5 * width, floor), now.min, ...near);
    const high = factor * Math.max(study.max + 0.5 * width, now.max, ...near);
    const step = round((high - low) / 200);
    return { low: clean(Math.floor(low / step + 1e-9) * step), high: clean(Math.ceil(high / step - 1e-9) * step), step: clean(step) };
  }

  // Limits of an output: a line in its histogram and a slider below it, both to be moved, and a number. endsOf: gives the limits
  // that are set, {min, max}; changed: called where one has been.
  function controls(output, endsOf, changed) {
    const { factor, shownUnit: unit } = output;
    let axis = null, held = false;
    const atPlace = (share) => {
      const { low, high, step } = axis;
      return clean(Math.round((low + Math.min(Math.max(share, 0), 1) * (high - low)) / step) * step);
    };
    const take = (side, shown) => {
      const own = output[side] !== null && Math.abs(shown - factor * output[side]) <= 1e-9 * Math.abs(shown);
      endsOf()[side] = own ? output[side] : shown / factor;
      changed();
    };
    const hold = (is) => () => {
      held = is;
      if (!is) changed();
    };
    const made = Object.entries(SIDES).map(([side, [sign, words]]) => {
      const name = `${output.label}, ${words}`;
      const line = element("line", { class: "limit", y1: 0, y2: HEIGHT }), grip = element("line", { class: "grip", y1: 0, y2: HEIGHT });
      const beyond = element("rect", { class: "beyond", y: 0, height: HEIGHT });
      const slider = element("input", { type: "range", "aria-label": name });
      const field = element("input", { type: "number", step: "any", placeholder: "none", "aria-label": `${name}${unit ? `, ${unit}` : ""}` });
      const aside = element("span", { class: `aside ${side}` });
      grip.addEventListener("pointerdown", (event) => {
        held = true;
        grip.setPointerCapture(event.pointerId);
        event.preventDefault();
        slider.focus();
      });
      grip.addEventListener("pointermove", (event) => {
        const box = grip.ownerSVGElement.getBoundingClientRect();
        if (grip.hasPointerCapture(event.pointerId)) take(side, atPlace((event.clientX - box.left) / box.width));
      });
      grip.addEventListener("lostpointercapture", hold(false));
      slider.addEventListener("pointerdown", hold(true));
      slider.addEventListener("change", hold(false));
      slider.addEventListener("input", () => take(side, Number(slider.value)));
      field.addEventListener("input", () => {
        const value = Number(field.value);
        if (field.value === "" && !field.validity.badInput) {
          endsOf()[side] = null;
          changed();
        } else if (Number.isFinite(value) && field.value !== "") take(side, value);
      });
      const show = () => {
        const limit = endsOf()[side], { low, high, step } = axis;
        const value = limit === null ? null : clean(factor * limit);
        const outside = value === null ? 0 : value < low ? -1 : value > high ? 1 : 0;
        [line, grip, slider].forEach((part) => part.toggleAttribute("hidden", value === null || outside !== 0));
        beyond.toggleAttribute("hidden", value === null);
        if (document.activeElement !== field) field.value = value ?? "";
        aside.textContent = outside ? `${outside < 0 ? "\u2190 " : ""}${sign} ${number(value)}${outside > 0 ? " \u2192" : ""}` : "";
        aside.classList.toggle("left", outside < 0);
        if (value === null) return;
        const x = Math.min(Math.max(WIDTH * (value - low) / (high - low), 0), WIDTH);
        [line, grip].forEach((part) => ["x1", "x2"].forEach((end) => part.setAttribute(end, x)));
        beyond.setAttribute("x", side === "max" ? x : 0);
        beyond.setAttribute("width", side === "max" ? WIDTH - x : x);
        Object.assign(slider, { min: low, max: high, step, value });
        slider.setAttribute("aria-valuetext", `${number(value)} ${unit}`.trim());
      };
      field.addEventListener("blur", () => show());
      return { side, sign, line, grip, beyond, slider, field, aside, show };
    });
    // It stands still while a limit is drawn along it.
    const axisOf = (now, study) => {
      if (!held || !axis) axis = around(output, endsOf(), now, study);
      return axis;
    };
    const show = () => made.forEach((part) => part.show());
    const fields = element("div", { class: "ends" }, ...made.map(({ sign, field }) => element("label", {}, `${sign} `, field)), unit);
    return { made, fields, axisOf, show };
  }

  return { controls, WIDTH, HEIGHT };
})();
