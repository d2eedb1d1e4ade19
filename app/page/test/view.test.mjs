// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Matrix4, PerspectiveCamera, Vector3} from 'three';

import {aimAt, placesOf} from '../src/view.js';

/** Numbers in 0 .. 1, the same in every run. */
function numbers(seed) {
  let state = seed;
  return () => (state = (16807 * state) % 2147483647) / 2147483647;
}

test('the first view shows all of hand and object between its margins, and one of them touches a margin', () => {
  const random = numbers(7);
  const point = (reach) => new Vector3(...[0, 0, 0].map(() => reach * (random() - 0.5)));
  for (let i = 0; i < 40; ++i) {
    const camera = new PerspectiveCamera(30, 0.3 + 2.2 * random(), 0.02, 3);
    camera.updateProjectionMatrix();
    const places = Array.from({length: 30}, () => point(0.25));
    const margins = {left: 0.03, right: 0.3 * random(), top: 0.04, bottom: 0.3 * random()};
    const centre = point(0.1);
    const target = aimAt(camera, {tips: [point(0.1), point(0.1)], up: point(1).normalize(), places, centre}, margins);
    camera.updateMatrixWorld();
    let slack = Infinity; // the least share of the view between a place and a margin
    for (const place of places) {
      const {x, y} = place.clone().project(camera);
      const free = [(1 + x) / 2 - margins.left, (1 - x) / 2 - margins.right, (1 - y) / 2 - margins.top, (1 + y) / 2 - margins.bottom];
      assert.ok(Math.min(...free) > 0, `${x}, ${y} is beyond ${JSON.stringify(margins)}`);
      slack = Math.min(slack, ...free);
    }
    // 8 mm around each place are seen, too: of a view of 0.1 m, the narrowest that 0.25 m of places make, they are 0.08.
    assert.ok(slack < 0.1, `the view could be nearer by ${slack}`);
    const {x, y} = target.clone().project(camera);
    assert.ok(Math.hypot(x, y) < 1e-9, 'it looks at its target');
  }
});

test('what is to be seen is wrist, joints, fingertips and the surface of the object where it is', () => {
  const hand = {segments: [{length_m: 0.04, joints: 1}, {length_m: 0, joints: 0}], fingers: [{segment: 0, centre_m: [0.05, 0, 0]}]};
  const poses = [new Matrix4().makeTranslation(0, 0.1, 0), new Matrix4()];
  const places = placesOf(hand, poses, new Float32Array([1, 2, 3]), new Matrix4().makeTranslation(1, 0, 0));
  const rounded = places.map((place) => place.toArray().map((x) => Number(x.toFixed(6))));
  assert.deepEqual(rounded, [[0, 0, 0], [0, 0.1, 0], [0.04, 0.1, 0], [0.05, 0.1, 0], [2, 2, 3]]);
  assert.equal(placesOf({...hand, slides: true}, poses, [], new Matrix4()).length, 3, 'rods have no wrist');
});
