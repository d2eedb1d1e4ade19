// SPDX-License-Identifier: Apache-2.0
// At the upper left of the view: which way is down, and how long some millimetres are where the object is.

import {Color, Group, Vector3} from 'three';

import {niceAbove, themed} from './colors.js';
import {Arrows, rods} from './rods.js';

const kArrow_px = 40, kLeft_px = 34, kTop_px = 38, kBar_px = 84, kBelow_px = 34, kTick_px = 5;
const kThick_px = 1.6; // of the arrow's shaft
/** Names of its labels. */
export const gaugeLabels = ['scale', 'gravity'];

const from = new Vector3();
const to = new Vector3();
const color = new Color();

export class Gauge extends Group {
  constructor() {
    super();
    this.arrow = new Arrows(1);
    this.bar = rods(3);
    this.add(this.arrow, this.bar);
  }

  /** Where the view is now. `down`: unit, or null without gravity; `at`: what the picture looks at; `labels`: as gaugeLabels. */
  place(picture, down, at, [scale, gravity]) {
    const px = picture.metresPerPixel(at.toArray());
    const {right, up} = picture.axes();
    color.set(themed('--muted'));
    const corner = picture.onPlane(kLeft_px, kTop_px, at);
    this.arrow.clear();
    gravity.text = down ? 'g' : '';
    if (down) {
      from.copy(corner).addScaledVector(down, (-kArrow_px / 2) * px);
      to.copy(corner).addScaledVector(down, (kArrow_px / 2) * px);
      this.arrow.put(from, to, kThick_px * px, color);
      gravity.at.copy(corner).addScaledVector(right, 18 * px);
    }
    this.arrow.done();
    const length_m = niceAbove(0.4 * kBar_px * px); // 34 .. 84 px
    this.bar.clear();
    from.copy(corner).addScaledVector(up, -kBelow_px * px).addScaledVector(right, -16 * px);
    to.copy(from).addScaledVector(right, length_m);
    this.bar.put(from, to, px, color);
    for (const end of [from, to]) {
      this.bar.put(end.clone().addScaledVector(up, -kTick_px * px), end.clone().addScaledVector(up, kTick_px * px), px, color);
    }
    this.bar.done();
    scale.at.copy(from).addScaledVector(right, length_m / 2).addScaledVector(up, -15 * px);
    scale.text = `${1e3 * length_m} mm`;
  }
}
