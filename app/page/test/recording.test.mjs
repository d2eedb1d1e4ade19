// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {McapStreamReader} from '@mcap/core';

import {readMcap} from '../src/mcap.js';
import {fromBase64, openRecording} from '../src/recording.js';
import {recording} from './synthetic.mjs';

/** A copy of a Buffer's bytes in memory of their own. */
const own = (buffer) => new Uint8Array(buffer).buffer;

test('the messages are those that the format\'s own reader finds', () => {
  const {bytes} = recording(20);
  const reader = new McapStreamReader();
  reader.append(new Uint8Array(bytes));
  const topics = new Map();
  const expected = [];
  for (let record; (record = reader.nextRecord());) {
    if (record.type === 'Channel') topics.set(record.id, record.topic);
    if (record.type === 'Message') {
      expected.push({topic: topics.get(record.channelId), time_s: Number(record.logTime) / 1e9, bytes: record.data.slice()});
    }
  }
  const found = readMcap(own(bytes));
  assert.ok(found.whole);
  assert.equal(expected.length, 23);
  assert.deepEqual(found.messages.map((m) => ({...m, bytes: m.bytes.slice()})), expected);
});

test('a file that was cut off, at any byte of its last records, has its whole messages', () => {
  const {bytes, ends} = recording(3);
  for (let size = ends.at(-3); size < bytes.length - 37; ++size) { // before the footer's record is whole
    const found = readMcap(own(bytes.subarray(0, size)));
    const length = ends.filter((end) => end <= size).length;
    assert.equal(found.messages.length, length, `${size} bytes`);
    if (size < ends.at(-1)) assert.equal(found.whole, false);
  }
});

test('what is no such file is refused with a reason', () => {
  assert.throws(() => readMcap(new ArrayBuffer(0)), /no MCAP/);
  assert.throws(() => readMcap(own(Buffer.from('something else, and long enough'))), /no MCAP/);
  assert.throws(() => openRecording(own(recording(0).bytes)), /no states/);
});

test('every frame has the scene, geometry and status that hold then, at a time that never falls', () => {
  const {frames, duration_s, whole} = openRecording(own(recording(31).bytes));
  assert.ok(whole);
  assert.equal(frames.length, 31);
  assert.ok(Math.abs(duration_s - 1) < 31e-9); // a rounded nanosecond a frame
  for (const [i, frame] of frames.entries()) {
    assert.equal(frame.scene.name, 'made-up grasp');
    assert.equal(frame.status.settings.friction, 0.8);
    assert.ok(i === 0 || frame.at_s >= frames[i - 1].at_s);
  }
});

test('what is said behind the last state is said of it, and of no other', () => {
  const {frames} = openRecording(own(recording(3, {type: 'status', outcome: 'slipping', reason: 'it slipped'}).bytes));
  assert.deepEqual(frames.map(({status}) => status.outcome), ['held', 'held', 'slipping']);
});

test('base64 gives the bytes back, also where the browser has no reader of its own', () => {
  const {bytes} = recording(1);
  const builtIn = Uint8Array.fromBase64;
  Uint8Array.fromBase64 = undefined;
  assert.deepEqual(Buffer.from(fromBase64(`\n${bytes.toString('base64')}\n`)), bytes);
  Uint8Array.fromBase64 = builtIn;
});
