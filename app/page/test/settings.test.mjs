// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {textOf, valuesOf} from '../src/settings.js';

const friction = {type: 'number', least: 0, most: 2, default: 0.8, unit: ''};
const rate = {type: 'number', least: 200, most: 10000, default: 3456, unit: 'Hz'};
const sweeps = {type: 'whole', least: 1, most: 1000, default: 60, unit: ''};
const tolerance = {type: 'number', least: 1e-10, most: 0.1, default: 1e-7, unit: ''};
const delay = {type: 'whole', least: 0, most: 8, default: 0, unit: 'periods'};

test('a slider goes from end to end in rising values, the scene\'s own among them, and has room for each', () => {
  for (const setting of [friction, rate, sweeps, tolerance, delay]) {
    const values = valuesOf(setting);
    assert.equal(values[0], setting.least);
    assert.equal(values.at(-1), setting.most);
    assert.ok(values.includes(setting.default));
    assert.ok(values.length >= 9 && values.length <= 60, `${values.length} values`);
    values.forEach((x, i) => assert.ok(i === 0 || x > values[i - 1]));
    if (setting.type === 'whole') assert.ok(values.every(Number.isInteger));
  }
});

test('a narrow range has even steps, a wide one even ratios, the widest decades', () => {
  assert.deepEqual(valuesOf(friction).slice(0, 4), [0, 0.05, 0.1, 0.15]);
  assert.deepEqual(valuesOf(delay), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
  assert.deepEqual(valuesOf(tolerance), [1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1]);
  const values = valuesOf({...rate, default: 1000});
  values.forEach((x, i) => assert.ok(i === 0 || x / values[i - 1] < 1.5));
});

test('a value is said with its unit', () => {
  assert.equal(textOf(rate, 4000), '4000 Hz');
  assert.equal(textOf(friction, 0.15), '0.15');
  assert.equal(textOf(tolerance, 1e-7), '1.0·10⁻⁷');
  assert.equal(textOf({type: 'choice', choices: ['gaussian']}, 'gaussian'), 'gaussian');
});
