// SPDX-License-Identifier: Apache-2.0
// The way that the object has gone, and its target's.

import {BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, Points, PointsMaterial} from 'three';

import {themed} from './colors.js';

const kTrail = 600; // points,
const kStep_m = 0.1e-3; // no nearer to each other than this

function points(color, size) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * kTrail), 3).setUsage(DynamicDrawUsage));
  geometry.setDrawRange(0, 0);
  const made = new Points(geometry, new PointsMaterial({color, size, sizeAttenuation: false}));
  made.frustumCulled = false;
  return made;
}

export class Trail extends Group {
  count = 0;

  constructor() {
    super();
    this.path = points(themed('--path'), 3);
    this.targetPath = points(themed('--ghost'), 2);
    this.add(this.path, this.targetPath);
  }

  /** One more place of both; `v`: a state's values. */
  remember(v) {
    const last = this.path.geometry.attributes.position.array.subarray(3 * this.count - 3);
    const moved = Math.hypot(v.object[0] - last[0], v.object[1] - last[1], v.object[2] - last[2]);
    if (this.count > 0 && moved < kStep_m) return;
    if (this.count === kTrail) {
      // Half of it is let go at once: seldom, and without a seam.
      for (const {geometry} of [this.path, this.targetPath]) geometry.attributes.position.array.copyWithin(0, 3 * kTrail / 2);
      this.count = kTrail / 2;
    }
    for (const [way, place] of [[this.path, v.object], [this.targetPath, v.target]]) {
      const {position} = way.geometry.attributes;
      position.array.set(place.subarray(0, 3), 3 * this.count);
      position.needsUpdate = true;
      way.geometry.setDrawRange(0, this.count + 1);
    }
    this.count += 1;
  }

  clear() {
    this.count = 0;
  }
}
