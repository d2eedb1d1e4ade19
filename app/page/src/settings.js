// SPDX-License-Identifier: Apache-2.0
// Controls for what may be changed while it runs: those that the scene's message names. They follow the status; a change
// is sent when the hand lets go.

import {power} from './format.js';
import {tip} from './tips.js';

const kMantissas = [1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8];
const kWet = 0.15; // friction of the object when it is wet
const kSteps = 40; // of a range without decades
const rounded = (x) => Number(x.toPrecision(6)); // 0.15000000000000002 is 0.15

/** The least of 1, 2, 5, 10 times a power of ten that is no less than x. */
function niceStep(x) {
  const decade = 10 ** Math.floor(Math.log10(x));
  return decade * [1, 2, 5, 10].find((m) => m * decade >= x * (1 - 1e-9));
}

/** What a slider of a setting goes through: even steps, or over some decades even ratios; both ends and the default. */
export function valuesOf({type, least, most, default: own}) {
  const decades = least > 0 ? Math.log10(most / least) : 0;
  const values = new Set([least, most, ...(typeof own === 'number' ? [own] : [])]);
  if (decades >= 1.3) {
    const mantissas = decades > 5 ? [1] : kMantissas;
    for (let n = Math.floor(Math.log10(least)); n <= Math.ceil(Math.log10(most)); ++n) {
      for (const m of mantissas) values.add(Number(`${m}e${n}`));
    }
  } else {
    const step = Math.max(niceStep((most - least) / kSteps), type === 'whole' ? 1 : 0);
    for (let i = 1; least + i * step < most; ++i) values.add(rounded(least + i * step));
  }
  return [...values].filter((x) => x >= least && x <= most && (type !== 'whole' || Number.isInteger(x))).sort((a, b) => a - b);
}

/** A value with its unit. */
export function textOf({unit, least, most}, x) {
  if (typeof x !== 'number') return String(x);
  const number = least > 0 && most / least > 1e5 ? power(x) : String(Number(x.toPrecision(4)));
  return unit ? `${number} ${unit}` : number;
}

export class Settings {
  #controls = new Map();
  #same = '';

  /** `change(message)` is called with what to send. */
  constructor(form, change) {
    this.form = form;
    this.change = change;
    form.addEventListener('submit', (event) => event.preventDefault());
  }

  /** The settings of a `scene` message; of a recording there are none. */
  load(settings = []) {
    const same = JSON.stringify(settings);
    if (same === this.#same) return; // a hand may be on one of them
    this.#same = same;
    this.form.replaceChildren();
    this.#controls.clear();
    for (const setting of settings) {
      const control = setting.type === 'choice' ? choice(setting, this.change) : slider(setting, this.change);
      const {label} = control;
      const range = setting.type === 'choice' ? setting.choices.join(', ') : `${textOf(setting, setting.least)} … ${textOf(setting, setting.most)}`;
      label.title = `${setting.what}\n${range}; the scene's own: ${textOf(setting, setting.default)}\n${setting.key}`;
      control.back = label.appendChild(document.createElement('button'));
      Object.assign(control.back, {type: 'button', className: 'back', textContent: '↺', hidden: true});
      control.back.setAttribute('aria-label', `${setting.label}: the scene's own, ${textOf(setting, setting.default)}`);
      control.back.addEventListener('click', () => this.change({[setting.name]: setting.default}));
      control.own = setting.default;
      this.form.append(label);
      if (setting.name === 'friction' && setting.default > kWet) this.form.append(wetting(setting, control, this.change));
      this.#controls.set(setting.name, control);
    }
  }

  /** As the status has them; what is not said cannot be changed. */
  show(settings) {
    for (const [name, control] of this.#controls) {
      const value = settings?.[name];
      control.label.hidden = value === undefined || value === null;
      if (control.label.hidden) continue;
      control.show(value);
      control.wet?.(value);
      control.back.hidden = typeof value === 'number' ? Math.abs(value - control.own) <= 1e-6 * Math.abs(value) : value === control.own;
    }
  }
}

/** A button that wets the object, and dries it at the second press: `control` says what its friction is. */
function wetting({name, default: own}, control, change) {
  const button = Object.assign(document.createElement('button'), {type: 'button', id: 'wet', title: tip('Wet'), textContent: 'Wet the object'});
  control.wet = (friction) => button.setAttribute('aria-pressed', String(friction <= kWet));
  button.addEventListener('click', () => change({[name]: button.getAttribute('aria-pressed') === 'true' ? own : kWet}));
  return button;
}

function labelled(setting, input) {
  const label = document.createElement('label');
  const name = document.createElement('span');
  name.textContent = setting.label;
  input.name = setting.name;
  label.append(name, input);
  return label;
}

function slider(setting, change) {
  const values = valuesOf(setting);
  const input = Object.assign(document.createElement('input'), {type: 'range', min: 0, max: values.length - 1, step: 1});
  const label = labelled(setting, input);
  const output = document.createElement('output');
  input.before(output);
  input.dataset.values = JSON.stringify(values);
  const say = (value) => {
    output.textContent = textOf(setting, value);
    input.setAttribute('aria-valuetext', output.textContent);
  };
  let held = false;
  input.addEventListener('input', () => {
    held = true;
    say(values[input.value]);
  });
  input.addEventListener('change', () => {
    held = false;
    change({[setting.name]: values[input.value]});
  });
  return {
    label,
    show(value) {
      if (held) return;
      const off = values.map((x) => Math.abs(Math.log((x + 1e-12) / (value + 1e-12))));
      input.value = off.indexOf(Math.min(...off));
      say(value);
    },
  };
}

function choice(setting, change) {
  const select = document.createElement('select');
  const label = labelled(setting, select);
  for (const value of setting.choices) select.add(new Option(value, value));
  select.addEventListener('change', () => change({[setting.name]: select.value}));
  return {
    label,
    show(value) {
      select.value = value;
    },
  };
}
