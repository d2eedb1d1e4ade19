// SPDX-License-Identifier: Apache-2.0
// Principal stiffnesses: eigenvalues and axes of a symmetric matrix of three rows.

const kPairs = [[0, 1], [0, 2], [1, 2]];

/** `K`: nine numbers by rows. {values, axes}: the eigenvalues, the least first, and their unit vectors, right-handed. By Jacobi's rotations. */
export function principal(K) {
  const a = [0, 1, 2].map((i) => [0, 1, 2].map((j) => 0.5 * (K[3 * i + j] + K[3 * j + i])));
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // columns: the axes
  const size = Math.hypot(...a.flat());
  for (let sweep = 0; sweep < 20 && Math.hypot(a[0][1], a[0][2], a[1][2]) > 1e-14 * size; ++sweep) {
    for (const [p, q] of kPairs) {
      if (a[p][q] === 0) continue;
      const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]);
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      for (let i = 0; i < 3; ++i) [a[i][p], a[i][q]] = [c * a[i][p] - s * a[i][q], s * a[i][p] + c * a[i][q]];
      for (let i = 0; i < 3; ++i) [a[p][i], a[q][i]] = [c * a[p][i] - s * a[q][i], s * a[p][i] + c * a[q][i]];
      for (let i = 0; i < 3; ++i) [v[i][p], v[i][q]] = [c * v[i][p] - s * v[i][q], s * v[i][p] + c * v[i][q]];
    }
  }
  const order = [0, 1, 2].sort((i, j) => a[i][i] - a[j][j]);
  const axes = order.map((j) => [v[0][j], v[1][j], v[2][j]]);
  const [[ax, ay, az], [bx, by, bz]] = axes;
  axes[2] = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
  return {values: order.map((j) => a[j][j]), axes};
}
