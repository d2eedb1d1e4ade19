// SPDX-License-Identifier: Apache-2.0
// The panel of touch: what each fingertip feels, and what the grip makes of it. Of scenes that name touch.

import {TimeChart} from './charts.js';
import {fingerColors} from './colors.js';
import {byId, element, meterIn, setText} from './elements.js';
import {fixed, kNone} from './format.js';
import {Histories} from './history.js';

const kRed = 0.1; // a margin below it
const kRecent_s = 0.5; // so long a reflex stands out
const kEvents = {1: 'load', 2: 'slip'};

export const feels = (scene) => scene.fields.some(({name}) => name === 'stick');

/** What is left of a finger's friction, as it is felt: 1 - T / (mu N). NaN without load. */
export const feltMargin = (friction, normal_N, tangential_N) =>
  (normal_N > 0 && friction > 0 ? 1 - tangential_N / (friction * normal_N) : NaN);

/** The last reflex in words: "index, load, 0.87 s". */
export function reflexText(v, fingers) {
  const event = kEvents[v.last_reflex?.[0]];
  return event ? `${fingers[v.last_reflex_finger[0]].name}, ${event}, ${fixed(v.last_reflex_s[0], 2)} s` : kNone;
}

export class TouchPanel {
  #chart = null;
  #rows = [];
  #fingers = [];

  /** A new scene; the panel is hidden where it names no touch. */
  load(scene, spans_s) {
    this.#chart?.view.destroy();
    this.#chart = null;
    byId('stick').replaceChildren();
    this.shown = feels(scene);
    byId('panel-touch').hidden = !this.shown;
    if (!this.shown) return;
    this.#fingers = scene.fingers;
    this.stick = new Histories(scene.fingers.length, spans_s);
    fingerColors.forEach((color, k) => document.documentElement.style.setProperty(`--finger-${k}`, color));
    this.#chart = new TimeChart(byId('stick'), {
      series: scene.fingers.map(({name}, k) => ({name, color: `--finger-${k}`})), floor: [0, 1], unit: '', times: true, named: true,
    });
    const body = byId('touch').tBodies[0];
    body.replaceChildren();
    this.#rows = scene.fingers.map(({name}, k) => {
      const row = element('tr', '', body);
      row.style.setProperty('--color', fingerColors[k]);
      element('th', name, row).scope = 'row';
      const stick = meterIn(row);
      const [friction, margin, squeeze] = [0, 1, 2].map(() => element('td', '', row));
      return {stick, friction, margin, squeeze};
    });
  }

  /** Remembers a state for the chart. */
  add(v) {
    if (this.shown) this.stick.add(v.time_s[0], v.stick);
  }

  clear() {
    this.stick?.clear();
  }

  show(v, span_s) {
    if (!this.shown) return;
    this.#chart.set(this.stick.columns(span_s), span_s);
    this.#rows.forEach(({stick, friction, margin, squeeze}, k) => {
      stick.set(v.stick[k], fingerColors[k]);
      setText(stick.text, `${fixed(100 * v.stick[k], 0)} %`);
      // A scene without control has no controller that takes notice: the fingertips feel for the page alone.
      const felt = (v.friction_felt ?? v.rim_friction)[k];
      setText(friction, fixed(felt, 2));
      const left = feltMargin(felt, v.normal_N[k], v.tangential_N[k]);
      setText(margin, fixed(left, 2));
      margin.classList.toggle('bad', left < kRed);
      setText(squeeze, fixed(v.squeeze_N?.[k] ?? NaN, 2));
    });
    setText(byId('last-reflex'), reflexText(v, this.#fingers));
    byId('last-reflex').classList.toggle('recent', v.time_s[0] - v.last_reflex_s?.[0] < kRecent_s);
  }
}
