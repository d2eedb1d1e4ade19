// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Events} from '../src/events.js';

const scene = {phases: ['close', 'lift'], fingers: [{name: 'thumb'}, {name: 'index'}]};
const state = (time_s, friction, phase, reflex_s = NaN) =>
  ({time_s: [time_s], friction: [friction], phase: [phase], last_reflex: [2], last_reflex_finger: [1], last_reflex_s: [reflex_s]});

test('what happens is told once, at its time, and forgotten when the time is set back', () => {
  const events = new Events();
  events.load(scene);
  events.add(state(0, 0.8, 0), 'held');
  events.add(state(0.1, 0.8, 0), 'held');
  events.add(state(0.2, 0.15, 1), 'held');
  events.add(state(0.3, 0.15, 1, 0.265), 'held');
  events.add(state(0.4, 0.15, 2, 0.265), 'held');
  events.add(state(0.5, 0.15, 2, 0.265), 'lost');
  events.add(state(0.6, 0.15, 2, 0.265), 'lost');
  assert.deepEqual(events.list, [
    {time_s: 0, what: 'close'}, {time_s: 0.2, what: 'friction falls to 0.15'}, {time_s: 0.2, what: 'lift'},
    {time_s: 0.265, what: 'grip answers slip, index'}, {time_s: 0.4, what: 'task done'}, {time_s: 0.5, what: 'lost'},
  ]);
  events.add(state(0.05, 0.8, 0), 'held');
  assert.deepEqual(events.list, [{time_s: 0.05, what: 'close'}]);
});

test('a scene without phases and touch has none of their events', () => {
  const events = new Events();
  events.load({fingers: []});
  for (const time_s of [0, 1]) events.add({time_s: [time_s], friction: [0.5]}, 'held');
  assert.deepEqual(events.list, []);
});
