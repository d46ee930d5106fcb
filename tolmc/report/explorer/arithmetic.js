"use strict";
// The arithmetic of the explorer: pure functions of numbers and typed arrays, SI units, nothing of the page.
// It evaluates what tolmc evaluates, in the same order of operations but for sums, which agree to rounding.

const arithmetic = (() => {
  // Rows whose basis values stay in the second-level cache.
  const CHUNK = 256;
  // Independent groups of rows: the scramblings of a Sobol' run.
  const GROUPS = 16;
  const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

  // Doubles, least significant byte first, from base64.
  function doubles(text) {
    const value = new Uint8Array(128);
    for (let i = 0; i < 64; i++) value[DIGITS.charCodeAt(i)] = i;
    const length = text.endsWith("==") ? text.length - 2 : text.endsWith("=") ? text.length - 1 : text.length;
    const bytes = new Uint8Array(Math.floor(length * 3 / 4));
    let bits = 0, kept = 0, at = 0;
    for (let i = 0; i < length; i++) {
      bits = ((bits << 6) | value[text.charCodeAt(i)]) & 0xffff;
      kept += 6;
      if (kept >= 8) {
        kept -= 8;
        bytes[at++] = (bits >> kept) & 0xff;
      }
    }
    const view = new DataView(bytes.buffer);
    return Float64Array.from({ length: bytes.length >> 3 }, (_, i) => view.getFloat64(8 * i, true));
  }

  // Largest tilt of the journal's axis, equation (2): R cos psi - L sin psi - r = 0 by the half-angle form.
  function tiltAngle(R, r, L) {
    const clearance = R - r;
    return 2 * Math.atan(clearance / (L + Math.sqrt(L * L + clearance * (R + r))));
  }

  // Radius of the circles on which the axis rests, equation (3): L tan psi.
  function effectiveRadius(R, r, L) {
    const squares = (R - r) * (R + r);
    return squares * L / (R * L + r * Math.sqrt(L * L + squares));
  }

  // A dimension of all parts: deviations in widths of its zone, times the width, about the nominal value.
  function values(deviations, nominal, width) {
    const found = new Float64Array(deviations.length);
    for (let i = 0; i < found.length; i++) found[i] = nominal + deviations[i] * width;
    return found;
  }

  // 1 where bore and journal leave a clearance.
  function withClearance(bearing, journal) {
    const found = new Uint8Array(bearing.length);
    for (let i = 0; i < found.length; i++) found[i] = bearing[i] > journal[i] ? 1 : 0;
    return found;
  }

  // Share of a dimension's parts that lie outside the range low to high.
  function shareOutside(x, low, high) {
    let count = 0;
    for (let i = 0; i < x.length; i++) if (x[i] < low || x[i] > high) count++;
    return count / x.length;
  }

  // Chebyshev polynomials T_0 ... T_degree of x, a row after the other in `into`.
  function chebyshev(x, rows, degree, into) {
    for (let i = 0; i < rows; i++) into[i] = 1;
    if (degree > 0) for (let i = 0; i < rows; i++) into[CHUNK + i] = x[i];
    for (let p = 2; p <= degree; p++) {
      const at = p * CHUNK, one = at - CHUNK, two = one - CHUNK;
      for (let i = 0; i < rows; i++) into[at + i] = into[one + i] * (2 * x[i]) - into[two + i];
    }
  }

  // sum of c_t basis_t over the first terms, four at a time.
  function combine(coefficients, start, terms, basis, rows, into, offset) {
    for (let i = 0; i < rows; i++) into[offset + i] = 0;
    let t = 0;
    for (; t + 4 <= terms; t += 4) {
      const a = coefficients[start + t], b = coefficients[start + t + 1];
      const c = coefficients[start + t + 2], d = coefficients[start + t + 3];
      const at = t * CHUNK, bt = at + CHUNK, ct = bt + CHUNK, dt = ct + CHUNK;
      for (let i = 0; i < rows; i++) {
        into[offset + i] += a * basis[at + i] + b * basis[bt + i] + c * basis[ct + i] + d * basis[dt + i];
      }
    }
    for (; t < terms; t++) {
      const a = coefficients[start + t], at = t * CHUNK;
      for (let i = 0; i < rows; i++) into[offset + i] += a * basis[at + i];
    }
  }

  // Outputs (a Float64Array each) of the polynomials at the columns of the varied dimensions.
  // model: low, high (of each dimension), steps (parent, dimension, power of each term after the first), terms of each output,
  // coefficients (outputs one after the other, `stride` apart). `chosen`: places of the outputs that are wanted.
  function predict(model, columns, chosen = model.terms.map((_, i) => i)) {
    const rows = columns[0].length;
    const found = chosen.map(() => new Float64Array(rows));
    const most = Math.max(0, ...chosen.map((output) => model.terms[output]));
    const degree = model.degree;
    const basis = new Float64Array(Math.max(most, 1) * CHUNK).fill(1);
    const powers = columns.map(() => new Float64Array((degree + 1) * CHUNK));
    const x = new Float64Array(CHUNK);
    for (let start = 0; start < rows; start += CHUNK) {
      const count = Math.min(CHUNK, rows - start);
      columns.forEach((column, j) => {
        const sum = model.low[j] + model.high[j], width = model.high[j] - model.low[j];
        for (let i = 0; i < count; i++) x[i] = (2 * column[start + i] - sum) / width;
        chebyshev(x, count, degree, powers[j]);
      });
      for (let t = 1; t < most; t++) {
        const [parent, j, power] = model.steps[t - 1];
        const of = powers[j], at = t * CHUNK, from = parent * CHUNK, by = power * CHUNK;
        for (let i = 0; i < count; i++) basis[at + i] = basis[from + i] * of[by + i];
      }
      chosen.forEach((output, k) =>
        combine(model.coefficients, output * model.stride, model.terms[output], basis, count, found[k], start));
    }
    return found;
  }

  // How many parts of each group keep every limit, each limit moved inwards by `margin` (negative: outwards) of its output.
  // limits: [{output (place in outputs), min, max (null: none), margin}]; usable: 0 where a part cannot be assembled.
  function conforming(outputs, limits, usable, times = 0) {
    const counts = new Float64Array(GROUPS);
    for (let i = 0; i < usable.length; i++) {
      let kept = usable[i];
      for (const { output, min, max, margin } of limits) {
        const value = outputs[output][i];
        if ((max !== null && !(value <= max - times * margin)) || (min !== null && !(value >= min + times * margin))) kept = 0;
      }
      counts[i % GROUPS] += kept;
    }
    return counts;
  }

  const total = (counts) => counts.reduce((sum, count) => sum + count, 0);

  // How many independent parts would know the share of `counts` as well as parts of a Sobol' run do: from the scatter among its
  // scramblings, whose few degrees of freedom count by the normal's 97.5 % quantile over Student's with 15 of them.
  function effectiveCount(counts, parts) {
    const share = total(counts) / parts, binomial = share * (1 - share);
    if (!(binomial > 0)) return parts;
    let squares = 0;
    counts.forEach((count, group) => { squares += (count - share * Math.ceil((parts - group) / GROUPS)) ** 2; });
    const variance = GROUPS / (GROUPS - 1) * squares / parts ** 2;
    return (1.959963984540054 / 2.131449545559323) ** 2 * binomial / Math.max(variance, Math.min(binomial / parts, 1 / parts ** 2));
  }

  // Interval of a share from a count (Wilson 1927), z standard deviations wide; the numbers may be fractional.
  function wilson(count, total, z = 1.959963984540054) {
    const share = count / total, square = z * z / total;
    const middle = (share + square / 2) / (1 + square);
    const half = z * Math.sqrt(share * (1 - share) / total + square / (4 * total)) / (1 + square);
    return [count === 0 ? 0 : Math.max(middle - half, 0), count === total ? 1 : Math.min(middle + half, 1)];
  }

  // Share of the parts that keep every limit, with an interval of the sampling that holds the error of the polynomials too: limits
  // moved by twice their held-out error, inwards for the lower end and outwards for the upper one. `independent`: how many of
  // the parts stand for themselves; null for those of a Sobol' run.
  function yieldOf(outputs, limits, usable, independent) {
    const parts = usable.length;
    const bounds = (times) => {
      const counts = conforming(outputs, limits, usable, times), size = independent ?? effectiveCount(counts, parts);
      return wilson(size * total(counts) / parts, size);
    };
    return { value: total(conforming(outputs, limits, usable)) / parts, low: bounds(2)[0], high: bounds(-2)[1] };
  }

  // Mean, standard deviation, smallest and largest of the usable values.
  function summary(x, usable) {
    let n = 0, sum = 0, min = Infinity, max = -Infinity;
    for (let i = 0; i < x.length; i++) {
      if (!usable[i]) continue;
      n++;
      sum += x[i];
      if (x[i] < min) min = x[i];
      if (x[i] > max) max = x[i];
    }
    const mean = sum / n;
    let squares = 0;
    for (let i = 0; i < x.length; i++) if (usable[i]) squares += (x[i] - mean) * (x[i] - mean);
    return { n, mean, sd: Math.sqrt(squares / (n - 1)), min, max };
  }

  // Usable values in equal bins from low to high; those beyond are left out.
  function histogram(x, usable, low, high, bins) {
    const counts = new Float64Array(bins), scale = bins / (high - low);
    for (let i = 0; i < x.length; i++) {
      const place = Math.floor((x[i] - low) * scale);
      if (usable[i] && place >= 0 && place < bins) counts[place]++;
    }
    return counts;
  }

  // For each part the class of equal size in which a dimension lies, and its group: the cell group * classes + class.
  function cells(deviations, classes, lot = 1) {
    const order = Array.from(deviations.keys()).sort((a, b) => deviations[a] - deviations[b] || a - b);
    const found = new Int32Array(order.length);
    order.forEach((row, place) => {
      found[row] = Math.floor(row / lot) % GROUPS * classes + Math.floor(place * classes / order.length);
    });
    return found;
  }

  // First-order index of a dimension: variance of the class means over that of the parts, less the scatter that the means have
  // of themselves, which follows from the groups.
  function firstOrder(x, cell, classes, usable) {
    const size = GROUPS * classes;
    const counts = new Float64Array(size), sums = new Float64Array(size);
    const { n, mean } = summary(x, usable);
    let squares = 0;
    for (let i = 0; i < x.length; i++) {
      if (!usable[i]) continue;
      const value = x[i] - mean;
      counts[cell[i]]++;
      sums[cell[i]] += value;
      squares += value * value;
    }
    let whole = 0;
    for (let k = 0; k < size; k++) whole += sums[k];
    const rest = whole / n, total = squares - n * rest * rest;
    if (!(total > 0)) return NaN;
    let between = 0;
    for (let c = 0; c < classes; c++) {
      let count = 0, sum = 0, scatter = 0;
      for (let k = c; k < size; k += classes) {
        count += counts[k];
        sum += sums[k];
      }
      if (count === 0) continue;
      const average = sum / count;
      for (let k = c; k < size; k += classes) scatter += (sums[k] - average * counts[k]) ** 2;
      between += count * ((average - rest) ** 2 - GROUPS / (GROUPS - 1) * scatter / (count * count));
    }
    return between / total;
  }

  const LAWS = { "reciprocal": (x) => 1 / x, "reciprocal-square": (x) => x ** -2, "exponential": (x) => Math.exp(1 - x) };

  // Cost of a zone: by its law, or that of the widest grade that is no wider; NaN where that is not known.
  function cost(choice, width) {
    if (choice.law) return choice.fixed + choice.variable * LAWS[choice.law](width / choice.at);
    let found = NaN;
    choice.widths.forEach((wide, i) => {
      if (wide <= width * (1 + 1e-9)) found = choice.costs[i];
    });
    return found;
  }

  // Limits by the places of their outputs, from {min, max} of every output.
  const limitsOf = (outputs, ends = outputs) => ends
    .map(({ min, max }, output) => ({ output, min, max, margin: outputs[output].margin }))
    .filter(({ min, max }) => min !== null || max !== null);

  // What the explorer keeps of its data: deviations and cells of the dimensions, the study's limits.
  function prepared(data) {
    const deviations = data.dimensions.map((d) => doubles(d.deviations));
    const classes = Math.max(2, Math.min(Math.floor(Math.sqrt(data.parts)), 256));
    return {
      ...data,
      deviations,
      classes,
      cells: deviations.map((x) => cells(x, classes, data.lot)),
      model: { ...data.model, coefficients: doubles(data.model.coefficients) },
      limits: limitsOf(data.outputs),
    };
  }

  // Dimensions (columns) and outputs of all parts, which of them have a clearance, and the yield, for a nominal value and a width
  // of every dimension: sets = {name: {nominal, width}}. `limits` in place of the study's; `limitedAlone` leaves out the outputs
  // without one.
  function predicted(kept, sets, limits = kept.limits, limitedAlone = false) {
    const columns = kept.dimensions.map((d, j) => values(kept.deviations[j], sets[d.name].nominal, sets[d.name].width));
    const column = (name) => {
      const place = kept.dimensions.findIndex((d) => d.name === name);
      return place < 0 ? new Float64Array(kept.parts).fill(kept.joint[name]) : columns[place];
    };
    const usable = withClearance(column("bearing_radius"), column("journal_radius"));
    const outputs = predict(kept.model, columns, limitedAlone ? limits.map(({ output }) => output) : undefined);
    const placed = limitedAlone ? limits.map((limit, output) => ({ ...limit, output })) : limits;
    return { columns, usable, outputs, found: yieldOf(outputs, placed, usable, kept.independent) };
  }

  // Cost of all zones that are priced.
  const costOf = (choices, sets) => choices.reduce((sum, choice) => sum + cost(choice, sets[choice.dimension].width), 0);

  return {
    tiltAngle, effectiveRadius, shareOutside, summary, histogram, firstOrder, cost, costOf, limitsOf, prepared, predicted,
  };
})();
