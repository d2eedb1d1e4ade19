// SPDX-License-Identifier: Apache-2.0
// A fingertip: its surface moved by -u, coloured by pressure.

import {BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshLambertMaterial, Vector3} from 'three';
import {ConvexHull} from 'three/addons/math/ConvexHull.js';

import {pressureColor} from './colors.js';

const kNeighbours = 10;

/**
 * What each control point weighs at each sample: of the ten nearest ones, Gaussian weights of one control spacing that sum to
 * 1 [27]. {index, weight}, ten a sample.
 */
export function sampleWeights(points, controls, areas) {
  const samples = points.length / 3;
  const count = areas.length;
  const neighbours = Math.min(kNeighbours, count);
  const index = new Uint16Array(neighbours * samples);
  const weight = new Float32Array(neighbours * samples);
  const spacing2 = areas.reduce((sum, area) => sum + area, 0) / count;
  const nearest = new Float64Array(neighbours);
  for (let s = 0; s < samples; ++s) {
    const at = neighbours * s;
    nearest.fill(Infinity);
    for (let c = 0; c < count; ++c) {
      const d2 = (points[3 * s] - controls[3 * c]) ** 2 + (points[3 * s + 1] - controls[3 * c + 1]) ** 2 +
          (points[3 * s + 2] - controls[3 * c + 2]) ** 2;
      let place = neighbours - 1;
      if (d2 >= nearest[place]) continue;
      for (; place > 0 && nearest[place - 1] > d2; --place) {
        nearest[place] = nearest[place - 1];
        index[at + place] = index[at + place - 1];
      }
      nearest[place] = d2;
      index[at + place] = c;
    }
    let sum = 0;
    for (let e = 0; e < neighbours; ++e) sum += weight[at + e] = Math.exp((nearest[0] - nearest[e]) / (2 * spacing2));
    for (let e = 0; e < neighbours; ++e) weight[at + e] /= sum;
  }
  return {index, weight, neighbours};
}

/** Triangles of a pulp's samples, which lie on a convex surface: those of their hull, by the samples' numbers. */
function triangles(points) {
  const vertices = [];
  const number = new Map();
  for (let i = 0; i < points.length; i += 3) {
    const vertex = new Vector3(points[i], points[i + 1], points[i + 2]).multiplyScalar(1e3);
    number.set(vertex, i / 3);
    vertices.push(vertex);
  }
  const index = [];
  for (const face of new ConvexHull().setFromPoints(vertices).faces) {
    let edge = face.edge;
    do {
      index.push(number.get(edge.head().point));
      edge = edge.next;
    } while (edge !== face.edge);
  }
  return index;
}

export class Pulp extends Mesh {
  constructor({points, normals, controls, areas}) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points.slice(), 3));
    geometry.setAttribute('normal', new BufferAttribute(normals.slice(), 3));
    geometry.setAttribute('color', new BufferAttribute(new Float32Array(points.length), 3));
    geometry.setIndex(triangles(points));
    super(geometry, new MeshLambertMaterial({vertexColors: true, side: DoubleSide}));
    this.frustumCulled = false;
    this.matrixAutoUpdate = false;
    this.rest = points;
    this.areas = areas;
    this.weights = sampleWeights(points, controls, areas);
    this.pressure_Pa = new Float32Array(areas.length);
    this.paint(1);
  }

  /** `u` is the state's displacement of this pulp, three numbers a control point [m]: the surface moves by -u. */
  displace(u, exaggeration) {
    const {index, weight, neighbours} = this.weights;
    const position = this.geometry.attributes.position;
    const out = position.array;
    for (let s = 0, e = 0; s < out.length; s += 3) {
      let x = 0;
      let y = 0;
      let z = 0;
      for (const last = e + neighbours; e < last; ++e) {
        const c = 3 * index[e];
        x += weight[e] * u[c];
        y += weight[e] * u[c + 1];
        z += weight[e] * u[c + 2];
      }
      out[s] = this.rest[s] - exaggeration * x;
      out[s + 1] = this.rest[s + 1] - exaggeration * y;
      out[s + 2] = this.rest[s + 2] - exaggeration * z;
    }
    position.needsUpdate = true;
    this.#updateNormals();
  }

  /** Colours the surface by `pressure_Pa`, spread as the displacement is; `full_Pa` has the last colour. */
  paint(full_Pa) {
    const {index, weight, neighbours} = this.weights;
    const color = this.geometry.attributes.color;
    for (let s = 0, e = 0; s < color.array.length; s += 3) {
      let p = 0;
      for (const last = e + neighbours; e < last; ++e) p += weight[e] * this.pressure_Pa[index[e]];
      pressureColor(p / full_Pa, color.array, s);
    }
    color.needsUpdate = true;
  }

  #updateNormals() {
    const p = this.geometry.attributes.position.array;
    const normal = this.geometry.attributes.normal;
    const n = normal.array.fill(0);
    const faces = this.geometry.index.array;
    for (let f = 0; f < faces.length; f += 3) {
      const a = 3 * faces[f];
      const b = 3 * faces[f + 1];
      const c = 3 * faces[f + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      for (const i of [a, b, c]) {
        n[i] += x;
        n[i + 1] += y;
        n[i + 2] += z;
      }
    }
    normal.needsUpdate = true; // the shader makes them unit
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}
