// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {AlwaysStencilFunc, KeepStencilOp, NotEqualStencilFunc, ReplaceStencilOp} from 'three';

import {creased, hideBehind, makeObject} from '../src/surface.js';
import {Splats} from '../src/splats.js';
import {readGeometry} from '../src/messages.js';
import {geometry, kTetrahedron, scene, withSurface} from './synthetic.mjs';

const dot = (a, b, i) => a[i] * b[0] + a[i + 1] * b[1] + a[i + 2] * b[2];

/** A square of n x n cells in z = 0, bent by an angle along its middle. */
function bent(n, angle) {
  const vertices = [], triangles = [];
  for (let i = 0; i <= n; ++i) {
    for (let j = 0; j <= n; ++j) {
      const x = i - n / 2;
      vertices.push(x > 0 ? x * Math.cos(angle) : x, j, x > 0 ? x * Math.sin(angle) : 0);
    }
  }
  for (let i = 0; i < n; ++i) {
    for (let j = 0; j < n; ++j) {
      const a = i * (n + 1) + j;
      triangles.push(a, a + n + 1, a + n + 2, a, a + n + 2, a + 1);
    }
  }
  return {vertices: Float32Array.from(vertices), triangles: Uint32Array.from(triangles)};
}

test('faces that meet sharply keep their normals, others share them', () => {
  const sharp = bent(4, Math.PI / 2);
  const {positions, normals} = creased(sharp.vertices, sharp.triangles);
  for (let i = 0; i < normals.length; i += 9) {
    const middle_x = (positions[i] + positions[i + 3] + positions[i + 6]) / 3;
    const expected = middle_x < -1e-6 ? [0, 0, 1] : [-1, 0, 0];
    for (let k = 0; k < 9; k += 3) assert.ok(dot(normals, expected, i + k) > 0.999, 'of its own face');
  }
  const soft = bent(4, 0.3);
  const {positions: p, normals: n} = creased(soft.vertices, soft.triangles);
  for (let i = 0; i < n.length; i += 3) {
    assert.ok(Math.abs(Math.hypot(n[i], n[i + 1], n[i + 2]) - 1) < 1e-6);
    if (Math.abs(p[i]) > 1e-6 || p[i + 1] < 1 || p[i + 1] > 3) continue; // on the bend, away from its ends
    assert.ok(dot(n, [-Math.sin(0.15), 0, Math.cos(0.15)], i) > 0.9999, 'the mean of both');
  }
});

test('the object is drawn as its surface where there is one, else as discs', () => {
  const options = {enough: 1000, tilted: false};
  const discs = makeObject(scene, readGeometry(new Uint8Array(geometry()), scene), '#888888', options);
  assert.ok(discs instanceof Splats);
  const {scene: closed, geometry: message} = withSurface(kTetrahedron);
  const surface = makeObject(closed, readGeometry(new Uint8Array(message), closed), '#888888', {...options, opacity: 0.3});
  assert.ok(!(surface instanceof Splats));
  assert.equal(surface.geometry.attributes.position.count, 12);
  assert.ok(surface.depth.visible && surface.material.transparent);
  surface.setOpacity(1);
  assert.ok(!surface.depth.visible && !surface.material.transparent);
  surface.setColor('#102030');
  assert.equal(surface.material.color.getHexString(), '102030');
});

test('a ghost is drawn after its object, and only where that does not cover it', () => {
  const {scene: closed, geometry: message} = withSurface(kTetrahedron);
  for (const [shape, bytes] of [[scene, geometry()], [closed, message]]) {
    const make = (opacity) => makeObject(shape, readGeometry(new Uint8Array(bytes), shape), '#888888', {enough: 1000, tilted: false, opacity});
    const [object, ghost] = [make(1), make(0.3)];
    hideBehind(object, ghost);
    for (const {material} of [object, object.depth]) {
      assert.ok(material.stencilWrite && material.stencilZPass === ReplaceStencilOp && material.stencilFunc === AlwaysStencilFunc);
    }
    for (const {material, renderOrder} of [ghost, ghost.depth]) {
      assert.ok(material.stencilFunc === NotEqualStencilFunc && material.stencilRef === object.material.stencilRef);
      assert.equal(material.stencilZPass, KeepStencilOp, 'it marks nothing itself');
      assert.ok(renderOrder > object.renderOrder, 'also of an object that is seen through');
    }
  }
});
