// SPDX-License-Identifier: Apache-2.0
// The panel of a stiffness that is chosen: what is asked for, by hand while it runs, what there is, what lacks, what it costs.

import {bar, byId, element, setText} from './elements.js';
import {fixed, kNone, short} from './format.js';
import {niceAbove} from './colors.js';
import {textOf, valuesOf} from './settings.js';
import {tip} from './tips.js';

const kRecent_s = 1; // so long what lacked is said
const kWait_ms = 150; // from one change to the next, while a hand is on a slider
const kHad = 0.999; // of what is asked for
const kGroups = [
  {asked: 'asked_N_per_m', has: 'stiffness_N_per_m', word: 'along', unit: 'N/m'},
  {asked: 'asked_Nm_per_rad', has: 'stiffness_Nm_per_rad', word: 'about', unit: 'N m/rad'},
];

export const choosesStiffness = (scene) => Boolean(scene.object_stiffness);

/** Whether a muscle is as good as at its limit. */
export const isAtLimit = (force_N, max_force_N) => force_N >= 0.999 * max_force_N;

/** Whether it lacked something lately. */
const lacks = (v) => v.time_s[0] - v.lack_s[0] < kRecent_s;

/** Whether a muscle has nothing left, or had not when there were no forces for a stiffness. */
export const isSpent = (v, m, {max_force_N}) => isAtLimit((v.muscles_asked_N ?? v.muscles_N)[m], max_force_N) || Boolean(v.lack_muscles && lacks(v) && v.lack_muscles[m] > 0);

/** What of a stiffness there were no muscle forces for, if that is not long ago: "rotation about (1.00, 0, 0) lacks 0.031 N m/rad; at their limit: APL". */
export function lackText(v, muscles) {
  if (!lacks(v)) return '';
  const names = muscles.filter((_, m) => v.lack_muscles[m] > 0).map(({name}) => name);
  const axis = Array.from(v.lack_axis, (x) => fixed(x, 2)).join(', ');
  const [along, about] = [v.lack_N_per_m[0], v.lack_Nm_per_rad[0]];
  const what = Number.isFinite(along) ? `translation along (${axis}) lacks ${short(along)} N/m` :
      Number.isFinite(about) ? `rotation about (${axis}) lacks ${short(about)} N m/rad` : 'a finger\u2019s posture gives way';
  return names.length > 0 ? `${what}; at their limit: ${names.join(', ')}` : what;
}

/** What muscles pull in sum, and what they would at the least. */
export function effortText(v) {
  const sum = (forces) => forces.reduce((a, b) => a + b, 0);
  const least = sum(v.least_muscles_N);
  return `${fixed(sum(v.muscles_N), 0)} N${Number.isFinite(least) ? `, at the least ${fixed(least, 0)} N` : ''}`;
}

/** Three numbers of which one becomes another: all, if they are alike. */
export const withOne = (three, i, value, alike) => Array.from(three, (x, j) => (alike || j === i ? value : x));

export class StiffnessPanel {
  /** Is called with what to set. */
  change = () => {};
  #rows = [];
  #muscles = [];
  #asked = {}; // as the last state has it
  #timer = 0;
  #next = null;

  /** A new scene. Where it chooses none, the panel says how it could, or is hidden. */
  load(scene) {
    this.shown = choosesStiffness(scene);
    byId('panel-stiffness').hidden = scene.object_stiffness === undefined; // no muscles that have stiffness
    byId('panel-stiffness').classList.toggle('none', !this.shown);
    const body = byId('stiffness').tBodies[0];
    body.replaceChildren();
    this.#rows = [];
    if (!this.shown) return;
    this.#muscles = scene.muscles;
    const settings = new Map((scene.settings ?? []).map((setting) => [setting.name, setting]));
    for (const group of kGroups) {
      const setting = settings.get(group.asked);
      ['x', 'y', 'z'].forEach((axis, i) => this.#rows.push(this.#makeRow(body, group, setting, axis, i)));
    }
    const live = settings.has(kGroups[0].asked);
    byId('alike').parentElement.hidden = !live;
    const back = byId('stiffness-back');
    back.hidden = !live;
    back.onclick = () => this.change(Object.fromEntries(kGroups.map(({asked}) => [asked, settings.get(asked).default])));
    const {frozen_from_s} = scene.object_stiffness;
    this.frozen_s = frozen_from_s ?? Infinity;
  }

  #makeRow(body, group, setting, axis, i) {
    const row = element('tr', '', body);
    element('th', `${group.word} ${axis}`, row).scope = 'row';
    const slide = element('td', '', row);
    slide.className = 'slide';
    const made = {group, i, held: false, text: element('td', '', row)};
    if (setting) this.#makeSlider(slide, setting, made, `${setting.label}: ${axis}`);
    const meter = element('td', '', row);
    meter.className = 'meter';
    made.set = bar(meter);
    made.track = meter.firstChild;
    made.mark = element('b', '', made.track);
    made.has = element('td', '', row);
    return made;
  }

  #makeSlider(parent, setting, made, name) {
    const {asked} = made.group;
    const values = valuesOf({...setting, type: 'number', default: setting.default[made.i]});
    const input = Object.assign(document.createElement('input'), {type: 'range', min: 0, max: values.length - 1, step: 1});
    input.name = `${asked} ${'xyz'[made.i]}`;
    input.dataset.values = JSON.stringify(values);
    input.setAttribute('aria-label', name);
    input.title = `${setting.what} ${setting.key}`;
    parent.append(input);
    const say = () => this.#ask(asked, withOne(this.#asked[asked], made.i, values[input.value], byId('alike').checked));
    input.addEventListener('input', () => {
      made.held = true;
      say();
    });
    input.addEventListener('change', () => {
      made.held = false;
      say();
    });
    made.follow = (value) => {
      input.setAttribute('aria-valuetext', textOf(setting, value));
      if (made.held) return;
      const off = values.map((x) => Math.abs(x - value));
      input.value = off.indexOf(Math.min(...off));
    };
  }

  /** Asks for it soon: the loops rest for each change. */
  #ask(name, three) {
    this.#asked[name] = three;
    this.#next = {...this.#next, [name]: three};
    this.#timer ||= setTimeout(() => {
      this.#timer = 0;
      this.change(this.#next);
      this.#next = null;
    }, kWait_ms);
  }

  show(v) {
    if (!this.shown) return;
    for (const {asked} of kGroups) if (!this.#next?.[asked]) this.#asked[asked] = Array.from(v[asked]);
    for (const {group, i, text, set, track, mark, has, follow} of this.#rows) {
      const asked = this.#asked[group.asked][i];
      const diagonal = [0, 4, 8].map((at) => v[group.has][at]);
      const full = niceAbove(Math.max(1e-3, ...[...diagonal, ...this.#asked[group.asked]].filter(Number.isFinite)));
      setText(text, short(asked));
      setText(has, `${Number.isFinite(diagonal[i]) ? short(diagonal[i]) : kNone} ${group.unit}`);
      set(diagonal[i] / full);
      track.classList.toggle('bad', diagonal[i] < kHad * asked);
      mark.style.left = `${(100 * asked) / full}%`;
      follow?.(asked);
    }
    const share = v.stiffness_share[0];
    setText(byId('stiffness-share'), Number.isFinite(share) ? `${fixed(100 * share, 0)} %` : kNone);
    byId('stiffness-share').classList.toggle('bad', share < 0.995);
    setText(byId('effort'), effortText(v));
    const squeeze_N = v.stiffness_squeeze_N[0];
    byId('stiffness-squeeze').parentElement.hidden = !(squeeze_N > 0);
    setText(byId('stiffness-squeeze'), fixed(squeeze_N, 2));
    const lack = v.time_s[0] > this.frozen_s ? `muscles stay as they were at ${fixed(this.frozen_s, 2)} s` : lackText(v, this.#muscles);
    setText(byId('lack'), lack);
    byId('lack').title = lack || tip('Lack');
  }
}
