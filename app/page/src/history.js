// SPDX-License-Identifier: Apache-2.0
// What plots over time remember: the least and the largest value of each span of time, in so many spans that a plot
// shows them all. So a spike is kept, and neither memory nor drawing grow with the time that is looked at.

export const kSpans = 300; // at most, but for one before the plot and those that one more value begins

/** A span: [begin_s, end_s], of each signal its lowest and highest value (NaN: none) and whether the lowest came first. */
function spanOf(time_s, values) {
  return {begin_s: time_s, end_s: time_s, low: Float64Array.from(values), high: Float64Array.from(values),
          lowFirst: new Uint8Array(values.length).fill(1)};
}

/** Takes a later span into an earlier one. */
function join(span, later) {
  span.end_s = later.end_s;
  for (let i = 0; i < span.low.length; ++i) {
    if (Number.isNaN(later.low[i])) continue;
    const none = Number.isNaN(span.low[i]);
    const lower = none || later.low[i] < span.low[i];
    const higher = none || later.high[i] > span.high[i];
    if (lower && higher) span.lowFirst[i] = later.lowFirst[i];
    else if (lower) span.lowFirst[i] = 0;
    else if (higher) span.lowFirst[i] = 1;
    if (lower) span.low[i] = later.low[i];
    if (higher) span.high[i] = later.high[i];
  }
}

/** The last `seconds` of some signals; Infinity: all of them. */
export class History {
  #spans = [];
  #span_s;

  constructor(signals, seconds) {
    this.signals = signals;
    this.seconds = seconds;
    this.clear();
  }

  clear() {
    this.#spans = [];
    this.#span_s = Number.isFinite(this.seconds) ? this.seconds / kSpans : 0;
  }

  /** One value of each signal; what is not finite is a gap. A time before the last one begins anew. */
  add(time_s, values) {
    const last = this.#spans.at(-1);
    if (time_s === last?.end_s) return;
    if (time_s < last?.end_s) this.clear(); // the simulation was set back
    const one = spanOf(time_s, Array.from(values, (x) => (Number.isFinite(x) ? x : NaN)));
    // A jot less, so that values at every 10 ms fill spans of 10 ms with one each.
    if (last && this.#spans.length > 0 && time_s - last.begin_s < this.#span_s * (1 - 1e-9)) join(last, one);
    else this.#spans.push(one);
    // One from before stays, from which the line comes into the plot: values may be rarer than it is long.
    while (this.#spans.length > 1 && this.#spans[1].end_s < time_s - this.seconds) this.#spans.shift();
    if (this.#spans.length > kSpans + 2) this.#halve();
  }

  /** Two spans become one. */
  #halve() {
    const halved = [];
    this.#spans.forEach((span, i) => (i % 2 ? join(halved.at(-1), span) : halved.push(span)));
    this.#spans = halved;
    this.#span_s = (2 * (halved.at(-1).begin_s - halved[0].begin_s)) / halved.length;
  }

  /** Columns for a plot: times, then each signal: at most two numbers a span, `null` in gaps. */
  columns() {
    const columns = Array.from({length: 1 + this.signals}, () => []);
    const value = (x) => (Number.isNaN(x) ? null : x);
    for (const {begin_s, end_s, low, high, lowFirst} of this.#spans) {
      const two = end_s > begin_s;
      columns[0].push(begin_s);
      if (two) columns[0].push(end_s);
      for (let i = 0; i < this.signals; ++i) {
        columns[1 + i].push(value(lowFirst[i] ? low[i] : high[i]));
        if (two) columns[1 + i].push(value(lowFirst[i] ? high[i] : low[i]));
      }
    }
    return columns;
  }
}

/** Histories of several lengths, of which one is looked at. */
export class Histories {
  constructor(signals, lengths_s) {
    this.all = new Map(lengths_s.map((seconds) => [seconds, new History(signals, seconds)]));
  }

  add(time_s, values) {
    for (const history of this.all.values()) history.add(time_s, values);
  }

  clear() {
    for (const history of this.all.values()) history.clear();
  }

  columns(seconds) {
    return this.all.get(seconds).columns();
  }
}
