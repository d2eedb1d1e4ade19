// Sliders for what may be changed while it runs. They follow the status; a change is sent when the hand lets go.

import {fixed, power} from './format.js';

const steps = (from, to, step) => Array.from({length: Math.round((to - from) / step) + 1}, (_, i) => from + i * step);
const kDecades = [10, 9, 8, 7, 6, 5, 4, 3, 2, 1].map((n) => Number(`1e-${n}`));

const kSettings = [
  {key: 'friction', name: 'Friction', values: steps(0, 2, 0.05), text: (x) => fixed(x, 2)},
  {key: 'internal_force_N', name: 'Squeeze', values: [...steps(0.1, 1, 0.1), ...steps(1.25, 5, 0.25), ...steps(6, 20, 1)],
   text: (x) => `${fixed(x, 2)} N`},
  {key: 'max_sweeps', name: 'Solver sweeps, at most', values: [1, 2, 3, 5, 8, 10, 15, 20, 30, 40, 60, 80, 100, 200, 500, 1000],
   text: (x) => fixed(x, 0)},
  {key: 'tolerance', name: 'Solver tolerance', values: kDecades, text: power},
  {key: 'contact_Hz', name: 'Contact rate', values: [200, 500, 1000, 1500, 2000, 3000, 4000, 5000, 6000, 8000, 10000],
   text: (x) => `${fixed(x, 0)} Hz`},
  {key: 'control_Hz', name: 'Control rate', values: [20, 30, 50, 80, 100, 150, 200, 300, 400, 500, 1000, 2000],
   text: (x) => `${fixed(x, 0)} Hz`},
  {key: 'delay_periods', name: 'Delay of frames', values: steps(0, 8, 1), text: (x) => `${x} ${x === 1 ? 'period' : 'periods'}`},
  {key: 'kernel', name: 'Kernel', values: ['boussinesq', 'gaussian']},
  {key: 'level', name: 'Level of the pulps', values: steps(0, 6, 1), text: (x) => (x === 0 ? '0, leaves' : fixed(x, 0))},
];

export class Settings {
  #controls = new Map();

  /** `change(message)` is called with what to send. */
  constructor(form, change) {
    form.addEventListener('submit', (event) => event.preventDefault());
    for (const setting of kSettings) {
      const control = setting.text ? slider(setting, change) : choice(setting, change);
      form.append(control.label);
      this.#controls.set(setting.key, control);
    }
  }

  /** As the status has them; what is not told cannot be changed. */
  show(settings) {
    for (const [key, control] of this.#controls) {
      const value = settings?.[key];
      control.label.hidden = value === undefined || value === null;
      if (!control.label.hidden) control.show(value);
    }
  }
}

function slider({key, name, values, text}, change) {
  const label = document.createElement('label');
  const input = document.createElement('input');
  const output = document.createElement('output');
  label.append(name, output, input);
  Object.assign(input, {type: 'range', min: 0, max: values.length - 1, step: 1, name: key});
  const say = (value) => {
    output.textContent = text(value);
    input.setAttribute('aria-valuetext', text(value));
  };
  let held = false;
  input.addEventListener('input', () => {
    held = true;
    say(rounded(values[input.value]));
  });
  input.addEventListener('change', () => {
    held = false;
    change({[key]: rounded(values[input.value])});
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

const rounded = (x) => Number(x.toPrecision(6)); // 0.15000000000000002 is 0.15

function choice({key, name, values}, change) {
  const label = document.createElement('label');
  const select = document.createElement('select');
  select.name = key;
  label.append(name, select);
  for (const value of values) select.add(new Option(value, value));
  select.addEventListener('change', () => change({[key]: select.value}));
  return {
    label,
    show(value) {
      select.value = value;
    },
  };
}
