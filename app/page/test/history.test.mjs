// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Histories, History, kSpans} from '../src/history.js';

const kHz = 30;

test('however long it is looked at, a plot gets so many numbers, the extremes among them, at the time they had', () => {
  const all = new History(1, Infinity);
  const minute = new History(1, 60);
  const count = 3600 * kHz;
  const wave = (i) => Math.sin(i / 1000);
  const spikes = new Map([[1234, 5], [70000, -7], [count - 900, 6]]); // of one value each
  for (let i = 0; i < count; ++i) {
    for (const history of [all, minute]) history.add(i / kHz, [spikes.get(i) ?? wave(i)]);
    if (i % 977 === 0) assert.ok(all.columns()[0].length <= 2 * (kSpans + 2), `${all.columns()[0].length} numbers`);
  }
  const [times, values] = all.columns();
  assert.ok(times.length > kSpans / 2, 'and not many fewer');
  for (const [i, spike] of spikes) {
    const at = values.indexOf(spike);
    assert.ok(at >= 0, `the spike ${spike} is there`);
    // Within a span: an hour in at least half of them.
    assert.ok(Math.abs(times[at] - i / kHz) <= (2 * 3600) / kSpans, `at ${times[at]} s, was at ${i / kHz} s`);
  }
  assert.equal(times[0], 0);
  assert.equal(times.at(-1), (count - 1) / kHz);
  const [last, lastValues] = minute.columns();
  assert.ok(last[0] > times.at(-1) - 61 && last[0] <= times.at(-1) - 59, 'the last minute alone');
  assert.ok(lastValues.includes(6) && !lastValues.includes(5));
  assert.ok(last.length <= 2 * (kSpans + 3));
});

test('times rise, and lowest and highest of a span stand in the order in which they came', () => {
  const history = new History(2, 60); // spans of 0.2 s
  for (let i = 0; i < 6000; ++i) history.add(i / 100, [i, -i]);
  const [times, up, down] = history.columns();
  for (let i = 1; i < times.length; ++i) {
    assert.ok(times[i] > times[i - 1]);
    assert.ok(up[i] > up[i - 1] && down[i] < down[i - 1]);
  }
});

test('in a short one every value is there', () => {
  const history = new History(1, 5);
  for (let i = 0; i < 4 * kHz; ++i) history.add(i / kHz, [i]);
  const [times, values] = history.columns();
  assert.deepEqual(values, Array.from({length: 4 * kHz}, (_, i) => i));
  assert.deepEqual(times, values.map((i) => i / kHz));
});

test('what was not measured is a gap, also where spans are joined', () => {
  const history = new History(1, 60);
  history.add(0, [NaN]);
  history.add(0.1, [3]);
  history.add(0.15, [Infinity]);
  history.add(1, [NaN]);
  history.add(2, [4]);
  assert.deepEqual(history.columns(), [[0, 0.15, 1, 2], [3, 3, null, 4]]);
});

test('a time that was set back begins anew, the same one again is no other', () => {
  const histories = new Histories(1, [5, Infinity]);
  for (const [time_s, value] of [[1, 1], [2, 2], [2, 9], [0.5, 7], [0.6, 8]]) histories.add(time_s, [value]);
  for (const seconds of [5, Infinity]) assert.deepEqual(histories.columns(seconds), [[0.5, 0.6], [7, 8]]);
});

test('values that are rarer than a plot is long still make a line: the one before it stays', () => {
  const history = new History(1, 5);
  for (const time_s of [0, 8, 16, 24]) history.add(time_s, [time_s]);
  assert.deepEqual(history.columns(), [[16, 24], [16, 24]]);
});
