// SPDX-License-Identifier: Apache-2.0
// Recordings as other programs read them: by the format's own reader, and every message against its schema.
//     node recordings.mjs THENAR CONFIGS

import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtemp, readFile, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import published from '@foxglove/schemas/jsonschema.js';
import {McapIndexedReader, McapStreamReader} from '@mcap/core';
import Ajv from 'ajv';
import {decompress} from 'fzstd';

import {readMcap} from '../src/mcap.js';
import {openRecording} from '../src/recording.js';

const [program, configs] = process.argv.slice(2);
const decompressHandlers = {zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size)))};
const text = new TextDecoder();

let folder = null;
const recorded = {}; // by the run's name

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'thenar-recordings-'));
  // Deformable pulps, joint stops and muscles; rigid fingertips without control; two threads; each with all that is recorded.
  const runs = {
    box: ['box_grasp.yaml', '--time', '1.5 s'],
    minimal: ['minimal.yaml', '--time', '0.3 s'],
    threads: ['box_grasp.yaml', '--time', '0.5 s', '--realtime', '--no-realtime'],
    fast: ['box_grasp.yaml', '--time', '0.2 s', '--record-rate', '1000', '--record-fields', 'q_rad,force_N,contacts'],
  };
  for (const [name, [config, ...args]] of Object.entries(runs)) {
    const file = join(folder, `${name}.mcap`);
    execFileSync(program, ['run', join(configs, config), '--quiet', ...args, '--record', file, '--record-contacts'],
                 {stdio: ['ignore', 'ignore', 'inherit']});
    recorded[name] = await readFile(file);
  }
});
after(() => rm(folder, {recursive: true, force: true}));

const own = (buffer) => new Uint8Array(buffer).buffer;

async function indexed(bytes) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  return McapIndexedReader.Initialize({readable, decompressHandlers});
}

/** All messages: {topic, time_s, bytes, encoding, schema}. */
async function messagesOf(reader) {
  const messages = [];
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    messages.push({topic: channel.topic, time_s: Number(message.logTime) / 1e9, bytes: message.data,
                   encoding: channel.messageEncoding, schema: reader.schemasById.get(channel.schemaId)});
  }
  return messages;
}

const count = (messages, key) => {
  const counts = new Map();
  for (const message of messages) counts.set(key(message), (counts.get(key(message)) ?? 0) + 1);
  return counts;
};

test('a recording has an index, by which every message of every topic is found', async () => {
  for (const [name, bytes] of Object.entries(recorded)) {
    const reader = await indexed(bytes);
    const messages = await messagesOf(reader);
    assert.ok(reader.chunkIndexes.length > 0 && reader.statistics, name);
    assert.equal(Number(reader.statistics.messageCount), messages.length, name);
    assert.equal(reader.statistics.chunkCount, reader.chunkIndexes.length);
    const counts = count(messages, ({topic}) => topic);
    for (const {id, topic} of reader.channelsById.values()) {
      assert.equal(Number(reader.statistics.channelMessageCounts.get(id)), counts.get(topic) ?? 0, `${name}: ${topic}`);
      assert.ok(counts.get(topic) > 0, `${name}: nothing on ${topic}`);
    }
    assert.deepEqual([...reader.summaryOffsetsByOpcode.keys()].sort((a, b) => a - b), [3, 4, 8, 11]);
  }
});

test('all checksums are right, and a chunk is as long as it may be', () => {
  for (const bytes of Object.values(recorded)) {
    const reader = new McapStreamReader({decompressHandlers, includeChunks: true, validateCrcs: true});
    reader.append(new Uint8Array(bytes));
    let largest = 0;
    for (let record; (record = reader.nextRecord());) {
      if (record.type === 'Message') largest = Math.max(largest, record.data.length);
      if (record.type !== 'Chunk') continue;
      // Up to 1 MiB, and the message that goes beyond it, which is 2 MB of JSON at most.
      assert.ok(record.uncompressedSize <= BigInt((1 << 20) + 3e6), `${record.uncompressedSize} bytes`);
      assert.ok(record.messageEndTime - record.messageStartTime <= 1_100_000_000n);
    }
    assert.ok(reader.done());
  }
});

test('the page reads what the format\'s own reader reads', async () => {
  for (const [name, bytes] of Object.entries(recorded)) {
    const expected = await messagesOf(await indexed(bytes));
    const found = readMcap(own(bytes));
    assert.ok(found.whole, name);
    // That reader gives them by time, the page's as they were written.
    const key = ({topic, time_s, bytes: data}) => `${topic} ${time_s} ${data.length} ${data[10]} ${data.at(-1)}`;
    assert.deepEqual(count(found.messages, key), count(expected, key), name);
  }
});

/** What viewers make types of: a type for each member, lists of one kind that are no lists of lists. */
function checkAcceptable(schema, at) {
  assert.equal(schema.type, 'object', at);
  assert.equal(typeof schema.properties, 'object', at);
  for (const [name, member] of Object.entries(schema.properties)) {
    const here = `${at}.${name}`;
    if (member.oneOf) {
      assert.ok(member.oneOf.every((one) => typeof one.const === 'number'), here);
      continue;
    }
    assert.ok(['boolean', 'string', 'number', 'integer', 'object', 'array'].includes(member.type), here);
    if (member.type === 'object') checkAcceptable(member, here);
    if (member.type !== 'array') continue;
    assert.ok(['boolean', 'string', 'number', 'integer', 'object'].includes(member.items.type), here);
    if (member.items.type === 'object') checkAcceptable(member.items, here);
  }
}

/** A schema without its words. */
function bare(schema) {
  if (Array.isArray(schema)) return schema.map(bare);
  if (typeof schema !== 'object' || schema === null) return schema;
  // Properties may have these names, too, and then hold schemas.
  return Object.fromEntries(Object.entries(schema).filter(([key, value]) =>
    !(['description', '$comment'].includes(key) && typeof value === 'string')).map(([key, value]) => [key, bare(value)]));
}

const publishedSchema = (name) => published[name.replace('foxglove.', '')];

test('the schemas of others are as they are published', async () => {
  const reader = await indexed(recorded.box);
  const theirs = [...reader.schemasById.values()].filter(({name}) => name.startsWith('foxglove.'));
  assert.deepEqual([...new Set(theirs.map(({name}) => name))].sort(),
                   ['foxglove.FrameTransforms', 'foxglove.Log', 'foxglove.SceneUpdate']);
  for (const {name, data} of theirs) {
    assert.deepEqual(bare(JSON.parse(text.decode(data))), bare(publishedSchema(name)), name);
  }
});

test('every message in JSON is valid, and says nothing of what is not known', async () => {
  const ajv = new Ajv({strict: true, strictRequired: false, allErrors: true});
  const validators = new Map();
  for (const [run, bytes] of Object.entries(recorded)) {
    for (const {topic, bytes: data, encoding, schema} of await messagesOf(await indexed(bytes))) {
      if (encoding !== 'json') continue;
      assert.equal(schema.encoding, 'jsonschema');
      const source = text.decode(schema.data);
      if (!validators.has(source)) {
        const parsed = JSON.parse(source);
        checkAcceptable(parsed, schema.name);
        assert.ok(Object.keys(parsed.properties).length > 0, schema.name);
        const all = [ajv.compile(parsed)];
        if (schema.name.startsWith('foxglove.')) all.push(ajv.compile(publishedSchema(schema.name)));
        validators.set(source, all);
      }
      const message = JSON.parse(text.decode(data), (key, value) => {
        assert.notEqual(value, null, `${run}: ${topic}: ${key} is null`);
        return value;
      });
      for (const validate of validators.get(source)) {
        assert.ok(validate(message), `${run}: ${topic}: ${JSON.stringify(validate.errors)}`);
      }
    }
  }
});

test('frames, entities and the log fit together', async () => {
  const messages = await messagesOf(await indexed(recorded.box));
  const of = (wanted) => messages.filter(({topic}) => topic === wanted).map(({bytes}) => JSON.parse(text.decode(bytes)));
  const frames = new Set(['world']);
  for (const {transforms} of of('/tf')) {
    for (const {parent_frame_id, child_frame_id, rotation: {x, y, z, w}} of transforms) {
      assert.ok(frames.has(parent_frame_id), parent_frame_id);
      frames.add(child_frame_id);
      assert.ok(Math.abs(Math.hypot(x, y, z, w) - 1) < 1e-6); // numbers are rounded to 1e-7
    }
  }
  for (const topic of ['/hand', '/object', '/forces', '/pressures']) {
    for (const {entities} of of(topic)) {
      for (const {frame_id} of entities) assert.ok(frames.has(frame_id), `${topic}: ${frame_id}`);
    }
  }
  // What lies still in its frame is said once.
  assert.equal(of('/hand').length, 1);
  assert.equal(of('/object').length, 1);
  const last = of('/forces').at(-1);
  assert.ok(last.entities.find(({id}) => id === 'contacts').arrows.length >= 10);
  assert.equal(last.entities.find(({id}) => id === 'fingers').arrows.length, 3);
  assert.ok(of('/pressures').at(-1).entities.some(({cylinders}) => cylinders.length > 3));
  assert.match(of('/log').at(-1).message, /^the grasp is /);
});

test('a recording that is cut off has all its whole chunks', async () => {
  const bytes = recorded.box;
  const {chunkIndexes} = await indexed(bytes);
  const ends = chunkIndexes.map(({chunkStartOffset, chunkLength}) => Number(chunkStartOffset + chunkLength)).sort((a, b) => a - b);
  const whole = readMcap(own(bytes)).messages.length;
  const found = ends.map((end) => readMcap(own(bytes.subarray(0, end))).messages.length);
  assert.equal(found.at(-1), whole);
  for (let i = 1; i < ends.length; ++i) {
    assert.ok(found[i] > found[i - 1]);
    for (const cut of [ends[i] - 1, ends[i - 1] + 1]) {
      const part = readMcap(own(bytes.subarray(0, cut)));
      assert.equal(part.messages.length, found[i - 1]);
      assert.equal(part.whole, false);
    }
  }
});

test('a damaged chunk is passed over', async () => {
  const bytes = Buffer.from(recorded.box);
  const {chunkIndexes} = await indexed(bytes);
  const {chunkStartOffset, chunkLength} = chunkIndexes[1];
  bytes[Number(chunkStartOffset + chunkLength / 2n)] ^= 0xff;
  const {messages, whole} = readMcap(own(bytes));
  assert.equal(whole, false);
  assert.ok(messages.length > 0 && messages.length < readMcap(own(recorded.box)).messages.length);
});

test('a recording of some fields says that there is no picture of it', () => {
  assert.throws(() => openRecording(own(recorded.fast)), /without object/);
});
