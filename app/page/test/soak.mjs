// SPDX-License-Identifier: Apache-2.0
// An hour as a user's worst day: pages come and go, settings change at random, hands pull and poke, other work takes
// both cores half of the time, and everything is recorded. Memory must stay flat, no frame may be lost, the grasp must
// hold.
//     node soak.mjs THENAR-WINDOW CONFIGS FOLDER [SECONDS] [SEED]

import {mkdir, readFile, stat, writeFile} from 'node:fs/promises';
import {availableParallelism} from 'node:os';
import {join} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';
import {Worker} from 'node:worker_threads';

import {openBrowser} from './browser.mjs';
import {connect, crowd, frameOf, kNext, look} from './client.mjs';
import {startProgram} from './program.mjs';

const [program, configs, folder, seconds = '3600', firstSeed = String(Date.now() % 1_000_000)] = process.argv.slice(2);
const kTurn_s = 60; // other work comes and goes by this
const kGrowth_MB = 8; // of what the program holds, from the first tenth of the time to the last: the allocator's own

/** Mulberry32: numbers from 0 to 1 that a seed repeats. */
function numbersFrom(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const random = numbersFrom(Number(firstSeed));
const among = (...values) => values[Math.floor(random() * values.length)];
const within = (low, high) => low + (high - low) * random();
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** What a hand or a slider says; none of it loses the object. */
function anything() {
  return among(
    () => ({type: 'set', friction: within(0.6, 1.2)}),
    () => ({type: 'set', internal_force_N: within(1.5, 2.2)}),
    () => ({type: 'set', tolerance: among(1e-5, 1e-6, 1e-7)}),
    () => ({type: 'set', max_sweeps: among(30, 100, 300)}),
    () => ({type: 'set', control_Hz: among(400, 1000)}),
    () => ({type: 'set', delay_periods: among(0, 1)}),
    () => ({type: 'set', level: among(0, 0, 1, 2)}),
    () => ({type: 'target', shift_m: [0, 0, within(0, 0.004)], turn_rad: [0, 0, 0]}),
    () => ({type: 'poke', force_N: [within(-1, 1), within(-1, 1), within(-1, 1)]}),
    () => ({type: 'step'}),
    () => ({type: 'speed', value: among(0.25, 1)}),
    () => ({type: 'set', contact_Hz: 99}), // refused: slower than the control loop
  )();
}

const kBusy = 'const {workerData} = require("worker_threads"); const flag = new Int32Array(workerData);' +
              'let x = 1; while (!Atomics.load(flag, 0)) for (let i = 0; i < 1e6; ++i) x = Math.sin(x + i);';

/** Work on every core until what is returned is called. */
function busy() {
  const flag = new SharedArrayBuffer(4);
  for (let i = 0; i < availableParallelism(); ++i) new Worker(kBusy, {eval: true, workerData: flag});
  return () => Atomics.store(new Int32Array(flag), 0, 1);
}

/** Memory that the process holds itself [MB]: the recording's pages are the system's. */
async function resident_MB(pid) {
  const text = await readFile(`/proc/${pid}/status`, 'utf8');
  return Number(/^RssAnon:\s+(\d+)/m.exec(text)[1]) / 1024;
}

await mkdir(folder, {recursive: true});
const recording = join(folder, 'soak.mcap');
const server = await startProgram(program, [
  join(configs, 'box_grasp.yaml'), '--port', '0', '--contact-rate', '4kHz', '--record', recording,
]);
console.log(`soak: seed ${firstSeed}, ${seconds} s`);

const samples = [];
const findings = [];
let pages = 0, connections = 0, messages = 0, resets = 0;
let page = null, leave = null, rest = null;
const outcomes = new Map(); // what was said of the grasp, how often

/** A hand of its own: it asks for states, and hears what becomes of the grasp. */
const joinIn = () => connect(server.url, (opcode, payload, from) => {
  if (opcode === 2) setTimeout(() => from.write(frameOf(kNext)), 25);
  const message = opcode === 1 ? JSON.parse(Buffer.from(payload).toString()) : {};
  if (message.type !== 'status') return;
  // What hands do to a grip makes its forces jump, which is called unstable, or asks a muscle for more than it has.
  const said = message.reason ? `${message.outcome}: ${message.reason}` : message.outcome;
  outcomes.set(said, (outcomes.get(said) ?? 0) + 1);
  if (!/held|unstable|over limits/.test(message.outcome)) findings.push(said);
});
let socket = await joinIn();
const start_ms = Date.now();
let looked_ms = start_ms, turned_ms = start_ms;
const elapsed_s = () => (Date.now() - start_ms) / 1000;

const say = (message) => (messages += 1, socket.write(frameOf(JSON.stringify(message))));

while (elapsed_s() < Number(seconds)) {
  await sleep(within(100, 1500));
  say(anything());
  if (random() < 0.02) say({type: 'pause'}), await sleep(within(10, 2000)), say({type: 'resume'});
  if (random() < 0.01) say({type: 'reset'}), (resets += 1);
  if (random() < 0.05) {
    // Another connection takes over.
    socket.destroy();
    socket = await joinIn();
    connections += 1;
  }
  if (Date.now() - turned_ms > kTurn_s * 1000) {
    turned_ms = Date.now();
    rest = rest ? (rest(), null) : busy();
    if (random() < 0.5) leave = leave ? (leave(), null) : await crowd(server.url);
    if (page) {
      if (page.problems.length) findings.push(`the page said: ${page.problems[0]}`);
      await page.close();
      page = null;
    } else if (random() < 0.5) {
      page = await openBrowser();
      pages += 1;
      await page.page.goto(server.url);
    }
  }
  if (Date.now() - looked_ms > 10_000) {
    looked_ms = Date.now();
    const state = await look(server.url);
    const sample = {
      at_s: elapsed_s(), memory_MB: await resident_MB(server.pid), loaded: rest !== null,
      slipped: state.contact_slipped[0], lost_records: state.lost_records[0],
      contact_p50_us: state.contact_compute_us[0], contact_p99_us: state.contact_compute_us[1],
    };
    samples.push(sample);
    const all = [...state.object, ...state.q_rad, ...state.force_N, ...state.displacement_m];
    if (!all.every(Number.isFinite)) findings.push(`at ${sample.at_s} s a state is not finite`);
    if (findings.length) break;
    if (samples.length % 30 === 0) {
      console.log(`  ${sample.at_s.toFixed(0)} s: ${sample.memory_MB.toFixed(1)} MB, compute ${sample.contact_p50_us.toFixed(1)} us`);
    }
  }
}

if (leave) leave();
if (rest) rest();
await page?.close();
say({type: 'resume'});
await sleep(3000);
const end = await look(server.url, '{"type":"pause"}', 1000); // frames are counted when the loops rest
socket.destroy();
const code = await server.stop();

const tenth = Math.max(1, Math.floor(samples.length / 10));
const [first, last] = [samples.slice(0, tenth), samples.slice(-tenth)].map((some) => median(some.map((s) => s.memory_MB)));
if (last - first > kGrowth_MB) findings.push(`memory grew from ${first} to ${last} MB`);
if (end.unaccounted[0] !== 0) findings.push(`${end.unaccounted[0]} frames unaccounted`);
if (code !== 0) findings.push(`exit code ${code}: ${server.log}`);
const of = (loaded) => median(samples.filter((s) => s.loaded === loaded).map((s) => s.contact_p99_us));
const figures = {
  seed: Number(firstSeed), seconds: elapsed_s(), outcomes: Object.fromEntries(outcomes), pages, connections, messages, resets,
  memory_first_MB: first, memory_last_MB: last, memory_most_MB: Math.max(...samples.map((s) => s.memory_MB)),
  recording_MB: (await stat(recording)).size / 1e6, unaccounted: end.unaccounted[0],
  lost_records: Math.max(...samples.map((s) => s.lost_records)), slipped: Math.max(...samples.map((s) => s.slipped)),
  contact_p99_us: of(false), contact_p99_loaded_us: of(true), exit_code: code, findings,
};
await writeFile(join(folder, 'soak.json'), JSON.stringify({...figures, samples}, null, 1));
console.log(JSON.stringify(figures, null, 1));
process.exit(findings.length ? 1 : 0);
