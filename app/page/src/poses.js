// SPDX-License-Identifier: Apache-2.0
// Numbers of messages as vectors and matrices.

import {Vector3} from 'three';

export const vector = (numbers, at = 0) => new Vector3(numbers[at], numbers[at + 1], numbers[at + 2]);
export const isFinite3 = (numbers) => Number.isFinite(numbers[0] + numbers[1] + numbers[2]);

/** A pose of a message: position, then rotation by rows. */
export function setPose(matrix, n, at = 0) {
  return matrix.set(n[at + 3], n[at + 4], n[at + 5], n[at], n[at + 6], n[at + 7], n[at + 8], n[at + 1],
                    n[at + 9], n[at + 10], n[at + 11], n[at + 2], 0, 0, 0, 1);
}

/** The angle between two poses' rotations [rad]. */
export function angleBetween(a, b) {
  const p = a.elements;
  const q = b.elements;
  let trace = 0;
  for (const i of [0, 1, 2, 4, 5, 6, 8, 9, 10]) trace += p[i] * q[i];
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2)));
}
