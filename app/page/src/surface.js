// SPDX-License-Identifier: Apache-2.0
// The object: as a closed surface, where the message has one, else as discs at its samples.

import {BufferAttribute, BufferGeometry, Color, Mesh, MeshLambertMaterial, NotEqualStencilFunc, ReplaceStencilOp} from 'three';

import {Splats, thinned} from './splats.js';

const kCrease = Math.cos((35 * Math.PI) / 180); // faces that meet more sharply have an edge between them
const kCovered = 1; // in the stencil: a pixel of the object

/**
 * Corners of triangles, three each, with normals: those of the faces around that are alike, by area. `vertices`: three
 * numbers each; `triangles`: three numbers of vertices each.
 */
export function creased(vertices, triangles) {
  const corners = triangles.length;
  const positions = new Float32Array(3 * corners);
  const normals = new Float32Array(3 * corners);
  const faces = new Float32Array(corners); // of each triangle its normal, as long as twice its area
  for (let t = 0; t < corners; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const [ux, uy, uz] = [vertices[b] - vertices[a], vertices[b + 1] - vertices[a + 1], vertices[b + 2] - vertices[a + 2]];
    const [vx, vy, vz] = [vertices[c] - vertices[a], vertices[c + 1] - vertices[a + 1], vertices[c + 2] - vertices[a + 2]];
    faces[t] = uy * vz - uz * vy;
    faces[t + 1] = uz * vx - ux * vz;
    faces[t + 2] = ux * vy - uy * vx;
  }
  // The corners at each vertex, one after the other.
  const begin = new Uint32Array(vertices.length / 3 + 1);
  for (const vertex of triangles) begin[vertex + 1] += 1;
  for (let i = 1; i < begin.length; ++i) begin[i] += begin[i - 1];
  const at = new Uint32Array(corners);
  const next = begin.slice();
  triangles.forEach((vertex, corner) => (at[next[vertex]++] = corner));
  for (let corner = 0; corner < corners; ++corner) {
    const vertex = triangles[corner];
    const own = corner - (corner % 3);
    const [x, y, z] = [faces[own], faces[own + 1], faces[own + 2]];
    const size = Math.hypot(x, y, z);
    let [nx, ny, nz] = [0, 0, 0];
    for (let i = begin[vertex]; i < begin[vertex + 1]; ++i) {
      const face = at[i] - (at[i] % 3);
      const [fx, fy, fz] = [faces[face], faces[face + 1], faces[face + 2]];
      if (x * fx + y * fy + z * fz < kCrease * size * Math.hypot(fx, fy, fz)) continue;
      nx += fx;
      ny += fy;
      nz += fz;
    }
    const length = Math.hypot(nx, ny, nz) || 1;
    normals.set([nx / length, ny / length, nz / length], 3 * corner);
    positions.set(vertices.subarray(3 * vertex, 3 * vertex + 3), 3 * corner);
  }
  return {positions, normals};
}

class Surface extends Mesh {
  /** With an opacity below 1 only the nearest faces show. */
  constructor({vertices, triangles}, color, {opacity}) {
    const geometry = new BufferGeometry();
    const {positions, normals} = creased(vertices, triangles);
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new BufferAttribute(normals, 3));
    super(geometry, new MeshLambertMaterial({color}));
    // As of splats, a first pass leaves the nearest faces.
    this.depth = new Mesh(geometry, new MeshLambertMaterial({colorWrite: false, transparent: true}));
    this.depth.renderOrder = 1;
    this.renderOrder = 2;
    for (const part of [this, this.depth]) part.frustumCulled = false;
    this.add(this.depth);
    this.setOpacity(opacity);
  }

  setColor(color) {
    this.material.color = new Color(color);
  }

  setOpacity(opacity) {
    this.material.opacity = opacity;
    this.material.transparent = opacity < 1;
    this.material.needsUpdate = true;
    this.depth.visible = opacity < 1;
  }

  /** As splats have it: triangles need to know no camera. */
  fit() {}

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
    this.depth.material.dispose();
  }
}

/** The object of a scene's message and geometry. `enough`: splats, where it needs them. */
export function makeObject(scene, {object}, color, {enough, opacity = 1, tilted}) {
  if (object.triangles.length > 0) return new Surface(object, color, {opacity});
  const {points, normals, growth} = thinned(object.points, object.normals, enough);
  return new Splats(points, normals, growth * scene.object.spacing_m, color, {opacity, tilted});
}

/**
 * Draws the ghost of an object only where the object itself does not cover it. Two surfaces that nearly coincide would
 * else show as bands of both colours, which change with the view.
 */
export function hideBehind(object, ghost) {
  for (const {material} of [object, object.depth]) {
    Object.assign(material, {stencilWrite: true, stencilRef: kCovered, stencilZPass: ReplaceStencilOp});
  }
  for (const part of [ghost, ghost.depth]) {
    Object.assign(part.material, {stencilWrite: true, stencilRef: kCovered, stencilFunc: NotEqualStencilFunc});
    part.renderOrder += 2; // after the object, also where that is seen through
  }
}
