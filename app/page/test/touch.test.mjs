// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {feels, feltMargin, reflexText} from '../src/touch.js';
import {scene} from './synthetic.mjs';

test('a scene feels where its states say what sticks', () => {
  assert.ok(!feels(scene));
  assert.ok(feels({...scene, fields: [...scene.fields, {name: 'stick', unit: '', begin: 0, count: 3}]}));
});

test('the felt margin is what is left of the felt friction', () => {
  assert.ok(Math.abs(feltMargin(0.5, 2, 0.25) - 0.75) < 1e-12);
  assert.ok(feltMargin(0.5, 2, 1.5) < 0);
  assert.ok(Number.isNaN(feltMargin(0.5, 0, 0)));
});

test('the last reflex is told with its finger and time', () => {
  const fingers = [{name: 'thumb'}, {name: 'index'}];
  assert.equal(reflexText({last_reflex: [1], last_reflex_finger: [1], last_reflex_s: [0.8749]}, fingers), 'index, load, 0.87 s');
  assert.equal(reflexText({last_reflex: [2], last_reflex_finger: [0], last_reflex_s: [1.5]}, fingers), 'thumb, slip, 1.50 s');
  assert.equal(reflexText({last_reflex: [0], last_reflex_finger: [NaN], last_reflex_s: [NaN]}, fingers), '–');
  assert.equal(reflexText({}, fingers), '–', 'of a recording that does not have it');
});
