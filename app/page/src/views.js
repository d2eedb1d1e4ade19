// SPDX-License-Identifier: Apache-2.0
// What the picture shows: buttons for it, and a slider for how much deformation is exaggerated.

import {hasBodies} from './bodies.js';
import {choosesStiffness} from './stiffness.js';
import {tip} from './tips.js';

const kViews = [
  {key: 'f', option: 'forces', name: 'Forces', tip: 'Forces'},
  {key: 'c', option: 'cones', name: 'Cones', tip: 'Cones'},
  {key: 'm', option: 'muscles', name: 'Muscles', tip: 'Muscles'},
  {key: 't', option: 'ghost', name: 'Target', tip: 'Target'},
  {key: 'w', option: 'path', name: 'Way', tip: 'Way'},
  {key: 'o', option: 'bodies', name: 'Surroundings', tip: 'Surroundings', of: hasBodies},
  {key: 'k', option: 'stiffness', name: 'Stiffness', tip: 'Stiffness ellipsoid', of: choosesStiffness},
  {key: 'l', option: 'turning', name: 'Turning', tip: 'Turning ellipsoid', of: choosesStiffness},
  {key: 'x', option: 'seeThrough', name: 'See through', tip: 'See through'},
];

export class Views {
  #picture;
  #buttons = new Map();

  constructor(parent, picture) {
    this.#picture = picture;
    for (const {key, option, name, tip: part} of kViews) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = name;
      button.title = tip(part);
      button.setAttribute('aria-keyshortcuts', key);
      button.addEventListener('click', () => this.toggle(option));
      parent.append(button);
      this.#buttons.set(option, button);
    }
    const label = document.createElement('label');
    this.slider = Object.assign(document.createElement('input'), {type: 'range', min: 1, max: 10, step: 0.5, value: 1});
    this.slider.setAttribute('aria-keyshortcuts', 'e');
    this.times = document.createElement('output');
    label.title = tip('Deformation');
    label.append('Deformation', this.slider, this.times);
    parent.append(label);
    this.slider.addEventListener('input', () => this.#exaggerate(Number(this.slider.value)));
    this.#show();
  }

  /** A new scene, which may not have all of it. */
  load(scene) {
    for (const {option, of} of kViews) this.#buttons.get(option).hidden = Boolean(of) && !of(scene);
  }

  toggle(option) {
    this.#picture.options[option] = !this.#picture.options[option];
    this.#apply();
  }

  /** True scale, three times, ten times. */
  nextExaggeration() {
    const now = this.#picture.options.exaggeration;
    this.#exaggerate(now < 3 ? 3 : now < 10 ? 10 : 1);
  }

  /** Whether a key was one of ours. */
  press(key) {
    const view = kViews.find((v) => v.key === key);
    if (view) this.toggle(view.option);
    else if (key === 'e') this.nextExaggeration();
    else return false;
    return true;
  }

  #exaggerate(times) {
    this.#picture.options.exaggeration = times;
    this.#apply();
  }

  #apply() {
    this.#show();
    this.#picture.update();
  }

  #show() {
    const {options} = this.#picture;
    for (const [option, button] of this.#buttons) button.setAttribute('aria-pressed', String(options[option]));
    this.slider.value = options.exaggeration;
    this.times.textContent = `${options.exaggeration}×`;
  }
}
