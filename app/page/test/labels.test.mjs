// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Vector3} from 'three';

import {placeLabels} from '../src/labels.js';

const kWide = 100, kHigh = 18; // of a label, in pixels

/** Where labels of these places [px] are put. */
function placed(places) {
  const labels = places.map(([x, y]) => ({element: {style: {}}, at: new Vector3(x, y, 0), text: 'here'}));
  placeLabels(labels, ([x, y]) => [x, y]);
  return labels.map(({element}) => element.style.transform.match(/-?[\d.e+]+(?=px)/g).map(Number));
}

function expectClear(places) {
  const labels = placed(places);
  labels.forEach(([x, y], i) => labels.slice(0, i).forEach(([u, v]) => {
    // They are written with one digit.
    assert.ok(Math.abs(u - x) > kWide - 0.11 || Math.abs(v - y) > kHigh - 0.11, `${x} ${y} lies on ${u} ${v}`);
  }));
}

test('labels of one place stand below each other, also where their height rounds', () => {
  // Of 500.3 the next line begins at 518.3 - 6e-14.
  for (let tenths = 4000; tenths < 6000; ++tenths) expectClear(Array(4).fill([300, tenths / 10]));
  assert.deepEqual(placed([[300, 500.3], [300, 500.3], [300, 500.3]]), [[300, 500.3], [300, 518.3], [300, 536.3]]);
});

test('labels that touch in any order are clear of each other, and others stay', () => {
  let seed = 12345;
  const random = () => (seed = (1103515245 * seed + 12345) % 2 ** 31) / 2 ** 31;
  for (let i = 0; i < 1000; ++i) expectClear(Array.from({length: 5}, () => [250 * random(), 80 * random()]));
  assert.deepEqual(placed([[0, 0], [100, 0], [0, 18]]), [[0, 0], [100, 0], [0, 18]]);
});

test('labels of places that are far out of the picture, or nowhere, come to an end', () => {
  for (const far of [1e9, 1e17, 1e300, Infinity, NaN]) placeLabels([0, 1, 2].map(() => ({
    element: {style: {}}, at: new Vector3(far, far, 0), text: 'far'})), ([x, y]) => [x, y]);
});

test('a label without text is hidden and takes no place', () => {
  const labels = ['', 'here'].map((text) => ({element: {style: {}}, at: new Vector3(5, 5, 0), text}));
  placeLabels(labels, ([x, y]) => [x, y]);
  assert.equal(labels[0].element.hidden, true);
  assert.match(labels[1].element.style.transform, /^translate\(5\.0px, 5\.0px\)/);
});
