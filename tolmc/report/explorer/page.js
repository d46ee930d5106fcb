"use strict";
// The explorer's page: controls, pictures and sentences. All numbers come from `arithmetic`, all TOML from `studyText`.

(() => {
  const root = document.getElementById("explorer");
  const data = arithmetic.prepared(JSON.parse(document.getElementById("explorer-data").textContent));
  const { dimensions, outputs, choices, cells, classes } = data;
  const byName = Object.fromEntries(dimensions.map((d) => [d.name, d]));

  const { element, number, fixed, places, percent, labelled, round, stepOf, clean, lower } = elements;
  const { WIDTH, HEIGHT } = limitControls, BINS = 48;
  const studySets = () => Object.fromEntries(
    dimensions.map((d) => [d.name, { nominal: d.nominal, width: d.upper - d.lower, size: d.size }]));
  // What is asked: smallest and largest allowed of every output (null: no limit), share of the parts that keep them.
  const studyAsked = () => ({ ends: outputs.map(({ min, max }) => ({ min, max })), target: data.target });
  let sets = studySets(), asked = studyAsked();
  const limits = () => arithmetic.limitsOf(outputs, asked.ends);

  // ---- controls

  const isSymmetric = (d) => Math.abs(d.lower + d.upper - 2 * d.nominal) < 1e-9 * (d.upper - d.lower);

  // What a slider moves: key of the set, number shown in one SI unit, its ends and step.
  function ranges(d) {
    const width = d.factor * (d.upper - d.lower), nominal = d.factor * d.nominal;
    const others = d.classes.map((c) => d.factor * c.nominal), wide = d.classes.map((c) => d.factor * c.width);
    const step = stepOf(width), half = isSymmetric(d) ? 0.5 : 1;
    const reach = Math.ceil(Math.max(1.5 * width, ...others.map((x) => Math.abs(x - nominal))) / step);
    const below = d.isSize ? Math.min(reach, Math.floor(nominal / step) - 1) : reach;
    const zone = half * width, fine = stepOf(zone);
    return [
      {
        key: "nominal", label: d.size ? "Middle of zone" : "Nominal", factor: d.factor, own: d.nominal, step,
        min: nominal - below * step, max: nominal + reach * step,
      },
      {
        key: "width", label: half < 1 ? "Tolerance \u00b1" : "Width of zone", factor: half * d.factor, own: d.upper - d.lower, step: fine,
        min: fine, max: Math.max(3 * zone, ...wide.map((x) => half * x)),
      },
    ];
  }

  function control(d, range) {
    const id = `explorer-${d.name}-${range.key}`;
    const ends = { min: clean(range.min), max: clean(range.max), step: range.step };
    const slider = element("input", { type: "range", id, ...ends });
    const field = element("input", { type: "number", step: "any", "aria-label": `${d.label}, ${range.label}, ${d.shownUnit}` });
    const show = () => {
      const value = clean(range.factor * sets[d.name][range.key]);
      slider.value = value;
      slider.setAttribute("aria-valuetext", `${value} ${d.shownUnit}`);
      if (document.activeElement !== field) field.value = Number(value.toPrecision(range.key === "width" ? 5 : 8));
    };
    const take = (text) => {
      const value = Number(text);
      if (text === "" || !Number.isFinite(value) || (range.key === "width" && value <= 0)) return;
      const own = Math.abs(value - range.factor * range.own) <= 1e-9 * Math.abs(value);
      sets[d.name][range.key] = own ? range.own : value / range.factor;
      const set = sets[d.name];
      set.size = set.nominal === d.nominal && set.width === d.upper - d.lower ? d.size : null;
      changed();
    };
    slider.addEventListener("input", () => take(slider.value));
    field.addEventListener("input", () => take(field.value));
    field.addEventListener("blur", show);
    showing.push(show);
    return element("div", { class: "control" },
      element("label", { for: id }, element("span", { class: "unseen" }, `${d.label}, `), range.label),
      field, element("span", {}, d.shownUnit), slider);
  }

  function classControl(d) {
    const id = `explorer-${d.name}-class`;
    const letters = [...new Set(d.classes.map((c) => c.letter))];
    const grades = d.classes.map((c) => c.grade);
    const select = element("select", { id: `${id}-letter`, "aria-label": `${d.label}, letter of the class` },
      ...letters.map((letter) => element("option", { value: letter }, letter)));
    const slider = element("input", { type: "range", id, min: Math.min(...grades), max: Math.max(...grades), step: 1 });
    const shown = element("output", { for: id });
    const show = () => {
      const now = d.classes.find((c) => c.size === sets[d.name].size);
      if (now) {
        select.value = now.letter;
        slider.value = now.grade;
      }
      shown.textContent = now ? now.size : "none";
      slider.setAttribute("aria-valuetext", now ? `grade ${now.grade}` : "no class");
    };
    const take = () => {
      const offered = d.classes.filter((c) => c.letter === select.value);
      const far = (c) => Math.abs(c.grade - Number(slider.value));
      const next = offered.reduce((best, c) => (far(c) < far(best) ? c : best));
      const own = next.size === d.size;
      sets[d.name] = { nominal: own ? d.nominal : next.nominal, width: own ? d.upper - d.lower : next.width, size: next.size };
      changed();
    };
    select.addEventListener("change", take);
    slider.addEventListener("input", take);
    showing.push(show);
    return element("div", { class: "control class" },
      element("label", { for: id }, element("span", { class: "unseen" }, `${d.label}, `), "Class"), select, shown, slider);
  }

  function controls(d, place) {
    const inner = d.movable
      ? [...(d.classes.length ? [classControl(d)] : []), ...ranges(d).map((range) => control(d, range))]
      : [element("p", { class: "small" }, "Follows measured values or a distribution of its own: it has no zone to move.")];
    return element("fieldset", { class: `of-${place % 6}` }, element("legend", {}, element("span", { class: "swatch" }), d.label), ...inner);
  }

  // ---- pictures

  // Heights of bins as the outline of a histogram.
  function outline(counts, most) {
    const wide = WIDTH / counts.length;
    let path = `M0 ${HEIGHT}`;
    counts.forEach((count, i) => {
      path += `V${(HEIGHT * (1 - count / most)).toFixed(2)}H${(wide * (i + 1)).toFixed(2)}`;
    });
    return `${path}V${HEIGHT}Z`;
  }

  function panel(output, place) {
    const now = element("path", { class: "now" }), before = element("path", { class: "before" });
    const ends = limitControls.controls(output, () => asked.ends[place], changed);
    const of = (key) => ends.made.map((end) => end[key]);
    const picture = element("svg", { viewBox: `0 -2 ${WIDTH} ${HEIGHT + 3}`, role: "img", preserveAspectRatio: "none" },
      ...of("beyond"), now, before, ...of("line"), ...of("grip"));
    const mean = element("span", { class: "mean" }), left = element("span"), right = element("span");
    const bar = element("div", { class: "drivers", role: "img" }), names = element("p", { class: "small" });
    const error = 100 * output.margin / output.sd;
    const heldOut = `held-out error ${error < 0.001 ? "below 0.001" : number(error, 2)} % of the study's standard deviation`;
    const made = element("figure", { class: "output", "data-output": output.name },
      element("figcaption", {}, element("b", {}, ...labelled(output.label)), mean),
      element("div", { class: "histogram" }, picture, ...of("aside"), ...of("slider")),
      element("div", { class: "axis" }, left, ends.fields, right), bar, names, element("p", { class: "small soft" }, heldOut));
    const show = (values, first, usable, usableFirst) => {
      const s = arithmetic.summary(values, usable), t = arithmetic.summary(first, usableFirst);
      const axis = ends.axisOf(s, t), low = axis.low / output.factor, high = axis.high / output.factor;
      const counts = arithmetic.histogram(values, usable, low, high, BINS), old = arithmetic.histogram(first, usableFirst, low, high, BINS);
      const most = 1.04 * Math.max(...counts, ...old);
      now.setAttribute("d", outline(counts, most));
      before.setAttribute("d", outline(old, most));
      ends.show();
      const digits = places(output.factor * s.sd) + 1;
      mean.textContent = `${fixed(output.factor * s.mean, digits)} \u00b1 ${fixed(output.factor * s.sd, digits)} ${output.shownUnit}`.trim();
      mean.title = "mean \u00b1 standard deviation";
      left.textContent = fixed(axis.low, places(axis.high - axis.low));
      right.textContent = fixed(axis.high, places(axis.high - axis.low));
      picture.setAttribute("aria-label", `Histogram of ${output.label}: mean ${mean.textContent} (standard deviation)`);
      Object.assign(made.dataset, { mean: s.mean, sd: s.sd, min: s.min, max: s.max });
      drivers(values, usable);
    };
    const drivers = (values, usable) => {
      const shares = cells.map((cell) => Math.max(arithmetic.firstOrder(values, cell, classes, usable), 0) || 0);
      const order = [...shares.keys()].sort((a, b) => shares[b] - shares[a]);
      bar.replaceChildren(...shares.map((part, i) => element("span", { class: `of-${i % 6}`, style: `width: ${(100 * part).toFixed(1)}%` })));
      const words = order.filter((i) => shares[i] >= 0.005).slice(0, 3).map((i) => `${Math.round(100 * shares[i])} % ${lower(dimensions[i].label)}`);
      const text = words.length ? `${words.join(", ")} of the variance` : "no single dimension drives it";
      names.textContent = text;
      bar.setAttribute("aria-label", `Drivers of ${output.label}: ${text}`);
      made.dataset.drivers = JSON.stringify(shares);
    };
    return { made, show, isForemost: place < Math.max(data.limits.length, 3) };
  }

  // The joint to scale: bearing of radius R and length 2 L, journal of radius r at its largest tilt.
  function jointPicture() {
    const wall = element("g", { class: "wall" }), journal = element("g", { class: "journal" });
    const axis = element("line", { class: "centre" }), marks = element("g", { class: "marks" });
    const picture = element("svg", { role: "img" }, wall, journal, axis, marks), words = element("figcaption");
    const start = jointOf(studySets());
    const tilt = arithmetic.tiltAngle(start.R, start.r, start.L);
    const times = tilt < 0.035 ? round(0.12 / tilt) : 1;
    const box = element("input", { type: "checkbox", id: "explorer-wider" });
    const wider = times > 1 ? [element("p", { class: "small" }, box, element("label", { for: "explorer-wider" }, ` clearance drawn ${times} times wider`))] : [];
    const show = () => {
      const { R, r, L } = jointOf(sets), m = box.checked ? times : 1;
      const psi = arithmetic.tiltAngle(R, r, L);
      words.textContent = R > r
        ? `To scale${m > 1 ? " but for the clearance" : ""}, at the nominal values: tilt \u03c8 = ${number(180 / Math.PI * psi)}\u00b0, ` +
          `r = ${number(1e3 * arithmetic.effectiveRadius(R, r, L))} mm, clearance ${number(2e3 * (R - r), 4)} mm on the diameter` +
          `${data.inOperation ? ", as made, not in operation" : ""}.`
        : "No clearance: the journal is larger than the bore.";
      picture.setAttribute("aria-label", words.textContent);
      Object.assign(picture.dataset, { tilt: psi });
      if (R > r) draw(r + m * (R - r), r, L);
    };
    const draw = (R, r, L) => {
      const psi = arithmetic.tiltAngle(R, r, L), long = 1.5 * L;
      const thick = 0.28 * R, high = Math.max(R + thick, long * Math.sin(psi) + r * Math.cos(psi)) * 1.06, wide = 1.12 * (long + r * Math.sin(psi));
      picture.setAttribute("viewBox", [-wide, -high, 2 * wide, 2 * high].map((x) => 1e3 * x).join(" "));
      const rect = (x, y, w, h) => element("rect", { x: 1e3 * x, y: 1e3 * y, width: 1e3 * w, height: 1e3 * h });
      wall.replaceChildren(rect(-L, -R - thick, 2 * L, thick), rect(-L, R, 2 * L, thick));
      journal.replaceChildren(rect(-long, -r, 2 * long, 2 * r), element("line", { x1: -1060 * long, x2: 1060 * long }));
      journal.setAttribute("transform", `rotate(${-180 / Math.PI * psi})`);
      axis.setAttribute("x1", -1e3 * wide);
      axis.setAttribute("x2", 1e3 * wide);
      const dot = (x, y, size, kind) => element("circle", { class: kind, cx: 1e3 * x, cy: 1e3 * y, r: 1e3 * size });
      const offset = L * Math.tan(psi), size = 0.02 * wide;
      marks.replaceChildren(dot(L, -R, size, "touch"), dot(-L, R, size, "touch"), dot(0, 0, 0.8 * size, "point"), dot(L, -offset, 0.8 * size, "point"), dot(-L, offset, 0.8 * size, "point"));
    };
    box.addEventListener("change", show);
    return { made: element("figure", { class: "joint" }, picture, words, ...wider), show };
  }

  function jointOf(set) {
    const value = (name) => (set[name] ? set[name].nominal : data.joint[name]);
    return { R: value("bearing_radius"), r: value("journal_radius"), L: value("half_length") };
  }

  // ---- cost

  const costOf = (set) => arithmetic.costOf(choices, set);

  // Where the zone of a choice goes with one of its options, all else as it is set.
  function withOption(choice, option) {
    const set = sets[choice.dimension];
    const nominal = option.nominal === undefined ? set.nominal + choice.slope * (option.width - set.width) : option.nominal;
    return { ...sets, [choice.dimension]: { nominal, width: option.width, size: option.size ?? null } };
  }

  function costPicture() {
    const lines = element("g"), dot = element("circle", { class: "here", r: 5 }), bar = element("line", { class: "here" });
    const picture = element("svg", { viewBox: "-44 -6 350 170", role: "img" }, element("rect", { class: "frame", width: 300, height: 156 }), lines, bar, dot);
    const bottom = element("div", { class: "axis" }), words = element("figcaption");
    const head = element("text", { x: -5, y: 10 }), foot = element("text", { x: -5, y: 155 });
    picture.append(head, foot);
    const made = element("figure", { class: "cost" }, element("figcaption", {}, element("b", {}, "Cost against yield")), picture, bottom, words);
    const show = (now) => {
      made.hidden = limits().length === 0;
      if (made.hidden) return;
      const here = costOf(sets), first = costOf(studySets());
      const curves = choices.map((choice) => choice.options.map((option) => {
        const set = withOption(choice, option);
        return [costOf(set), predicted(set, limits(), true).found.value];
      }));
      const all = curves.flat().filter(([c, y]) => Number.isFinite(c) && Number.isFinite(y));
      const known = Number.isFinite(here);
      if (known) all.push([here, now.low], [here, now.high]);
      const span = (values) => {
        const low = Math.min(...values), high = Math.max(...values), margin = 0.06 * (high - low) || 0.5;
        return [low - margin, high + margin];
      };
      const [left, right] = span(all.map(([c]) => c)), [low, top] = span(all.map(([, y]) => y));
      const high = Math.min(top, 1 + 0.04 * (1 - low));
      const x = (c) => 300 * (c - left) / (right - left), y = (share) => 156 * (high - share) / (high - low);
      lines.replaceChildren(...curves.flatMap((curve, i) => {
        const place = dimensions.findIndex((d) => d.name === choices[i].dimension) % 6;
        const points = curve.filter(([c, s]) => Number.isFinite(c + s)).map(([c, s]) => [x(c).toFixed(1), y(s).toFixed(1)]);
        return [element("polyline", { class: `of-${place}`, points: points.map((p) => p.join(",")).join(" ") }),
          ...points.map(([cx, cy]) => element("circle", { class: `of-${place}`, cx, cy, r: 2.4 }))];
      }));
      for (const [part, attributes] of [[dot, { cx: x(here), cy: y(now.value) }], [bar, { x1: x(here), x2: x(here), y1: y(now.low), y2: y(now.high) }]]) {
        part.toggleAttribute("hidden", !known);
        if (known) Object.entries(attributes).forEach(([name, value]) => part.setAttribute(name, value.toFixed(1)));
      }
      bottom.replaceChildren(element("span", {}, number(left, 3)), element("span", {}, "cost of a piece"), element("span", {}, number(right, 3)));
      head.textContent = `${number(100 * Math.min(high, 1), 4)} %`;
      foot.textContent = `${number(100 * low, 4)} %`;
      words.textContent = `${known ? `Cost ${number(here, 4)}` : "The cost of what is set is not known: a zone is narrower than all on offer"}` +
        ` (the study: ${number(first, 4)}). Each line: one dimension through what is on offer, the others as they are set.` +
        (choices.some((choice) => choice.costs) ? " A width between two grades costs what the finer one does." : "");
      picture.setAttribute("aria-label", `Yield over cost. ${words.textContent}`);
      picture.dataset.cost = here;
    };
    return { made, show };
  }

  const noCosts = () => element("p", { class: "further small soft" },
    "No costs: where [allocation.dimensions] of the study prices tolerances, cost against yield stands here.");

  // ---- what is shown of a state

  const predicted = (set, of = limits(), limitedAlone = false) => arithmetic.predicted(data, set, of, limitedAlone);

  const showing = [];
  const first = predicted(sets);
  const panels = outputs.map(panel);
  const joint = jointPicture();
  const cost = choices.length && !data.unknown ? costPicture() : null;
  const share = element("output", { class: "share" }), interval = element("span"), afterTarget = element("span"), verdict = element("b"), beside = element("p", { class: "small soft" });
  const target = element("input", { type: "number", step: "any", min: 0, max: 100, "aria-label": "Share of the parts that is asked for, %" });
  if (!data.targetMoves) target.readOnly = true;
  const warning = element("p", { class: "warning", hidden: "" });
  const status = element("p", { class: "unseen", role: "status", "aria-live": "polite" });
  const text = element("textarea", { readonly: "", rows: 14, "aria-label": "The study as it is set", spellcheck: "false" });

  function showYield({ found, usable }) {
    const assembled = usable.reduce((sum, x) => sum + x, 0);
    const fewer = assembled < usable.length ? ` ${number(100 * (1 - assembled / usable.length), 3)} % of the parts have no clearance.` : "";
    const none = data.unknown || limits().length === 0;
    [target, afterTarget, verdict.parentElement].forEach((part) => { part.hidden = none; });
    beside.textContent = isStudy() ? "As in the study." : data.limits.length && !data.unknown ? `The study: ${percent(first.found)[0]} %.` : "";
    if (none) {
      share.textContent = "\u2013";
      const why = data.unknown ? `No yield: ${data.unknown} cannot be explored (see below).` : "No limit is set, so that there is no yield: give one below an output.";
      interval.replaceChildren(...labelled(why + fewer));
      return;
    }
    const [value, low, high] = percent(found);
    const tone = data.undecided ? ["open", "not decided: the section matters"] : found.low >= asked.target ? ["good", "met"] : found.high < asked.target ? ["bad", "not met"] : ["open", "not decided"];
    share.textContent = `${value} %`;
    Object.assign(share.dataset, { value: found.value, low: found.low, high: found.high });
    interval.textContent = `of the parts keep every limit (${low} to ${high} %); `;
    if (document.activeElement !== target) target.value = clean(100 * asked.target);
    afterTarget.textContent = ` % are asked for.${fewer}`;
    verdict.textContent = tone[1];
    verdict.parentElement.className = `verdict ${tone[0]}`;
  }

  target.addEventListener("input", () => {
    const wanted = Number(target.value) / 100;
    if (!(wanted > 0 && wanted < 1)) return;
    asked.target = Math.abs(wanted - data.target) <= 1e-12 ? data.target : wanted;
    changed();
  });
  target.addEventListener("blur", () => { target.value = clean(100 * asked.target); });

  function showRange({ columns }) {
    const far = dimensions
      .map((d, j) => [d, arithmetic.shareOutside(columns[j], d.low, d.high)])
      .filter(([, outside]) => outside > 0)
      .map(([d, outside]) => `${number(100 * outside, 2)} % of the parts by the ${lower(d.label)} (trained from ${number(d.factor * d.low, 6)} to ${number(d.factor * d.high, 6)} ${d.shownUnit})`);
    root.classList.toggle("outside", far.length > 0);
    warning.hidden = far.length === 0;
    warning.textContent = `Outside of where the polynomials were trained: ${far.join("; ")}. What is grey is a guess: run the study.`;
  }

  const isStudy = () => asked.target === data.target
    && outputs.every(({ min, max }, i) => asked.ends[i].min === min && asked.ends[i].max === max)
    && dimensions.every((d) => sets[d.name].nominal === d.nominal && sets[d.name].width === d.upper - d.lower);

  function update() {
    const start = performance.now();
    const now = predicted(sets);
    showYield(now);
    showRange(now);
    panels.forEach(({ show }, i) => show(now.outputs[i], first.outputs[i], now.usable, first.usable));
    joint.show();
    showing.forEach((show) => show());
    text.value = studyText.study(data, byName, sets, asked);
    root.classList.toggle("changed", !isStudy());
    root.dataset.milliseconds = performance.now() - start;
    later(now);
  }

  // What takes longer, or would be read aloud at every step of a slider, waits until nothing moves.
  let waiting = 0;
  function later(now) {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      if (cost) cost.show(now.found);
      const wanted = target.hidden ? "" : `${target.value}${afterTarget.textContent} ${verdict.textContent}.`;
      status.textContent = `${share.textContent} ${interval.textContent}${wanted} ${warning.hidden ? "" : warning.textContent}`;
    }, 250);
  }

  let frame = 0;
  function changed() {
    cancelAnimationFrame(frame);
    frame = requestAnimationFrame(update);
  }

  async function copy() {
    try {
      await navigator.clipboard.writeText(text.value);
    } catch {
      // Pages from a mail may not reach the clipboard but by a selection.
      text.closest("details").open = true;
      text.select();
      document.execCommand("copy");
    }
    copied.textContent = "Copied.";
    setTimeout(() => { copied.textContent = ""; }, 3000);
  }

  const copied = element("span", { role: "status", class: "small" });
  function build() {
    const reset = element("button", { type: "button", id: "explorer-reset" }, "Back to the study");
    reset.addEventListener("click", () => {
      sets = studySets();
      asked = studyAsked();
      changed();
    });
    const take = element("button", { type: "button", id: "explorer-copy" }, "Copy study");
    take.addEventListener("click", copy);
    const others = panels.filter(({ isForemost }) => !isForemost);
    document.getElementById("explorer-page").append(
      element("div", { class: "yield" }, share, element("div", {}, element("p", {}, interval, target, afterTarget), beside), element("span", { class: "verdict" }, verdict)),
      warning, status,
      element("div", { class: "explored" },
        element("div", { class: "controls" }, ...dimensions.map(controls),
          element("p", { class: "buttons" }, take, reset, copied),
          element("details", {}, element("summary", {}, "The study as it is set"), text)),
        element("div", { class: "results" },
          joint.made, ...(cost ? [cost.made] : []), ...panels.filter(({ isForemost }) => isForemost).map(({ made }) => made),
          ...(others.length ? [element("details", { class: "further" }, element("summary", {}, `Further outputs (${others.length})`),
            element("div", { class: "results" }, ...others.map(({ made }) => made)))] : []),
          ...(choices.length ? [] : [noCosts()]))));
    root.hidden = false;
    update();
  }

  build();
})();
