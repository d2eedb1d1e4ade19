// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {principal} from '../src/principal.js';
import {choosesStiffness, effortText, isAtLimit, isSpent, lackText, withOne} from '../src/stiffness.js';
import {scene} from './synthetic.mjs';

const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

// K = sum of k a a' of its own axes: to rounding of sums of nine numbers of that size.
test('principal stiffnesses are those of the matrix, the least first, on right-handed axes', () => {
  const matrices = [[412, 31, -8, 31, 655, 120, -8, 120, 1190], [5, 0, 0, 0, 3, 0, 0, 0, 4], [150, 0, 0, 0, 150, 0, 0, 0, 150],
                    [1, 2, 3, 2, -4, 5, 3, 5, 0.1], Array(9).fill(0)];
  for (const K of matrices) {
    const {values, axes} = principal(K);
    const size = Math.hypot(...K);
    assert.ok(values[0] <= values[1] && values[1] <= values[2]);
    for (let i = 0; i < 3; ++i) {
      for (let j = 0; j < 3; ++j) {
        const sum = values.reduce((all, k, n) => all + k * axes[n][i] * axes[n][j], 0);
        assert.ok(Math.abs(sum - K[3 * i + j]) <= 1e-13 * size, `${K}: ${sum} where ${K[3 * i + j]} is`);
        assert.ok(Math.abs(dot(axes[i], axes[j]) - (i === j)) < 1e-14);
      }
    }
    const [[ax, ay, az], [bx, by, bz], c] = axes;
    assert.ok(dot([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], c) > 0.99);
  }
});

const muscles = [{name: 'APL', max_force_N: 80}, {name: 'EPB', max_force_N: 30}, {name: 'FPL', max_force_N: 100}];
const lacking = {time_s: [2], lack_s: [1.9], lack_N_per_m: [NaN], lack_Nm_per_rad: [0.0312], lack_axis: [1, 0, -0.01], lack_muscles: [1, 1, 0]};

test('what lacks is said with its muscles, and not for long', () => {
  assert.equal(lackText(lacking, muscles), 'rotation about (1.00, 0.00, \u22120.01) lacks 0.031 N m/rad; at their limit: APL, EPB');
  const along = {...lacking, lack_N_per_m: [52.4], lack_Nm_per_rad: [NaN], lack_muscles: [0, 0, 0]};
  assert.equal(lackText(along, muscles), 'translation along (1.00, 0.00, \u22120.01) lacks 52.4 N/m');
  assert.match(lackText({...lacking, lack_Nm_per_rad: [NaN]}, muscles), /posture gives way; at their limit: APL/);
  assert.equal(lackText({...lacking, time_s: [3]}, muscles), '');
  assert.equal(lackText({...lacking, lack_s: [NaN]}, muscles), '');
});

test('effort is the sum of the forces, beside the least', () => {
  const v = {muscles_N: Float64Array.of(60, 29, 20), least_muscles_N: Float64Array.of(10, 0, 15)};
  assert.equal(effortText(v), '109 N, at the least 25 N');
  assert.equal(effortText({...v, least_muscles_N: Float64Array.of(NaN, NaN, NaN)}), '109 N');
});

test('a muscle is at its limit where nothing is left', () => {
  assert.deepEqual([[80, 80], [79.99, 80], [79, 80], [0, 80]].map(([f, most]) => isAtLimit(f, most)), [true, true, false, false]);
});

test('a muscle is marked while it, or what lacked lately, has it at its limit', () => {
  const spent = (v) => muscles.map((muscle, m) => isSpent(v, m, muscle));
  assert.deepEqual(spent({...lacking, muscles_N: [10, 10, 100]}), [true, true, true]);
  assert.deepEqual(spent({...lacking, muscles_N: [10, 10, 10], time_s: [4]}), [false, false, false]);
  assert.deepEqual(spent({muscles_N: [10, 30, 10], time_s: [4]}), [false, true, false]); // a scene that chooses none
});

test('one axis changes alone, or all do', () => {
  assert.deepEqual(withOne([1, 2, 3], 1, 5, false), [1, 5, 3]);
  assert.deepEqual(withOne([1, 2, 3], 1, 5, true), [5, 5, 5]);
});

test('a scene that chooses no stiffness shows none', () => {
  assert.equal(choosesStiffness(scene), false);
  assert.equal(choosesStiffness({...scene, object_stiffness: null}), false); // muscles that have stiffness by themselves
  assert.equal(choosesStiffness({...scene, object_stiffness: {centre_m: [0, 0, 0], frozen_from_s: null}}), true);
});
