// SPDX-License-Identifier: Apache-2.0
// The bodies around the object: what is drawn of them is as large as they are.
//     node --test bodies.test.mjs

import assert from 'node:assert/strict';
import {test} from 'node:test';

import {bodyLabels, gridLines, hasBodies, holeSection} from '../src/bodies.js';

/** The volume of a half section turned about z [m^3]: Pappus, by the pairs of a polygon. */
function turnedVolume(section) {
  let sum = 0;
  section.forEach(([r, z], i) => {
    const [s, w] = section[(i + 1) % section.length];
    sum += ((r * r + r * s + s * s) * (z - w)) / 3;
  });
  return Math.abs(Math.PI * sum);
}

test('the section of a plate leaves out what its hole is', () => {
  const [radius, depth] = [0.01, 0.04];
  for (const chamfer of [0, 1e-3, 5e-3]) {
    const section = holeSection([radius, depth, chamfer]);
    const outer = Math.max(...section.map(([r]) => r));
    const below = -Math.min(...section.map(([, z]) => z));
    assert.ok(outer > radius + chamfer && below > depth);
    // A bore, and above it a cone frustum less the bore: chamfer (a^2 + a b + b^2) / 3 from b = radius to a = b + chamfer.
    const a = radius + chamfer;
    const hole = Math.PI * (radius ** 2 * (depth - chamfer) + (chamfer * (a * a + a * radius + radius * radius)) / 3);
    const whole = Math.PI * outer ** 2 * below;
    assert.ok(Math.abs(turnedVolume(section) - (whole - hole)) < 1e-12 * whole + 1e-15, `chamfer ${chamfer}`);
    assert.equal(new Set(section.map(String)).size, section.length, 'no point twice');
  }
});

test('the lines of a plane end on their circle, at even distances', () => {
  const ends = gridLines(0.1, 0.02);
  assert.equal(ends.length % 12, 0);
  for (let i = 0; i < ends.length; i += 6) {
    for (const at of [i, i + 3]) {
      const [x, y, z] = ends.slice(at, at + 3);
      assert.ok(Math.abs(Math.hypot(x, y) - 0.1) < 1e-12 && z === 0);
    }
    const along = [0, 1].find((axis) => ends[i + axis] === ends[i + 3 + axis]);
    assert.ok(Math.abs(ends[i + along] / 0.02 - Math.round(ends[i + along] / 0.02)) < 1e-9);
  }
});

test('scenes of before, and those without an environment, have no bodies', () => {
  assert.equal(hasBodies({}), false);
  assert.deepEqual(bodyLabels({}), []);
  assert.deepEqual(bodyLabels({bodies: [{name: 'slope', shape: 'plane', size_m: [0, 0, 0]}]}), ['around slope']);
});
