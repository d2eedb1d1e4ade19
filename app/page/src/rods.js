// SPDX-License-Identifier: Apache-2.0
// Many rods, arrows or cones in one or two calls each, and a coil.

import {
  Color, ConeGeometry, Curve, CylinderGeometry, DynamicDrawUsage, Group, InstancedMesh, Matrix4, Mesh,
  MeshLambertMaterial, Quaternion, TubeGeometry, Vector3,
} from 'three';

const kY = new Vector3(0, 1, 0);
const turn = new Quaternion();
const size = new Vector3();
const along = new Vector3();
const place = new Matrix4();

/** Copies of a shape that stands on the origin along y, 1 long and with a radius of 1. */
export class Instances extends InstancedMesh {
  constructor(geometry, capacity, material) {
    super(geometry, material, capacity);
    this.instanceMatrix.setUsage(DynamicDrawUsage);
    this.setColorAt(0, new Color(1, 1, 1)); // takes the memory of the colours
    this.frustumCulled = false;
    this.count = 0;
  }

  clear() {
    this.count = 0;
  }

  /** One more, from a place to another; nothing if there is no room or no length. */
  put(from, to, radius, color) {
    along.subVectors(to, from);
    const length = along.length();
    if (this.count >= this.instanceMatrix.count || !(length > 1e-7)) return;
    turn.setFromUnitVectors(kY, along.divideScalar(length));
    place.compose(from, turn, size.set(radius, length, radius));
    this.setMatrixAt(this.count, place);
    this.setColorAt(this.count, color);
    this.count += 1;
  }

  done() {
    this.instanceMatrix.needsUpdate = true;
    this.instanceColor.needsUpdate = true;
    this.visible = this.count > 0;
  }
}

const standing = (geometry) => geometry.translate(0, 0.5, 0);
const lambert = (options) => new MeshLambertMaterial(options);

export const rods = (capacity, options = {}) =>
  new Instances(standing(new CylinderGeometry(1, 1, 1, 8, 1, true)), capacity, lambert(options));

/** Cones that stand on their tip. */
export const cones = (capacity, options = {}) =>
  new Instances(standing(new ConeGeometry(1, 1, 24, 1, true).rotateX(Math.PI)), capacity, lambert(options));

const neck = new Vector3();
const second = new Vector3();

/** Arrows: a shaft and one or two heads, the first of which ends where the arrow does. */
export class Arrows extends Group {
  constructor(capacity, options = {}) {
    super();
    this.shafts = rods(capacity, options);
    this.heads = new Instances(standing(new ConeGeometry(1, 1, 12)), 2 * capacity, lambert(options));
    this.add(this.shafts, this.heads);
  }

  clear() {
    this.shafts.clear();
    this.heads.clear();
  }

  put(from, to, radius, color, twoHeads = false) {
    const length = from.distanceTo(to);
    const head = Math.min(5 * radius, (twoHeads ? 0.45 : 0.6) * length);
    const back = (share) => (length > 0 ? (share * head) / length : 0);
    neck.lerpVectors(to, from, back(1));
    this.shafts.put(from, neck, radius, color);
    this.heads.put(neck, to, 2.3 * radius, color);
    if (!twoHeads) return;
    const tip = second.lerpVectors(to, from, back(0.85));
    this.heads.put(neck.lerpVectors(to, from, back(2)), tip, 2.9 * radius, color);
  }

  done() {
    this.shafts.done();
    this.heads.done();
  }
}

class Helix extends Curve {
  getPoint(t, out = new Vector3()) {
    const kTurns = 12;
    const grown = Math.min(1, 12 * t, 12 * (1 - t)); // it begins and ends on its axis
    const angle = 2 * Math.PI * kTurns * t;
    return out.set(grown * Math.cos(angle), t, grown * Math.sin(angle));
  }
}

/** A spring between two places. */
export class Coil extends Mesh {
  constructor(color) {
    // The tube is as thick as it should be at the length of 30 mm and the radius of 2 mm that it mostly has.
    super(new TubeGeometry(new Helix(), 240, 0.012, 5), lambert({color}));
    this.frustumCulled = false;
    this.matrixAutoUpdate = false;
    this.visible = false;
  }

  stretch(from, to, radius) {
    along.subVectors(to, from);
    const length = along.length();
    this.visible = length > 1e-5;
    if (!this.visible) return;
    turn.setFromUnitVectors(kY, along.divideScalar(length));
    this.matrix.compose(from, turn, size.set(radius, length, radius));
    this.matrixWorldNeedsUpdate = true;
  }
}
