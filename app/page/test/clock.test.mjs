// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {RemoteClock} from '../src/clock.js';

test('the estimate is off by half the shortest round trip at most, whatever the ways there and back', () => {
  let seed = 12345;
  const random = () => (seed = (1103515245 * seed + 12345) % 2 ** 31) / 2 ** 31;
  const offset_s = 1234.5;
  const clock = new RemoteClock();
  assert.equal(clock.at(1), undefined);
  let shortest_s = Infinity;
  for (let i = 0; i < 25; ++i) {
    const there_s = 0.05 * random();
    const back_s = 0.05 * random();
    clock.add(2 * i, 2 * i + there_s + back_s, 2 * i + there_s + offset_s);
    shortest_s = Math.min(shortest_s, there_s + back_s);
    assert.ok(Math.abs(clock.at(100) - (100 + offset_s)) <= shortest_s / 2 + 1e-9);
  }
});

test('a short trip of long ago is forgotten: the clocks may have drifted since', () => {
  const clock = new RemoteClock();
  clock.add(0, 1e-6, 50);
  for (let i = 1; i <= 30; ++i) clock.add(2 * i, 2 * i + 0.01, 2 * i + 0.005 + 51);
  assert.ok(Math.abs(clock.at(0) - 51) < 1e-9);
});

test('what is no number or no trip counts for nothing', () => {
  const clock = new RemoteClock();
  clock.add(1, 0, 5);
  clock.add(0, 1, NaN);
  clock.add(0, undefined, 5);
  assert.equal(clock.at(0), undefined);
});
