// SPDX-License-Identifier: Apache-2.0
// Reads the records of an MCAP file (mcap.dev, version 0): in chunks, compressed by zstd or not, or without chunks.

import {decompress} from 'fzstd';

const kMagic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const kRecordHeader = 9; // opcode, length
const kMessageHeader = 22; // channel, sequence, log time, publish time
const kLargestChunk = 1 << 26; // as the program's reader has it
const opcode = {footer: 2, channel: 4, message: 5, chunk: 6, dataEnd: 15};
const decoder = new TextDecoder();

/**
 * The messages of a file, in order, up to the last whole chunk, or outside of chunks the last whole one: {topic, time_s, bytes}.
 * `wanted(topic)`: whether they are kept. `whole` tells whether the file was ended, and no chunk is damaged. Throws if it is no
 * such file.
 */
export function readMcap(buffer, wanted = () => true) {
  const file = new Uint8Array(buffer);
  if (file.length < kMagic.length || kMagic.some((byte, i) => file[i] !== byte)) throw new Error('no MCAP file');
  const found = {topics: new Map(), messages: [], wanted, whole: false};
  let sound = true;
  readRecords(file, kMagic.length, (kind, record) => {
    if (kind === opcode.footer || kind === opcode.dataEnd) {
      found.whole = sound;
      return false;
    }
    if (kind !== opcode.chunk) return see(kind, record, found);
    try {
      const records = recordsOf(record);
      if (!readRecords(records, 0, (inner, part) => see(inner, part, found))) sound = false;
    } catch {
      sound = false; // What stands in the other chunks is as good as before.
    }
    return true;
  });
  return {messages: found.messages, whole: found.whole};
}

/** Gives each record to `receive` until that returns false; whether all bytes were records. */
function readRecords(bytes, from, receive) {
  const view = viewOf(bytes);
  let at = from;
  while (at + kRecordHeader <= bytes.length) {
    const length = Number(view.getBigUint64(at + 1, true));
    const begin = at + kRecordHeader;
    if (begin + length > bytes.length) return false;
    if (!receive(bytes[at], bytes.subarray(begin, begin + length))) return true;
    at = begin + length;
  }
  return at === bytes.length;
}

function see(kind, record, {topics, messages, wanted}) {
  const view = viewOf(record);
  if (kind === opcode.channel) {
    topics.set(view.getUint16(0, true), text(record, 4));
  } else if (kind === opcode.message) {
    if (record.length < kMessageHeader) throw new Error('a message that is too short');
    const topic = topics.get(view.getUint16(0, true));
    if (!wanted(topic)) return true;
    const time_s = Number(view.getBigUint64(6, true)) / 1e9;
    // A copy: the chunk around it is let go.
    messages.push({topic, time_s, bytes: record.slice(kMessageHeader)});
  }
  return true;
}

/** What a chunk's records are. Throws if it is damaged, or compressed in another way. */
function recordsOf(chunk) {
  const view = viewOf(chunk);
  const size = Number(view.getBigUint64(16, true));
  const crc = view.getUint32(24, true);
  const compression = text(chunk, 28);
  const at = 32 + compression.length;
  const stored = chunk.subarray(at + 8, at + 8 + Number(view.getBigUint64(at, true)));
  if (size > kLargestChunk || !['', 'zstd'].includes(compression)) throw new Error('a chunk that cannot be read');
  const records = compression === 'zstd' ? decompress(stored, new Uint8Array(size)) : stored;
  if (records.length !== size || (crc !== 0 && crc32(records) !== crc)) throw new Error('a damaged chunk');
  return records;
}

const kCrcTable = Uint32Array.from({length: 256}, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  return crc;
});

function crc32(bytes) {
  let crc = ~0;
  for (let i = 0; i < bytes.length; ++i) crc = kCrcTable[(crc ^ bytes[i]) & 0xff] ^ (crc >>> 8);
  return ~crc >>> 0;
}

function viewOf(bytes) {
  return new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}

function text(bytes, at) {
  return decoder.decode(bytes.subarray(at + 4, at + 4 + viewOf(bytes).getUint32(at, true)));
}
