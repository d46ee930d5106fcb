"use strict";
// Elements of the explorer's page, and numbers as people read them.

const elements = (() => {
  function element(tag, attributes = {}, ...children) {
    const svg = ["svg", "path", "line", "circle", "rect", "g", "polyline", "text"].includes(tag);
    const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (value !== null && value !== undefined) made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }

  const minus = (text) => text.replace("-", "\u2212");
  const number = (value, digits = 5) => (Number.isFinite(value) ? minus(studyText.decimal(value, digits)) : "\u2013");
  const fixed = (value, places) => minus(value.toFixed(Math.min(Math.max(places, 0), 9)));
  const places = (step) => (step > 0 ? 1 - Math.floor(Math.log10(step)) : 4);

  function percent({ value, low, high }) {
    let digits = Math.min(places(100 * (high - low)), 4);
    while (value < 1 && digits < 4 && Number((100 * value).toFixed(Math.max(digits, 0))) === 100) digits++;
    return [value, low, high].map((share) => fixed(100 * share, share === 0 || share === 1 ? 0 : digits));
  }

  // The contact forces of a label set as symbols.
  function labelled(text) {
    const parts = text.split(/N_([DE])/);
    return parts.flatMap((part, i) => (i % 2 ? [element("i", {}, "N"), element("sub", {}, part)] : [part]));
  }

  // The largest of 1, 2, 5 times a power of ten that is no larger.
  function round(value) {
    const power = 10 ** Math.floor(Math.log10(value));
    const lead = value / power;
    return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
  }

  // A step of about a fiftieth of a width that divides it.
  function stepOf(width) {
    let step = round(width / 40);
    for (let i = 0; i < 3 && Math.abs(width / step - Math.round(width / step)) > 1e-6; i++) step /= 10;
    return Number(step.toPrecision(6));
  }

  // A number without what rounding leaves of it.
  const clean = (value) => Number(value.toPrecision(10));

  const lower = (text) => text[0].toLowerCase() + text.slice(1);

  return { element, number, fixed, places, percent, labelled, round, stepOf, clean, lower };
})();
