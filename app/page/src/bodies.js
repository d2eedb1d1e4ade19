// SPDX-License-Identifier: Apache-2.0
// What is around the object: the bodies of its environment, and their forces on it.

import {
  BoxGeometry, BufferGeometry, CircleGeometry, Color, CylinderGeometry, DoubleSide, EdgesGeometry, Float32BufferAttribute,
  Group, LatheGeometry, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, Shape, ShapeGeometry,
  SphereGeometry, Vector2, Vector3,
} from 'three';

import {themed} from './colors.js';
import {kEdge, kFinger_m_per_N, marginColor} from './forces.js';
import {setPose, vector} from './poses.js';
import {Arrows} from './rods.js';

const kGlass = 0.45; // opacity of what may be in the way
const kPlane_m = 0.12, kGrid_m = 0.02; // radius of what is shown of a plane, and its lines
const kWall_m = 6e-3; // of a plate around its hole, and below it
const kCut_rad = 1.9; // so much of it is cut away, on the eye's side
const kMost = 64; // contacts
const kLeast_N = 5e-3; // of a sum that is named

export const hasBodies = (scene) => (scene.bodies?.length ?? 0) > 0;
/** Names of the labels of a scene's bodies. */
export const bodyLabels = (scene) => (scene.bodies ?? []).map(({name}) => `around ${name}`);

/** Half of the section of a plate with a blind hole, from the floor's middle on: pairs of radius and height [m]. */
export function holeSection([radius, depth, chamfer]) {
  const outer = radius + chamfer + kWall_m;
  const mouth = chamfer > 0 ? [[radius, -chamfer], [radius + chamfer, 0]] : [[radius, 0]];
  return [[0, -depth], [radius, -depth], ...mouth, [outer, 0], [outer, -depth - kWall_m], [0, -depth - kWall_m]];
}

/** The lines of a grid in a circle, along x and y: ends of three numbers each. */
export function gridLines(radius, spacing) {
  const ends = [];
  for (let n = -Math.floor(radius / spacing); n * spacing <= radius; ++n) {
    const half = Math.sqrt(Math.max(0, radius ** 2 - (n * spacing) ** 2));
    ends.push(n * spacing, -half, 0, n * spacing, half, 0, -half, n * spacing, 0, half, n * spacing, 0);
  }
  return ends;
}

const glass = () => new MeshLambertMaterial({transparent: true, opacity: kGlass, depthWrite: false});
const edges = (geometry) => new LineSegments(new EdgesGeometry(geometry, 30), new LineBasicMaterial());

/** A plate, cut open from the axis on: x is the middle of what is cut away. */
function plate(size) {
  const section = holeSection(size).map(([r, z]) => new Vector2(r, z));
  const group = new Group();
  section.slice(1).forEach((point, i) => {
    // A lathe turns about y, and begins at z.
    const turned = new LatheGeometry([section[i], point], 72, kCut_rad / 2 + Math.PI / 2, 2 * Math.PI - kCut_rad).rotateX(Math.PI / 2);
    group.add(new Mesh(turned, new MeshLambertMaterial({side: DoubleSide})), edges(turned));
  });
  for (const side of [-1, 1]) {
    const face = new ShapeGeometry(new Shape(section)).rotateX(Math.PI / 2).rotateZ((side * kCut_rad) / 2);
    group.add(new Mesh(face, new MeshLambertMaterial({side: DoubleSide})), edges(face));
  }
  return group;
}

function plane() {
  const disc = new Mesh(new CircleGeometry(kPlane_m, 72), glass());
  disc.material.side = DoubleSide;
  const lines = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(gridLines(kPlane_m, kGrid_m), 3));
  return new Group().add(disc, new LineSegments(lines, new LineBasicMaterial({transparent: true, opacity: 0.4})));
}

function convex(geometry) {
  return new Group().add(new Mesh(geometry, glass()), edges(geometry));
}

const kShapes = {
  plane,
  hole: plate,
  box: (size) => convex(new BoxGeometry(...size)),
  sphere: ([radius]) => convex(new SphereGeometry(radius, 48, 32)),
  cylinder: ([radius, length]) => convex(new CylinderGeometry(radius, radius, length, 72).rotateX(Math.PI / 2)),
};

const place = new Vector3();
const back = new Matrix4();

class Body extends Group {
  constructor({shape, size_m}) {
    super();
    this.shape = shape;
    this.matrixAutoUpdate = false;
    this.part = kShapes[shape]?.(size_m) ?? new Group(); // of a shape that is not known here nothing is shown
    this.part.traverse((part) => (part.receiveShadow = Boolean(part.isMesh)));
    this.add(this.part);
  }

  /** At number `at` of the poses; `object`: the object's pose. */
  show(poses, at, object) {
    setPose(this.matrix, poses, at);
    this.matrixWorldNeedsUpdate = true;
    if (this.shape !== 'plane') return;
    // What is shown of it goes along with the object; its lines stay where they are.
    place.setFromMatrixPosition(object).applyMatrix4(back.copy(this.matrix).invert());
    this.part.position.set(...[place.x, place.y].map((x) => kGrid_m * Math.round(x / kGrid_m)), 0);
  }

  /** Turns what is cut open to the eye. */
  face(eye) {
    if (this.shape !== 'hole') return;
    place.copy(eye).applyMatrix4(back.copy(this.matrix).invert());
    this.part.rotation.z = Math.atan2(place.y, place.x);
  }
}

export class Bodies extends Group {
  /** `scene`: the message. */
  constructor(scene) {
    super();
    this.bodies = (scene.bodies ?? []).map((body) => new Body(body));
    for (const body of this.bodies) this.add(body);
    this.setColor(themed('--around'), themed('--around-edge'));
  }

  setColor(color, edge) {
    this.traverse(({isMesh, isLineSegments, material}) => {
      if (isMesh) material.color.set(color);
      if (isLineSegments) material.color.set(edge);
    });
  }

  /** Of a state, with the object at `object`. */
  show(v, object) {
    this.bodies.forEach((body, k) => body.show(v.bodies, 12 * k, object));
  }

  face(camera) {
    for (const body of this.bodies) body.face(camera.position);
  }
}

const color = new Color();
const from = new Vector3();

/** An arrow for each contact, and a thick one for what each body does in sum. */
export class Touches extends Group {
  constructor(scene) {
    super();
    this.bodies = scene.bodies ?? [];
    this.arrows = new Arrows(kMost);
    this.sums = new Arrows(Math.max(1, this.bodies.length), {transparent: true, opacity: 0.75});
    this.add(this.arrows, this.sums);
  }

  /** Of a state; `labels`: as bodyLabels. */
  show(v, options, labels) {
    for (const label of labels) label.text = '';
    for (const things of [this.arrows, this.sums]) things.clear();
    if (options.forces && options.bodies && this.bodies.length > 0) {
      v.touches_margin.forEach((margin, i) => this.#drawTouch(v, i, margin));
      this.bodies.forEach(({name}, k) => this.#drawSum(name, k, v, labels[k]));
    }
    for (const things of [this.arrows, this.sums]) things.done();
  }

  #drawTouch(v, i, margin) {
    const point = vector(v.touches_m, 3 * i);
    if (!Number.isFinite(point.x)) return;
    from.copy(point).addScaledVector(vector(v.touches_N, 3 * i), -kFinger_m_per_N);
    this.arrows.put(from, point, 4e-4, marginColor(color, margin), margin < kEdge);
  }

  #drawSum(name, k, v, label) {
    const force = vector(v.bodies_N, 3 * k);
    const at = vector(v.bodies_m, 3 * k);
    if (!Number.isFinite(at.x) || force.length() < kLeast_N) return;
    color.set(themed('--around-force'));
    this.sums.put(label.at.copy(at).addScaledVector(force, -kFinger_m_per_N), at, 1.1e-3, color);
    label.text = `${name} ${force.length().toFixed(2)} N`;
  }
}
