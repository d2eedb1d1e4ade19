// Does the contact loop notice who watches? Its compute time with a page that renders on the same cores over that without,
// in turns in one session.
//     node load.mjs THENAR-WINDOW CONFIGS [PAIRS] [SECONDS]

import {createHash, randomBytes} from 'node:crypto';
import {request} from 'node:http';
import {join} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';

import {State, kGeometry, kState, kindOf} from '../src/messages.js';
import {openBrowser} from './browser.mjs';
import {startProgram} from './program.mjs';

const [program, configs, pairs = '5', seconds = '8'] = process.argv.slice(2);
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** A text frame of a client (RFC 6455): masked, shorter than 126 bytes. */
function frameOf(text) {
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
function connect(url, receive) {
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

const kNext = '{"type":"next"}';

/** One state, by a connection of its own: the figures in it are of the second before. `first` is said `ahead_ms` before it. */
function look(url, first = '', ahead_ms = 0) {
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
async function crowd(url) {
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

/** The median over some seconds of each second's p99 [us], of the contact loop's compute time. */
async function measure(url) {
  await sleep(2000);
  const p99 = [], p50 = [];
  let last = null;
  for (let i = 0; i < Number(seconds); ++i) {
    await sleep(1000);
    last = await look(url);
    p50.push(last.contact_compute_us[0]);
    p99.push(last.contact_compute_us[1]);
  }
  return {p50_us: median(p50), p99_us: median(p99), last};
}

const server = await startProgram(program, [join(configs, 'box_grasp.yaml'), '--port', '0', '--quiet']);
const ratios = [];
const crowdRatios = [];
console.log('contact compute, us: alone p50, p99; with a page; with it and eleven more; fps; ratios of p99 over alone');
for (let pair = 0; pair < Number(pairs); ++pair) {
  const without = await measure(server.url);
  const browser = await openBrowser();
  await browser.page.goto(server.url);
  await browser.page.waitForFunction(() => window.thenar?.drawn > 10, null, {timeout: 60_000});
  const watched = await measure(server.url);
  const leave = await crowd(server.url);
  const crowded = await measure(server.url);
  leave();
  const fps = await browser.page.evaluate(() => window.thenar.fps);
  await browser.close();
  ratios.push(watched.p99_us / without.p99_us);
  crowdRatios.push(crowded.p99_us / without.p99_us);
  const row = [without, watched, crowded].flatMap(({p50_us, p99_us}) => [p50_us, p99_us]).map((us) => us.toFixed(1).padStart(8));
  console.log(`${pair + 1}    ${row.join('')}   ${fps.toFixed(0).padStart(4)}   ${ratios.at(-1).toFixed(2)}   ${crowdRatios.at(-1).toFixed(2)}`);
}
// Frames are counted when the loops rest.
const end = await look(server.url, '{"type":"pause"}', 500);
console.log(`ratio of p99, median of ${pairs} pairs: ${median(ratios).toFixed(2)}, in a crowd ${median(crowdRatios).toFixed(2)}; frames unaccounted ${end.unaccounted[0]}, ` +
            `residual ${end.residual[0].toExponential(1)}, slipped ticks ${end.contact_slipped[0]} of ${end.tick[0]}`);
await server.stop();
if (!(median(ratios) <= 1.2 && end.unaccounted[0] === 0)) {
  console.log('the contact loop noticed: at most 1.2 and 0 were asked for');
  process.exitCode = 1;
}
