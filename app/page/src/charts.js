// SPDX-License-Identifier: Apache-2.0
// Plots: lines over time, a trail of accuracy against time, a histogram. The drawing is uPlot's.

import uPlot from 'uplot';

import {fixed, short, superscript} from './format.js';
import {themed} from './colors.js';
import {events} from './events.js';

const kFont = '10.5px system-ui, "DejaVu Sans", sans-serif';

const axis = (more) => ({
  stroke: () => themed('--muted'),
  grid: {stroke: () => themed('--line'), width: 1},
  ticks: {show: false},
  font: kFont,
  ...more,
});

/** A plot that is as large as the element it makes in `parent`. */
function plotIn(parent, options, data, name) {
  const element = document.createElement('div');
  element.className = 'chart';
  parent.append(element);
  if (name) {
    const text = document.createElement('span');
    text.className = 'name';
    text.textContent = name.text;
    text.style.setProperty('--color', name.color);
    element.append(text);
  }
  const size = () => ({width: Math.max(40, element.clientWidth), height: Math.max(40, element.clientHeight)});
  const plot = new uPlot({
    ...size(),
    legend: {show: false},
    cursor: {show: false},
    padding: [6, 14, 0, 0],
    ...options,
  }, data, element);
  new ResizeObserver(() => {
    const {width, height} = size();
    if (width !== plot.width || height !== plot.height) plot.setSize({width, height});
  }).observe(element);
  const theme = matchMedia('(prefers-color-scheme: dark)');
  const redraw = () => plot.redraw(false);
  theme.addEventListener('change', redraw);
  const destroy = () => {
    theme.removeEventListener('change', redraw);
    plot.destroy();
  };
  return {plot, element, destroy, shown: () => element.clientHeight > 0};
}

/** What is said of the values under the pointer: one for all plots, over the page. */
function reading() {
  const shown = document.getElementById('reading') ?? document.body.appendChild(document.createElement('table'));
  shown.id = 'reading';
  return shown;
}

/** The row of a sorted column that is nearest to a value. */
export function nearestRow(column, value) {
  let low = 0;
  let high = column.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (column[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low > 0 && value - column[low - 1] < column[low] - value ? low - 1 : low;
}

/**
 * Signals over time. `series`: [{color, dashed, name}]; `floor`: the least range of the values; `unit`: theirs; `named`:
 * events have their words here, beside their lines. Under the pointer there is a line in all of them, and its plot's
 * values are said.
 */
export class TimeChart {
  constructor(parent, {series, floor, name, unit, times, named = false}) {
    this.series = series;
    this.unit = unit;
    this.columns = [[0]];
    this.begin_s = 0;
    this.end_s = 1;
    this.view = plotIn(parent, {
      cursor: {y: false, points: {show: false}, drag: {x: false, y: false}, sync: {key: 'time'}},
      hooks: {setCursor: [() => this.#read()], draw: [(plot) => drawEvents(plot, named)]},
      scales: {
        x: {time: false, range: () => [this.begin_s, this.end_s]},
        y: {range: (_, low, high) => spread(low, high, floor)},
      },
      axes: [
        axis({size: times ? 20 : 6, gap: 2, space: 40, values: times ? undefined : (_, ticks) => ticks.map(() => '')}),
        axis({size: 32, gap: 3, space: 20}),
      ],
      series: [{}, ...series.map(({color, dashed}) => ({
        stroke: () => themed(color),
        width: dashed ? 1.2 : 1.8,
        dash: dashed ? [7, 3, 2, 3] : undefined,
        points: {show: false},
      }))],
    }, [[0], ...series.map(() => [null])], name);
    this.view.plot.over.addEventListener('mouseleave', () => (reading().hidden = true));
  }

  /** `columns`: of a History, which looks so many `seconds` back. */
  set(columns, seconds) {
    if (!this.view.shown()) return;
    const first_s = columns[0][0] ?? 0;
    this.columns = columns;
    this.end_s = Math.max(columns[0].at(-1) ?? 0, first_s + 1);
    this.begin_s = Math.max(first_s, this.end_s - seconds);
    this.view.plot.setData(columns);
    this.#read();
  }

  /** Says the values under the pointer, if it is over this plot. */
  #read() {
    const plot = this.view?.plot;
    if (!plot?.over.matches(':hover') || !(plot.cursor.left >= 0)) return;
    const row = nearestRow(this.columns[0], plot.posToVal(plot.cursor.left, 'x'));
    const time = document.createElement('caption');
    time.textContent = `${fixed(this.columns[0][row], 3)} s`;
    const rows = this.series.map(({color, dashed, name}, i) => {
      const line = document.createElement('tr');
      const sample = line.insertCell().appendChild(document.createElement('i'));
      sample.className = `line${dashed ? ' dashed' : ''}`;
      sample.style.borderTopColor = `var(${color})`;
      line.insertCell().textContent = name;
      line.insertCell().textContent = `${short(this.columns[1 + i]?.[row] ?? NaN)} ${this.unit}`;
      return line;
    });
    const shown = reading();
    shown.replaceChildren(time, ...rows);
    shown.hidden = false;
    const box = plot.over.getBoundingClientRect();
    const x = box.left + plot.cursor.left;
    const width = shown.offsetWidth + 14;
    shown.style.left = `${x - width < 0 ? x + 14 : x - width}px`;
    shown.style.top = `${Math.max(4, Math.min(box.top + plot.cursor.top - 20, innerHeight - shown.offsetHeight - 4))}px`;
  }
}

const kWord_px = 11; // height of a row of words

/** Thin lines where something happened, and beside them what, in two rows; words that would cover others are left out. */
function drawEvents(plot, named) {
  const {ctx, bbox} = plot;
  const pixels = devicePixelRatio;
  const free = [bbox.left, bbox.left]; // from where on each row is, the lower one first
  ctx.save();
  ctx.font = `${10 * pixels}px system-ui, "DejaVu Sans", sans-serif`;
  ctx.textAlign = 'left';
  ctx.textBaseline = 'bottom';
  for (const {time_s, what} of events.list) {
    const x = Math.round(plot.valToPos(time_s, 'x', true));
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.strokeStyle = ctx.fillStyle = themed('--muted');
    ctx.lineWidth = pixels;
    ctx.setLineDash([2 * pixels, 2 * pixels]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    const wide = ctx.measureText(what).width;
    const room = bbox.left + bbox.width - x; // words near the right edge stand at the left of their line
    const begin = room > wide + 4 * pixels ? x + 3 * pixels : x - wide - 3 * pixels;
    const row = free.findIndex((from) => from <= begin);
    if (!named || row < 0) continue;
    const place = [what, begin, bbox.top + bbox.height - pixels - row * kWord_px * pixels];
    ctx.setLineDash([]);
    ctx.strokeStyle = themed('--panel'); // around the letters, so that curves do not cross them
    ctx.lineWidth = 3 * pixels;
    ctx.strokeText(...place);
    ctx.fillText(...place);
    free[row] = begin + wide + 4 * pixels;
  }
  ctx.restore();
}

function spread(low, high, floor) {
  if (low === null || high === null || !Number.isFinite(low + high)) return floor;
  const a = Math.min(low, floor[0]);
  const b = Math.max(high, floor[1]);
  const room = 0.06 * (b - a);
  // Above there is a name to be read.
  return [low < floor[0] ? a - room : a, high > floor[1] ? b + 3 * room : b];
}

/** Microseconds across, relative error upwards, both logarithmic: where the loop is, and where it came from. */
export class AccuracyTrail {
  #points = []; // {time_s, x, y}

  constructor(parent, seconds) {
    this.seconds = seconds;
    const log = (range) => ({time: false, distr: 3, log: 10, range: () => range});
    this.view = plotIn(parent, {
      scales: {x: log([10, 1000]), y: log([1e-9, 1])},
      axes: [
        axis({size: 20, gap: 2, splits: () => [10, 100, 1000], filter: all, values: () => ['10 µs', '100', '1000']}),
        axis({size: 42, gap: 3, splits: () => [1e-8, 1e-6, 1e-4, 1e-2, 1], filter: all, values: (_, ticks) => ticks.map(label)}),
      ],
      series: [{}, {show: true, points: {show: false}, paths: () => null}],
      hooks: {draw: [(plot) => this.#draw(plot)]},
    }, [[10, 1000], [1e-9, 1]]);
    this.empty = document.createElement('span');
    this.empty.className = 'empty';
    this.empty.textContent = 'not measured';
    this.view.element.append(this.empty);
  }

  clear() {
    this.#points = [];
  }

  add(time_s, x, y) {
    this.#points = this.#points.filter((p) => p.time_s > time_s - this.seconds && p.time_s <= time_s);
    const last = this.#points.at(-1);
    if (x > 0 && y > 0 && !(last && last.x === x && last.y === y)) this.#points.push({time_s, x, y});
    this.empty.hidden = this.#points.length > 0;
  }

  set() {
    if (this.view.shown()) this.view.plot.redraw(false);
  }

  #draw(plot) {
    const {ctx} = plot;
    const last = this.#points.at(-1);
    if (!last) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    ctx.clip();
    ctx.fillStyle = ctx.strokeStyle = themed('--accent');
    for (const point of this.#points) {
      ctx.globalAlpha = point === last ? 1 : 0.12 + 0.4 * (1 - (last.time_s - point.time_s) / this.seconds);
      ctx.beginPath();
      ctx.arc(plot.valToPos(clamp(point.x, 10, 1000), 'x', true), plot.valToPos(clamp(point.y, 1e-9, 1), 'y', true),
              (point === last ? 4.5 : 2.2) * devicePixelRatio, 0, 7);
      ctx.fill();
    }
    ctx.restore();
  }
}

const all = (_, ticks) => ticks; // uPlot would leave out some of a logarithmic axis
const label = (x) => (x === 1 ? '1' : `10${superscript(Math.round(Math.log10(x)))}`);
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

/** Counts in bins of a factor sqrt(2) from 50 us on; the first and the last are open. Lines: p50 and p99. */
export class LatencyChart {
  constructor(parent, bins) {
    this.edges_us = Array.from({length: bins}, (_, i) => 50 * 2 ** ((i - 1) / 2));
    this.marks_us = [];
    const place = (us) => 1 + 2 * Math.log2(us / 50); // in bins
    this.view = plotIn(parent, {
      scales: {
        x: {time: false, range: () => [-0.2, bins + 0.2]},
        y: {range: (_, low, high) => [0, Math.max(1, high)]},
      },
      axes: [
        axis({size: 20, gap: 2, splits: () => [100, 1e3, 1e4, 1e5].map(place), grid: {show: false},
              values: () => ['0.1 ms', '1', '10', '100']}),
        axis({size: 32, gap: 3, space: 20, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5, 1e6]}),
      ],
      series: [{}, {
        fill: () => themed('--accent'),
        stroke: () => themed('--accent'),
        width: 0,
        paths: uPlot.paths.bars({size: [0.86], align: 1}),
        points: {show: false},
      }],
      hooks: {draw: [(plot) => {
        const {ctx, bbox} = plot;
        ctx.save();
        ctx.strokeStyle = themed('--tangential');
        ctx.lineWidth = 1.5 * devicePixelRatio;
        for (const us of this.marks_us) {
          if (!(us > 0)) continue;
          const x = plot.valToPos(clamp(place(us), 0, bins), 'x', true);
          ctx.beginPath();
          ctx.moveTo(x, bbox.top);
          ctx.lineTo(x, bbox.top + bbox.height);
          ctx.stroke();
        }
        ctx.restore();
      }]},
    }, [Array.from({length: bins}, (_, i) => i), Array(bins).fill(0)]);
    this.empty = document.createElement('span');
    this.empty.className = 'empty';
    this.empty.textContent = 'no input yet';
    this.view.element.append(this.empty);
  }

  set(counts, marks_us) {
    this.empty.hidden = counts.some((count) => count > 0);
    this.marks_us = marks_us;
    if (this.view.shown()) this.view.plot.setData([this.view.plot.data[0], Array.from(counts)]);
  }
}
