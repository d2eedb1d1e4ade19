// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Color, Vector3} from 'three';

import {Cells, cellState, cellStates, cellsOf, kAtLimit, kSlips, kSticks} from '../src/cells.js';
import {distance, sights} from './color_vision.mjs';

test('a point on its cone slips where it moves, and is at the limit near it', () => {
  assert.equal(cellState(1, 0.4, 0.5, 1e-3), kSticks, 'it creeps');
  assert.equal(cellState(1, 0.46, 0.5, 0), kAtLimit);
  assert.equal(cellState(1, 0.5 * (1 - 1e-5), 0.5, 1e-3), kAtLimit, 'it creeps');
  assert.equal(cellState(1, 0.5 * (1 - 1e-7), 0.5, 1e-7), kAtLimit);
  assert.equal(cellState(1, 0.5, 0.5, 0), kAtLimit);
  assert.equal(cellState(1, 0.5, 0.5, 1e-3), kSlips);
  assert.equal(cellState(1, 0.6, 0.5, 1e-3), kSlips, 'friction may have fallen since');
});

/** A state of contacts [finger, control point, normal force along x, tangential force along y, slip]. */
function stateOf(rows) {
  return {
    contacts: rows.length, contact: (i) => 9 * i, values: {friction: [0.5]},
    columns: {finger: 0, control_point: 1, normal: 2, force_N: 5, slip_m_per_s: 8},
    numbers: rows.flatMap(([finger, control, f_n, f_t, slip]) => [finger, control, 1, 0, 0, f_n, f_t, 0, slip]),
  };
}

test('cells are those of the points that are felt, of each finger by its own load', () => {
  const rows = [[0, 7, 1, 0.1, 0], [0, 8, 0.5, 0.25, 1e-3], [0, 9, 1e-4, 5e-5, 1e-3], [1, 3, 1e-4, 5e-5, 0], [1, 4, 0, 0, 0]];
  assert.deepEqual(cellsOf(stateOf(rows)).map(({finger, control, state}) => [finger, control, state]),
                   [[0, 7, kSticks], [0, 8, kSlips], [1, 3, kAtLimit]]);
  assert.deepEqual(cellsOf(stateOf([])), []);
});

test('twenty cells of a finger have the colours of their states, and dots in those on the cone', () => {
  const finger = {controls: new Float32Array(60).map((_, i) => 1e-3 * i), areas: new Float32Array(20).fill(1e-6)};
  const cells = new Cells(finger, 1);
  const u = new Float64Array(60).fill(1e-4);
  for (let repeat = 0; repeat < 2; ++repeat) {
    cells.clear();
    for (let control = 0; control < 20; ++control) cells.put({control, state: control % 3}, u, 10, new Vector3(1, 0, 0));
    cells.done();
  }
  assert.equal(cells.cones.count, 20);
  assert.equal(cells.dots.count, 13);
  const color = new Color();
  const at = new Vector3();
  for (let i = 0; i < 20; ++i) {
    cells.cones.getColorAt(i, color);
    assert.equal(`#${color.getHexString()}`, cellStates[i % 3].color);
    at.setFromMatrixPosition({elements: cells.cones.instanceMatrix.array.subarray(16 * i, 16 * i + 16)});
    assert.ok(Math.abs(at.x - (3e-3 * i - 1e-3)) < 1e-7, 'where the deformed surface is');
  }
});

// As unlike as stuck and slipping have to be: colors.test.mjs.
test('who lacks a kind of cones tells the three states of cells as others do', () => {
  for (const sight of sights) {
    cellStates.forEach(({color}, i) => cellStates.slice(0, i).forEach((other) =>
      assert.ok(distance(color, other.color, sight) >= 40, `${color}, ${other.color}, ${sight}: ${distance(color, other.color, sight)}`)));
  }
  assert.equal(new Set(cellStates.map(({dot}) => dot)).size, 3, 'and by their dots');
});
