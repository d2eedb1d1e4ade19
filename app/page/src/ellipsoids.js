// The stiffness of the object in the hand: as an ellipsoid what there is, and of wire around its centre what is asked for.

import {Color, Group, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, TorusGeometry, Vector3} from 'three';

import {themed} from './colors.js';
import {principal} from './principal.js';
import {rods} from './rods.js';
import {choosesStiffness} from './stiffness.js';

export const kStiffness_m_per_N_per_m = 30e-3 / 1000; // 1000 N/m are 30 mm
const kAxis_m = 4e-4;
const kWire = 0.018, kAskedWire = 0.05; // of a ring's radius

const turned = new Matrix4();
const size = new Vector3();
const tip = new Vector3();
const tail = new Vector3();
const color = new Color();

/** Three rings of radius 1, across the axes. */
function rings(material, wire) {
  const group = new Group();
  for (const turn of ['rotateX', 'rotateY', 'rotateZ']) {
    group.add(new Mesh(new TorusGeometry(1, wire, 8, 96)[turn](turn === 'rotateZ' ? 0 : Math.PI / 2), material));
  }
  return group;
}

export class Ellipsoids extends Group {
  /** `scene`: the message. */
  constructor(scene) {
    super();
    this.shown = choosesStiffness(scene);
    this.visible = false;
    if (!this.shown) return;
    this.centre = new Matrix4().makeTranslation(...scene.object_stiffness.centre_m);
    const glass = new MeshLambertMaterial({transparent: true, opacity: 0.42, depthWrite: false});
    this.solid = new Mesh(new SphereGeometry(1, 48, 32), glass);
    this.outline = rings(new MeshLambertMaterial(), kWire);
    this.asked = rings(new MeshBasicMaterial({depthTest: false, transparent: true}), kAskedWire); // also behind the glass
    for (const ring of this.asked.children) ring.renderOrder = 1;
    this.axes = rods(3);
    this.add(this.axes, this.asked, this.outline, this.solid);
    for (const part of [this.solid, this.outline, this.asked]) part.matrixAutoUpdate = false;
  }

  /** Of a state, with the object at `object`; `labels`: for the softest and the stiffest way. */
  show(v, object, wanted, labels) {
    for (const label of labels) label.text = '';
    this.visible = this.shown && wanted && Number.isFinite(v.stiffness_N_per_m[0]);
    if (!this.visible) return;
    const {values, axes} = principal(v.stiffness_N_per_m);
    const pose = turned.multiplyMatrices(object, this.centre).clone();
    const place = (part, three, matrix) => {
      part.matrix.copy(matrix).scale(size.set(...three.map((k) => Math.max(1e-6, Math.abs(k) * kStiffness_m_per_N_per_m))));
      part.matrixWorldNeedsUpdate = true;
    };
    const own = new Matrix4().multiplyMatrices(pose, new Matrix4().makeBasis(...axes.map((axis) => new Vector3(...axis))));
    place(this.solid, values, own);
    place(this.outline, values, own);
    place(this.asked, [...v.asked_N_per_m], pose);
    color.set(themed(values[0] < 0 ? '--bad' : '--stiffness'));
    this.solid.material.color.copy(color);
    this.outline.children[0].material.color.copy(color);
    this.asked.children[0].material.color.set(themed('--asked-ring'));
    this.axes.clear();
    values.forEach((value, i) => {
      tip.set(0, 0, 0).setComponent(i, value * kStiffness_m_per_N_per_m);
      tail.copy(tip).negate().applyMatrix4(own);
      tip.applyMatrix4(own);
      this.axes.put(tail, tip, kAxis_m, color);
      if (i === 1) return;
      const label = labels[i / 2];
      label.at.copy(tip);
      label.text = `${value.toFixed(0)} N/m`;
    });
    this.axes.done();
  }
}
