// SPDX-License-Identifier: Apache-2.0
// Forces: an arrow and a cone for each contact, an arrow for each finger with the desired one behind it, and the spring of a pull.

import {Color, Group, Vector3} from 'three';

import {fingerColors, slipping as slippingColor, stuck} from './colors.js';
import {splitForce} from './messages.js';
import {isFinite3, vector} from './poses.js';
import {Arrows, Coil, cones} from './rods.js';

export const kFinger_m_per_N = 10e-3; // of the arrows
const kContact_m_per_N = 40e-3;
const kSlipping = 0.5; // so much of a patch slides

const kWhite = new Color(1, 1, 1);
const kSafe = new Color(stuck);
const kSliding = new Color(slippingColor);
export const kEdge = 0.05; // a margin below it is at the cone's edge
const color = new Color();
const from = new Vector3();
const to = new Vector3();
const n = new Vector3();
const f = new Vector3();

/** Red at the cone's edge, blue from a third of the way in. */
export const marginColor = (color, margin) =>
  color.copy(kSafe).lerp(kSliding, Number.isFinite(margin) ? 1 - Math.min(1, Math.max(0, margin - kEdge) / 0.3) : 0);

export class Forces extends Group {
  /** `scene`: the message. */
  constructor(scene) {
    super();
    this.fingers = scene.fingers;
    this.contactArrows = new Arrows(256);
    this.cones = cones(256, {transparent: true, opacity: 0.22, depthWrite: false, side: 2});
    this.fingerArrows = new Arrows(8);
    this.desiredArrows = new Arrows(8, {transparent: true, opacity: 0.45});
    this.coil = new Coil(0xd03a8c);
    this.many = [this.contactArrows, this.cones, this.fingerArrows, this.desiredArrows];
    this.add(...this.many, this.coil);
  }

  /** Draws those of a state; `labels`: one a finger and one for the pull, see Labels. */
  show(state, options, labels) {
    const v = state.values;
    for (const things of this.many) things.clear();
    for (let i = 0; (options.forces || options.cones) && i < state.contacts; ++i) this.#drawContact(state, i, options);
    this.fingers.forEach((finger, k) => this.#drawFinger(finger, k, v, options, labels[k]));
    for (const things of this.many) things.done();
    this.#drawPull(v, labels.at(-1));
  }

  #drawFinger({name}, k, v, options, label) {
    const force = vector(v.force_N, 3 * k);
    const desired = vector(v.desired_N, 3 * k);
    const acts = vector(v.centre_m, 3 * k);
    label.text = '';
    if (!options.forces || !Number.isFinite(acts.x) || !(force.lengthSq() > 0)) return;
    const slipping = v.sliding_share[k] > kSlipping;
    color.set(fingerColors[k]);
    if (slipping) color.copy(kSliding);
    this.fingerArrows.put(label.at.copy(acts).addScaledVector(force, -kFinger_m_per_N), acts, 1.1e-3, color, slipping);
    if (desired.lengthSq() > 0) {
      color.lerp(kWhite, 0.35);
      this.desiredArrows.put(from.copy(acts).addScaledVector(desired, -kFinger_m_per_N), acts, 1.9e-3, color);
    }
    label.text = `${name} ${force.length().toFixed(2)} N${slipping ? ', slipping' : ''}`;
    label.element.classList.toggle('bad', slipping);
  }

  #drawContact(state, i, options) {
    const {columns, numbers} = state;
    const at = state.contact(i);
    const friction = state.values.friction[0];
    to.fromArray(numbers, at + columns.point_m);
    n.fromArray(numbers, at + columns.normal);
    f.fromArray(numbers, at + columns.force_N);
    const {normal_N: f_n, friction_N: f_t} = splitForce(state, at);
    if (!(f_n > 0)) return;
    const margin = 1 - f_t / (friction * f_n);
    marginColor(color, margin); // with two heads at the cone's edge
    // A rigid fingertip has one contact: its force is the finger's, which is drawn already.
    if (options.forces && state.contacts > this.fingers.length) {
      this.contactArrows.put(from.copy(to).addScaledVector(f, -kContact_m_per_N), to, 2.6e-4, color, margin < kEdge);
    }
    if (options.cones && friction > 0) {
      const height = kContact_m_per_N * f_n;
      this.cones.put(to, from.copy(to).addScaledVector(n, -height), friction * height, color);
    }
  }

  #drawPull(v, label) {
    label.text = '';
    this.coil.visible = false;
    if (!isFinite3(v.pull_anchor_m) || !isFinite3(v.pull_handle_m)) return;
    from.fromArray(v.pull_anchor_m);
    label.at.fromArray(v.pull_handle_m);
    this.coil.stretch(from, label.at, 1.6e-3);
    label.text = `pull ${Math.hypot(...v.pull_force_N).toFixed(2)} N`;
  }
}
