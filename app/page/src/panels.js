// SPDX-License-Identifier: Apache-2.0
// The panels: what the numbers of a state say, ten times a second.

import {AccuracyTrail, LatencyChart, TimeChart} from './charts.js';
import {activationColor, fingerColors} from './colors.js';
import {bar, byId, element, meterIn, setText} from './elements.js';
import {fixed, length, power, short} from './format.js';
import {events} from './events.js';
import {Histories} from './history.js';
import {StiffnessPanel, choosesStiffness, isSpent} from './stiffness.js';
import {tip} from './tips.js';
import {TouchPanel, feels} from './touch.js';

const kEvery_ms = 100;
/** How far back the plots over time may look. */
export const spans_s = [5, 20, 60, Infinity];
const kTrailSeconds = 60;
const kRed = 0.1; // a margin below it
const kFullSlip_m = 1e-3; // of the slip's bar
const kFullSpin_rad = Math.PI / 6; // of the spin's bar

export class Panels {
  advanced = 0; // how often the plots were drawn
  span_s = spans_s[0];
  #scene = null;
  #same = ''; // what the panels were made for
  forceCharts = [];
  touch = new TouchPanel();
  stiffness = new StiffnessPanel();
  #state = null;
  #timer = 0;
  #last_ms = 0;

  /** A new scene: makes what depends on its fingers, muscles and fields. */
  load(scene) {
    const same = JSON.stringify([scene.fingers.map(({name}) => name), scene.muscles, feels(scene), scene.object_stiffness]);
    this.#scene = scene;
    events.load(scene);
    if (same === this.#same) return; // another level, say: the plots go on
    this.#same = same;
    for (const chart of [...this.forceCharts, this.pathChart, this.accuracy, this.latency]) chart?.view.destroy();
    for (const id of ['forces', 'path', 'muscles', 'stages', 'accuracy', 'latency']) byId(id).replaceChildren();
    this.forces = new Histories(4 * scene.fingers.length, spans_s);
    this.path = new Histories(6, spans_s);
    this.forceCharts = scene.fingers.map(({name}, k) => new TimeChart(byId('forces'), {
      series: [
        {name: 'normal, desired', color: '--normal', dashed: true},
        {name: 'tangential, desired', color: '--tangential', dashed: true},
        {name: 'normal', color: '--normal'}, {name: 'tangential', color: '--tangential'},
      ],
      floor: [0, 1], unit: 'N', name: {text: name, color: fingerColors[k]}, times: k === scene.fingers.length - 1, named: k === 0,
    }));
    const axes = ['x', 'y', 'z'].map((name) => ({name, color: `--${name}`}));
    this.pathChart = new TimeChart(byId('path'), {
      series: [...axes.map(({name, color}) => ({name: `${name}, target`, color, dashed: true})), ...axes],
      floor: [-1, 1], unit: 'mm', times: true, named: true,
    });
    this.accuracy = new AccuracyTrail(byId('accuracy'), kTrailSeconds);
    this.latency = new LatencyChart(byId('latency'), scene.fields.find(({name}) => name === 'latency_counts').count);
    this.touch.load(scene, spans_s);
    this.stiffness.load(scene);
    this.#makeGrip();
    this.#makeMuscles();
    this.#makeStages();
    this.#makeRates();
  }

  #makeGrip() {
    const body = byId('grip').tBodies[0];
    body.replaceChildren();
    this.grip = this.#scene.fingers.map(({name}, k) => {
      const row = element('tr', '', body);
      row.style.setProperty('--color', fingerColors[k]);
      element('th', name, row).scope = 'row';
      return {margin: meterIn(row), slip: meterIn(row), spin: meterIn(row)};
    });
  }

  #makeMuscles() {
    byId('panel-muscles').hidden = this.#scene.muscles.length === 0;
    this.muscles = this.#scene.muscles.map(({name, max_force_N}) => {
      const row = element('div', '', byId('muscles'));
      row.title = `${name}: at most ${short(max_force_N)} N`;
      element('span', name, row);
      const set = bar(row);
      const [track, text] = [row.lastChild, element('span', '', row)];
      return {set, track, text, least: choosesStiffness(this.#scene) ? element('b', '', track) : null};
    });
    byId('least-legend').hidden = !choosesStiffness(this.#scene);
  }

  #makeStages() {
    const names = ['find', 'factors', 'assemble', 'solve', 'deform', 'grasp', 'muscle'];
    this.stages = names.map((name) => {
      const row = element('div', '', byId('stages'));
      element('span', name, row);
      return {field: `${name}_us`, set: bar(row), text: element('span', '', row)};
    });
  }

  #makeRates() {
    const rows = (table, names, cells) => {
      const body = byId(table).tBodies[0];
      body.replaceChildren();
      return names.map((name) => {
        const row = element('tr', '', body);
        element('th', name, row).scope = 'row';
        return Array.from({length: cells}, () => element('td', '', row));
      });
    };
    this.rates = rows('rates', ['rate', 'compute p50', 'p99', 'p99.9', 'jitter p50', 'p99', 'p99.9', 'missed'], 2);
    this.figures = rows('figures', ['real time', 'frame age', 'contacts', 'sweeps', 'residual', 'deepest', 'overruns', 'lost frames', 'lost records'], 1)
        .map(([cell]) => cell);
  }

  /** A state; `quiet`: for the plots' memory only. `full`: what a muscle's full bar means. */
  show(state, full, quiet = false, outcome = '') {
    const v = state.values;
    events.add(v, outcome);
    const row = [];
    for (let k = 0; k < this.#scene.fingers.length; ++k) {
      row.push(v.desired_normal_N[k], v.desired_tangential_N[k], v.normal_N[k], v.tangential_N[k]);
    }
    this.forces.add(v.time_s[0], row);
    this.path.add(v.time_s[0], [...v.path_target_m.map(mm), ...v.position_m.map(mm)]);
    this.touch.add(v);
    this.accuracy.add(v.time_s[0], v.contact_compute_us[0], v.reference_error[0]);
    this.#state = state;
    this.full = full;
    if (quiet || this.#timer) return;
    this.#timer = setTimeout(() => this.#refresh(), Math.max(0, this.#last_ms + kEvery_ms - performance.now()));
  }

  /** Looks so many seconds back, one of spans_s. */
  look(span_s) {
    this.span_s = span_s;
    if (this.#state && !this.#timer) this.#refresh();
  }

  /** Shows the last state now. */
  flush() {
    clearTimeout(this.#timer);
    if (this.#state) this.#refresh();
  }

  clear() {
    events.clear();
    this.forces?.clear();
    this.path?.clear();
    this.touch.clear();
    this.accuracy?.clear();
  }

  #refresh() {
    this.#timer = 0;
    this.#last_ms = performance.now();
    const v = this.#state.values;
    const columns = this.forces.columns(this.span_s);
    const ofFinger = (k) => [columns[0], ...columns.slice(1 + 4 * k, 5 + 4 * k)];
    this.forceCharts.forEach((chart, k) => chart.set(ofFinger(k), this.span_s));
    this.pathChart.set(this.path.columns(this.span_s), this.span_s);
    this.#showPath(v);
    this.#showGrip(v);
    this.touch.show(v, this.span_s);
    this.stiffness.show(v);
    this.#showMuscles(v);
    this.#showLoops(v);
    this.advanced += 1;
  }

  #showPath(v) {
    const off_m = Math.hypot(...[0, 1, 2].map((i) => v.object[i] - v.target[i]));
    setText(byId('path-error'), fixed(1e3 * off_m, 3));
    setText(byId('turn-error'), fixed((v.rotation_error_rad[0] * 180) / Math.PI, 2));
  }

  #showGrip(v) {
    this.grip.forEach(({margin, slip, spin}, k) => {
      const inside = v.margin[k];
      margin.set(inside, fingerColors[k]);
      setText(margin.text, fixed(inside, 2));
      for (const cell of [margin.meter, margin.text]) cell.classList.toggle('bad', inside < kRed);
      slip.set(v.slip_m[k] / kFullSlip_m, fingerColors[k]);
      setText(slip.text, length(v.slip_m[k]));
      for (const cell of [slip.meter, slip.text]) cell.classList.toggle('bad', v.slip_m[k] >= kFullSlip_m);
      spin.set(v.spin_rad[k] / kFullSpin_rad, fingerColors[k]);
      setText(spin.text, `${fixed((v.spin_rad[k] * 180) / Math.PI, 1)}°`);
      const said = (part, start, unit) => `${part}. Of it at the start: ${start} ${unit}`;
      slip.meter.title = slip.text.title = said(tip('Slip'), fixed(1e6 * v.start_slip_m[k], 1), 'µm');
      spin.meter.title = spin.text.title = said(tip('Spin'), fixed((v.start_spin_rad[k] * 180) / Math.PI, 1), 'degrees');
    });
  }

  #showMuscles(v) {
    setText(byId('full-activation'), `${Math.round(100 * this.full)} %`);
    this.muscles.forEach(({set, track, text, least}, m) => {
      const {max_force_N} = this.#scene.muscles[m];
      const share = v.muscles_N[m] / max_force_N / this.full;
      if (least) least.style.left = `${Math.min(100, (100 * v.least_muscles_N[m]) / max_force_N / this.full || 0)}%`;
      for (const part of [track, text]) part.classList.toggle('bad', isSpent(v, m, this.#scene.muscles[m]));
      activationColor(share, rgb, 0);
      set(share, `color(srgb-linear ${rgb.map((c) => c.toFixed(3)).join(' ')})`);
      setText(text, short(v.muscles_N[m]));
    });
  }

  #showLoops(v) {
    const column = (loop) => [
      Number.isFinite(v[`${loop}_Hz`][0]) ? `${fixed(v[`${loop}_Hz`][0], 0)} Hz` : fixed(NaN, 0),
      ...micros(v[`${loop}_compute_us`]),
      ...micros(v[`${loop}_jitter_us`] ?? [NaN, NaN, NaN]),
      fixed(v[`${loop}_slipped`][0], 0),
    ];
    const texts = [column('contact'), column('control')];
    this.rates.forEach((cells, row) => cells.forEach((cell, i) => setText(cell, texts[i][row])));
    [
      fixed(v.realtime_factor[0], 3),
      Number.isFinite(v.frame_age_s[0]) ? `${fixed(1e3 * v.frame_age_s[0], 2)} ms` : fixed(NaN),
      `${fixed(v.active[0], 0)} of ${fixed(v.contacts[0], 0)}`,
      fixed(v.sweeps[0], 0),
      power(v.residual[0]),
      length(v.penetration_m[0]),
      fixed(v.contact_overruns[0], 0),
      fixed(v.unaccounted[0], 0),
      fixed(v.lost_records?.[0] ?? NaN, 0), // of a recording from before it was told
    ].forEach((text, i) => setText(this.figures[i], text));
    this.figures[7].classList.toggle('bad', v.unaccounted[0] > 0);
    this.figures[8].classList.toggle('bad', v.lost_records?.[0] > 0);
    const most = Math.max(...this.stages.map(({field}) => v[field][0]).filter(Number.isFinite), 1);
    for (const {field, set, text} of this.stages) {
      set(v[field][0] / most);
      setText(text, short(v[field][0]));
    }
    this.accuracy.set();
    setText(byId('reference-error'), power(v.reference_error[0]));
    setText(byId('reference-residual'), power(v.reference_residual[0]));
    this.latency.set(v.latency_counts, v.latency_us);
    setText(byId('latency-p50'), fixed(v.latency_us[0] / 1e3, 2));
    setText(byId('latency-p99'), fixed(v.latency_us[1] / 1e3, 2));
  }
}

const rgb = [0, 0, 0];
const mm = (m) => 1e3 * m;
const micros = (values) => Array.from(values, (us) => (Number.isFinite(us) ? `${short(us)} µs` : fixed(us)));
