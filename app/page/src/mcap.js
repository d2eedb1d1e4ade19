// Reads the records of an MCAP file (mcap.dev, version 0) that has no chunks, as thenar writes them.

const kMagic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const kRecordHeader = 9; // opcode, length
const kMessageHeader = 22; // channel, sequence, log time, publish time
const opcode = {footer: 2, channel: 4, message: 5, chunk: 6, dataEnd: 15};

/**
 * The messages of a file, in order, up to the last whole one: {topic, time_s, bytes}, where bytes are a view of the
 * buffer. `whole` tells whether the file was ended. Throws if it is no such file.
 */
export function readMcap(buffer) {
  const file = new Uint8Array(buffer);
  const view = new DataView(buffer);
  if (file.length < kMagic.length || kMagic.some((byte, i) => file[i] !== byte)) throw new Error('no MCAP file');
  const topics = new Map();
  const messages = [];
  let at = kMagic.length;
  while (at + kRecordHeader <= file.length) {
    const length = Number(view.getBigUint64(at + 1, true));
    const begin = at + kRecordHeader;
    if (begin + length > file.length) break; // cut off here
    const kind = file[at];
    if (kind === opcode.footer || kind === opcode.dataEnd) return {messages, whole: true};
    if (kind === opcode.chunk) throw new Error('an MCAP file with chunks, which this page does not read');
    if (kind === opcode.channel) {
      topics.set(view.getUint16(begin, true), text(file, view, begin + 4));
    } else if (kind === opcode.message) {
      if (length < kMessageHeader) throw new Error(`a broken record at byte ${at}`);
      messages.push({
        topic: topics.get(view.getUint16(begin, true)),
        time_s: Number(view.getBigUint64(begin + 6, true)) / 1e9,
        bytes: file.subarray(begin + kMessageHeader, begin + length),
      });
    }
    at = begin + length;
  }
  return {messages, whole: false};
}

function text(file, view, at) {
  return new TextDecoder().decode(file.subarray(at + 4, at + 4 + view.getUint32(at, true)));
}
