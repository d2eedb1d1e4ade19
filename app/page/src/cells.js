// SPDX-License-Identifier: Apache-2.0
// The cells of a pulp's contact points in the small views: which stick, which are at the limit of friction, and which slip.

import {BufferAttribute, CircleGeometry, Color, ConeGeometry, Group, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, Vector3} from 'three';

import {atLimit, slipping, stuck} from './colors.js';
import {splitForce} from './messages.js';

const kOnCone = 1e-6; // With less than this share of its friction to spare a point is on its cone, as the engine has it;
const kMoves_m_per_s = 1e-6; // and what is slower rests, likewise.
const kNear = 0.1; // With less to spare it is at the limit.
const kFelt = 1e-3; // Of a finger's largest normal force: what has less is not felt.
const kReach = 1.3; // of the radius that a round cell would have: so far do corners of cells go
const kSteep = 6; // of a cone: its height over its radius
const kRim = 0.45; // of a cell's light, at its reach
const kDot = 0.3; // of the radius, too

export const kSticks = 0, kAtLimit = 1, kSlips = 2;

/** By what a cell is told, in the order of the states; `dot`: the colour of what is in its middle. */
export const cellStates = [
  {name: 'sticks', color: stuck, dot: null},
  {name: 'at the limit', color: atLimit, dot: '#000000'},
  {name: 'slips', color: slipping, dot: '#ffffff'},
];

/** What a loaded point does: on its cone and moving it slips; else near the cone it is at the limit, and below it sticks. */
export function cellState(normal_N, tangential_N, friction, slip_m_per_s) {
  const most_N = friction * normal_N;
  if (tangential_N >= (1 - kOnCone) * most_N && slip_m_per_s > kMoves_m_per_s) return kSlips;
  return tangential_N > (1 - kNear) * most_N ? kAtLimit : kSticks;
}

/** Of each contact of a state {finger, control, normal_N, state}, but for those that are not felt. */
export function cellsOf(state) {
  const {columns, numbers} = state;
  const [friction] = state.values.friction;
  const cells = [];
  const most_N = [];
  for (let i = 0; i < state.contacts; ++i) {
    const at = state.contact(i);
    const {normal_N, friction_N} = splitForce(state, at);
    const finger = numbers[at + columns.finger];
    most_N[finger] = Math.max(most_N[finger] ?? 0, normal_N);
    cells.push({finger, control: numbers[at + columns.control_point], normal_N, at: at + columns.normal,
                state: cellState(normal_N, friction_N, friction, numbers[at + columns.slip_m_per_s])});
  }
  return cells.filter(({finger, normal_N}) => normal_N > kFelt * most_N[finger]);
}

const place = new Vector3();
const turn = new Quaternion();
const size = new Vector3();
const kOut = new Vector3(0, 0, 1);

/** A cone that points at who looks along its axis, and is darker at its rim. */
function cone() {
  const made = new ConeGeometry(1, kSteep, 32, 1, true).translate(0, kSteep / 2, 0).rotateX(Math.PI / 2);
  const {position} = made.attributes;
  const light = Float32Array.from({length: 3 * position.count}, (_, i) => (position.getZ(Math.floor(i / 3)) > kSteep / 2 ? 1 : kRim));
  return made.setAttribute('color', new BufferAttribute(light, 3));
}

/** Copies of a geometry, of which each has its place, its size and its colour. */
function many(geometry, material, most) {
  const made = new InstancedMesh(geometry, new MeshBasicMaterial(material), most);
  made.setColorAt(0, new Color());
  made.count = 0;
  made.frustumCulled = false;
  return made;
}

/**
 * Those of one pulp, in its frame. Cones that stand on points of a plane hide each other where the points' Voronoi cells
 * meet.
 */
export class Cells extends Group {
  #matrix = new Matrix4();
  #colors = cellStates.map(({color, dot}) => ({cell: new Color(color), dot: dot && new Color(dot)}));

  /** `finger`: of the geometry; `layer`: that of the small views. */
  constructor({controls, areas}, layer) {
    super();
    this.controls = controls;
    this.areas = areas;
    this.cones = many(cone(), {vertexColors: true}, areas.length);
    this.dots = many(new CircleGeometry(1, 24), {depthTest: false, transparent: true}, areas.length);
    this.dots.renderOrder = 3;
    this.add(this.cones, this.dots);
    for (const part of this.children) part.layers.set(layer);
  }

  clear() {
    this.cones.count = this.dots.count = 0;
  }

  /** A cell of this pulp; `u`: its displacements [m], so many times as large; `normal`: in the pulp's frame, outwards. */
  put({control, state}, u, exaggeration, normal) {
    const c = 3 * control;
    place.set(...[0, 1, 2].map((i) => this.controls[c + i] - exaggeration * u[c + i]));
    turn.setFromUnitVectors(kOut, normal);
    const radius_m = Math.sqrt(this.areas[control] / Math.PI);
    const {cell, dot} = this.#colors[state];
    this.#draw(this.cones, kReach * radius_m, cell);
    if (dot) this.#draw(this.dots, kDot * radius_m, dot);
  }

  #draw(part, radius_m, color) {
    const i = part.count++;
    part.setMatrixAt(i, this.#matrix.compose(place, turn, size.setScalar(radius_m)));
    part.setColorAt(i, color);
  }

  done() {
    for (const part of this.children) {
      part.instanceMatrix.needsUpdate = true;
      part.instanceColor.needsUpdate = true;
    }
  }
}
