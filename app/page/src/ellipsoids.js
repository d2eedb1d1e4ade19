// SPDX-License-Identifier: Apache-2.0
// The stiffness of the object in the hand, along axes and about them: an ellipsoid of glass is what there is, rings around
// its centre are what is asked for.

import {Color, Group, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, TorusGeometry, Vector3} from 'three';

import {themed} from './colors.js';
import {short} from './format.js';
import {principal} from './principal.js';
import {rods} from './rods.js';
import {choosesStiffness} from './stiffness.js';

// How long a semi-axis is: 30 mm for 1000 N/m, 60 mm for 1 N m/rad.
const kKinds = [
  {option: 'stiffness', has: 'stiffness_N_per_m', asked: 'asked_N_per_m', scale: 30e-6, unit: 'N/m', color: '--stiffness'},
  {option: 'turning', has: 'stiffness_Nm_per_rad', asked: 'asked_Nm_per_rad', scale: 60e-3, unit: 'N m/rad', color: '--turning'},
];
/** Of each kind, the softest way and the stiffest one. */
export const ellipsoidLabels = kKinds.flatMap(({option}) => [`${option}: softest`, `${option}: stiffest`]);

const kAxis_m = 4e-4;
const kWire = 0.018, kAskedWire = 0.05; // of a ring's radius

const size = new Vector3();
const tip = new Vector3();
const tail = new Vector3();
const own = new Matrix4();
const color = new Color();

/** Three rings of radius 1, across the axes. */
function rings(material, wire) {
  const group = new Group();
  for (const turn of ['rotateX', 'rotateY', 'rotateZ']) {
    group.add(new Mesh(new TorusGeometry(1, wire, 8, 96)[turn](turn === 'rotateZ' ? 0 : Math.PI / 2), material));
  }
  return group;
}

class Ellipsoid extends Group {
  constructor(kind) {
    super();
    this.kind = kind;
    this.visible = false;
    this.solid = new Mesh(new SphereGeometry(1, 48, 32), new MeshLambertMaterial({transparent: true, opacity: 0.42, depthWrite: false}));
    this.outline = rings(new MeshLambertMaterial(), kWire);
    this.asked = rings(new MeshBasicMaterial({depthTest: false, transparent: true}), kAskedWire); // also behind the glass
    for (const ring of this.asked.children) ring.renderOrder = 1;
    this.axes = rods(3);
    this.add(this.axes, this.asked, this.outline, this.solid);
    for (const part of [this.solid, this.outline, this.asked]) part.matrixAutoUpdate = false;
  }

  show(v, pose, labels) {
    const {values, axes} = principal(v[this.kind.has]);
    own.makeBasis(...axes.map((axis) => new Vector3(...axis))).premultiply(pose);
    this.#place(this.solid, values, own);
    this.#place(this.outline, values, own);
    this.#place(this.asked, v[this.kind.asked], pose);
    color.set(themed(values[0] < 0 ? '--bad' : this.kind.color));
    this.solid.material.color.copy(color);
    this.outline.children[0].material.color.copy(color);
    this.asked.children[0].material.color.set(themed('--asked-ring'));
    this.axes.clear();
    values.forEach((value, i) => {
      tip.set(0, 0, 0).setComponent(i, value * this.kind.scale);
      tail.copy(tip).negate().applyMatrix4(own);
      tip.applyMatrix4(own);
      this.axes.put(tail, tip, kAxis_m, color);
      if (i === 1) return;
      const label = labels[i / 2];
      label.at.copy(tip);
      label.text = `${short(value)} ${this.kind.unit}`;
    });
    this.axes.done();
  }

  #place(part, three, matrix) {
    const reach = Array.from(three, (k) => Math.max(1e-6, Math.abs(k) * this.kind.scale));
    part.matrix.copy(matrix).scale(size.set(...reach));
    part.matrixWorldNeedsUpdate = true;
  }
}

export class Ellipsoids extends Group {
  /** `scene`: the message. */
  constructor(scene) {
    super();
    this.kinds = choosesStiffness(scene) ? kKinds.map((kind) => new Ellipsoid(kind)) : [];
    for (const kind of this.kinds) this.add(kind);
    if (this.kinds.length > 0) this.centre = new Matrix4().makeTranslation(...scene.object_stiffness.centre_m);
  }

  /** Of a state, with the object at `object`; `labels`: as ellipsoidLabels. */
  show(v, object, options, labels) {
    for (const label of labels) label.text = '';
    this.kinds.forEach((one, i) => {
      one.visible = options[one.kind.option] && Number.isFinite(v[one.kind.has][0]);
      if (one.visible) one.show(v, new Matrix4().multiplyMatrices(object, this.centre), labels.slice(2 * i, 2 * i + 2));
    });
  }
}
