// SPDX-License-Identifier: Apache-2.0
// A connection to the program behind the page without a browser: what asks for states, and what misbehaves.

import {createHash, randomBytes} from 'node:crypto';
import {request} from 'node:http';

import {State, kGeometry, kState, kindOf} from '../src/messages.js';

/** A text frame of a client (RFC 6455): masked, shorter than 126 bytes. */
export function frameOf(text) {
  const bytes = Buffer.from(text);
  const mask = randomBytes(4);
  return Buffer.concat([Buffer.from([0x81, 0x80 | bytes.length]), mask, bytes.map((byte, i) => byte ^ mask[i % 4])]);
}

/** The first whole frame of a server in `bytes`: {opcode, payload, size}. */
function firstFrame(bytes) {
  if (bytes.length < 2) return null;
  let size = bytes[1];
  let at = 2;
  if (size === 126 && bytes.length >= 4) [size, at] = [bytes.readUInt16BE(2), 4];
  else if (size === 127 && bytes.length >= 10) [size, at] = [Number(bytes.readBigUInt64BE(2)), 10];
  else if (size >= 126) return null;
  if (bytes.length < at + size) return null;
  return {opcode: bytes[0] & 15, payload: bytes.subarray(at, at + size), size: at + size};
}

/** A WebSocket that gives each frame to `receive(opcode, payload, socket)`. */
export function connect(url, receive) {
  return new Promise((resolve, reject) => {
    const key = randomBytes(16).toString('base64');
    const live = new URL(url);
    live.pathname = '/live'; // The token stays.
    const upgrade = request(live, {
      headers: {Connection: 'Upgrade', Upgrade: 'websocket', Origin: new URL(url).origin, 'Sec-WebSocket-Version': '13',
                'Sec-WebSocket-Key': key},
    });
    upgrade.on('error', reject);
    upgrade.on('response', (response) => reject(new Error(`refused: ${response.statusCode}`)));
    upgrade.on('upgrade', (response, socket, head) => {
      const accepted = createHash('sha1').update(`${key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest('base64');
      if (response.headers['sec-websocket-accept'] !== accepted) return reject(new Error('not accepted'));
      let bytes = Buffer.alloc(0);
      const take = (more) => {
        bytes = Buffer.concat([bytes, more]);
        for (let frame = firstFrame(bytes); frame; frame = firstFrame(bytes)) {
          receive(frame.opcode, new Uint8Array(frame.payload), socket);
          bytes = bytes.subarray(frame.size);
        }
      };
      socket.on('data', take);
      socket.on('error', () => {});
      resolve(socket);
      take(head);
    });
    upgrade.end();
  });
}

export const kNext = '{"type":"next"}';

/** One state, by a connection of its own: the figures in it are of the second before. `first` is said `ahead_ms` before it. */
export function look(url, first = '', ahead_ms = 0) {
  return new Promise((resolve, reject) => {
    let state = null;
    connect(url, (opcode, payload, socket) => {
      if (opcode === 1) {
        const message = JSON.parse(Buffer.from(payload).toString());
        if (message.type === 'scene') state = new State(message);
      } else if (opcode === 2 && kindOf(payload) === kGeometry) {
        if (first) socket.write(frameOf(first));
        setTimeout(() => socket.write(frameOf(kNext)), ahead_ms);
      } else if (opcode === 2 && kindOf(payload) === kState) {
        state.take(payload);
        socket.destroy();
        resolve(state.values);
      }
    }).catch(reject);
  });
}

/** Nine pages that ask for all they get, one that stops reading, and one that talks rubbish and hangs up in mid-message. */
export async function crowd(url) {
  const sockets = [];
  let open = true;
  for (let i = 0; i < 9; ++i) {
    sockets.push(await connect(url, (opcode, payload, socket) => {
      if (opcode === 2) setTimeout(() => open && socket.write(frameOf(kNext)), 25);
    }));
  }
  const deaf = await connect(url, () => {});
  deaf.pause();
  const shout = setInterval(() => deaf.write(frameOf(kNext)), 20);
  const rude = setInterval(async () => {
    const socket = await connect(url, () => {}).catch(() => null);
    socket?.write(frameOf('{"type":"set","friction":1e999}'));
    socket?.write(randomBytes(200), () => socket.destroy());
  }, 200);
  return () => {
    open = false;
    clearInterval(shout);
    clearInterval(rude);
    for (const socket of [...sockets, deaf]) socket.destroy();
  };
}
