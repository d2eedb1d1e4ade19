// SPDX-License-Identifier: Apache-2.0
// The window as someone who uses it meets it: a real browser before a real simulation.
//     node live.mjs THENAR-WINDOW CONFIGS [FOLDER FOR SCREENSHOTS]

import assert from 'node:assert/strict';
import {copyFile, mkdtemp, readFile, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, beforeEach, test} from 'node:test';

import {openRecording} from '../src/recording.js';
import {findChromium, openBrowser} from './browser.mjs';
import {startProgram} from './program.mjs';

const [program, configs, shots] = process.argv.slice(2);

findChromium();

// Without its integrals the controller is a spring: p times the displacement is what it pulls back with.
const kSprings = ['--set', 'control.position.i=0 N/(m*s)', '--set', 'control.rotation.i=0 N*m/(rad*s)'];
// Fewer points than the scene has: the surface is soon there, and grasps are soon found.
const kCoarse = ['--set', 'object.points=6000'];
// A search gives way to all others: on a busy machine it has a twentieth of a core, or less, and needs some seconds.
const kSearch_ms = 600_000;

let folder = null; // of recordings
let server = null;
let browser = null;
let page = null;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'thenar-live-'));
  server = await startProgram(program, [join(configs, 'box_grasp.yaml'), '--port', '0', '--record-folder', folder, ...kSprings, ...kCoarse]);
  browser = await openBrowser();
  page = browser.page;
  await open(page, server.url);
});

after(async () => {
  await browser?.close();
  await server?.stop();
  await rm(folder, {recursive: true, force: true});
});

/** Shows an address, and waits until the page is connected and has drawn a state and its panels. */
async function open(shown, url) {
  await shown.goto(url);
  await shown.waitForFunction(() => window.thenar?.connected && window.thenar.drawn > 0 && window.thenar.plots > 0);
}

/** A field of the state that is shown, as an array. */
const field = (name) => page.evaluate((key) => Array.from(window.thenar.state[key]), name);
const number = async (name) => (await field(name))[0];
/** What the page has said of what happened, the newest first. */
const events = (shown = page) => shown.evaluate(() => window.thenar.events);
const until = (condition, argument) => page.waitForFunction(condition, argument);
const untilTime = (time_s) => until((t) => window.thenar.state.time_s[0] > t, time_s);
const shoot = async (name) => shots && page.screenshot({path: join(shots, `${name}.png`)});

const minus = (a, b) => a.map((x, i) => x - b[i]);
const norm = (a) => Math.hypot(...a);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** Within 5 %: of this the steady force error is 0.3 %, the rest is that the grasp creeps to rest. */
const expectNear = (value, expected, what) =>
  assert.ok(Math.abs(value / expected - 1) < 0.05, `${what}: ${value}, expected ${expected}`);

/** The angle between two poses: rotations by rows from the fourth number on. */
function angleBetween(a, b) {
  let trace = 0;
  for (let i = 3; i < 12; ++i) trace += a[i] * b[i];
  return Math.acos(Math.min(1, (trace - 1) / 2));
}

/**
 * Waits until the object has stayed where it is, within 10 um, for 0.3 s of simulated time, pulled or not; and gives fields of
 * the state in which it has. Where other work keeps the page from repeating its pull the spring lets go for a moment: then
 * the object moves, and it is waited for again.
 */
async function atRest(names, pulled = false) {
  await page.evaluate(() => delete window.stood);
  const found = await until(([keys, wanted]) => {
    const {object: [...pose], time_s: [now_s], pull_force_N: [force_N]} = window.thenar.state;
    const {place, since_s} = window.stood ?? {};
    const away_m = Math.hypot(...[0, 1, 2].map((i) => pose[i] - place?.[i]));
    if (!(away_m < 1e-5 && now_s >= since_s && Number.isFinite(force_N) === wanted)) window.stood = {place: pose, since_s: now_s};
    return now_s > window.stood.since_s + 0.3 && Object.fromEntries(keys.map((key) => [key, Array.from(window.thenar.state[key])]));
  }, [names, pulled]);
  return found.jsonValue();
}

async function setSlider(name, value) {
  if (!(await page.locator('#settings').isVisible())) await page.keyboard.press('s');
  const slider = page.locator(`#settings [name=${name}]`);
  const index = JSON.parse(await slider.getAttribute('data-values')).indexOf(value);
  assert.ok(index >= 0, `${name} can be ${value}`);
  await slider.fill(String(index));
}

/** Presses the key of a speed, and waits until it is kept. */
async function setSpeed(key, speed) {
  await page.keyboard.press(key);
  await until((x) => window.thenar.status.speed === x, speed);
}

const untilPaused = () => until(() => window.thenar.status.paused && !window.thenar.status.running);

/** What is shown may still be of shortly before. */
async function pause() {
  await page.locator('#pause').click();
  await untilPaused();
}

async function goOn() {
  await page.locator('#pause').click();
  await until(() => !window.thenar.status.paused);
}

/** In a pause: goes back to the start, which is shown however slow the page is. */
async function rewind() {
  await page.keyboard.press('r');
  await until(() => window.thenar.state.time_s[0] === 0);
}

async function restart() {
  await pause();
  await rewind();
  await goOn();
}

// What one test leaves paused or slow is no other's failure.
beforeEach(async () => {
  const {paused, speed} = await page.evaluate(() => window.thenar.status);
  if (paused) await goOn();
  if (speed !== 1) await setSpeed('1', 1);
});

test('the page shows the object, contacts and plots', async () => {
  await until(() => window.thenar.drawn > 3 && window.thenar.contacts > 0);
  const first = await page.evaluate(() => ({plots: window.thenar.plots, time_s: window.thenar.state.time_s[0]}));
  await until(({plots, time_s}) => window.thenar.plots > plots + 5 && window.thenar.state.time_s[0] > time_s, first);
  const centre = (await field('object')).slice(0, 3);
  const [x, y] = await page.evaluate((point) => window.thenar.project(point), centre);
  assert.ok(await page.evaluate(([px, py]) => window.thenar.hitObject(px, py), [x, y]), 'the object is where it is drawn');
  assert.equal(await page.locator('#link').textContent(), 'live');
  assert.ok(await page.evaluate(() => window.thenar.picture.object.isMesh && window.thenar.scene.object.triangles > 100),
            'it is a closed surface');
  assert.ok(await page.locator('#panel-stiffness').isHidden(), 'this scene chooses no stiffness');
  assert.equal(await page.locator('#views button', {hasText: 'Stiffness'}).isVisible(), false);
  assert.equal(await page.locator('#views button', {hasText: 'Surroundings'}).isVisible(), false);
  assert.deepEqual(browser.problems, []);
});

test('every part says what it is, and the help what keys do, in the words of the guide', async () => {
  const untold = await page.evaluate(() => [...document.querySelectorAll('[data-tip], #views button')].filter(({title}) => !title).length);
  assert.equal(untold, 0);
  const row = page.locator('#inputs > div', {hasText: 'pokes it away from you'});
  assert.equal(await row.count(), 1);
  assert.equal(await row.getAttribute('class'), 'live');
});

test('pause, step and reset', async () => {
  await untilTime(1.5);
  await setSpeed('4', 0.1); // a slow page, too, shows what is before 1.5 s
  await page.keyboard.press('r');
  await until(() => window.thenar.state.time_s[0] < 1.5);
  await setSpeed('1', 1);
  await page.keyboard.press(' ');
  await untilPaused();
  await rewind();
  const period_s = await page.evaluate(() => window.thenar.scene.control_period_s);
  for (const before_s of [0, period_s]) {
    await page.keyboard.press('.');
    await untilTime(before_s + 1e-6);
    assert.ok(Math.abs((await number('time_s')) - before_s - period_s) < 1e-9, 'one control period');
  }
  await page.locator('#pause').click();
  await untilTime(2 * period_s + 0.1);
  assert.deepEqual(browser.problems, []);
});

test('a drag pulls with the spring, and the controller pulls back', async () => {
  await untilTime(2.0); // the task's move has ended, and what it left has faded
  const scene = await page.evaluate(() => window.thenar.scene);
  const {object: rest} = await atRest(['object']);
  const start = await page.evaluate((centre) => window.thenar.project(centre), rest.slice(0, 3));
  const box = await page.locator('#canvas').boundingBox();
  const grab = await page.evaluate(([x, y]) => window.thenar.hitObject(x, y), start);
  const perPixel_m = await page.evaluate((point) => window.thenar.metresPerPixel(point), grab);
  const pixels = Math.round(0.01 / perPixel_m);

  await page.mouse.move(box.x + start[0], box.y + start[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + start[0] + pixels, box.y + start[1], {steps: 10});
  // The handle follows the mouse, in the plane through the grabbed point.
  await until(([from, way]) => {
    const handle = window.thenar.state.pull_handle_m;
    return Math.abs(Math.hypot(...from.map((x, i) => handle[i] - x)) / way - 1) < 0.05;
  }, [grab, pixels * perPixel_m]);
  const {object, pull_anchor_m: anchor, pull_handle_m: handle, pull_force_N: force} =
      await atRest(['object', 'pull_anchor_m', 'pull_handle_m', 'pull_force_N'], true);
  await shoot('pulled');

  // The spring's law.
  expectNear(norm(force), scene.pull.stiffness_N_per_m * norm(minus(handle, anchor)), 'the force of the spring');
  assert.ok(norm(force) > 0.3 && norm(force) < scene.pull.limit_N, `a pull that tells: ${norm(force)} N`);
  // The controller's: its wrench is that of the spring.
  expectNear(norm(minus(object.slice(0, 3), rest.slice(0, 3))), norm(force) / scene.position_gain_N_per_m, 'displacement');
  const torque = norm(cross(minus(anchor, object.slice(0, 3)), force));
  expectNear(angleBetween(object, rest), torque / scene.rotation_gain_Nm_per_rad, 'rotation');

  await page.mouse.up();
  await until(() => Number.isNaN(window.thenar.state.pull_force_N[0]));
  assert.deepEqual(await events(), [], 'nothing was refused');
  const {object: back, latency_counts: latencies} = await atRest(['object', 'latency_counts']);
  assert.ok(norm(minus(back.slice(0, 3), rest.slice(0, 3))) < 1e-4, 'it comes back');
  assert.ok(latencies.reduce((a, b) => a + b) > 10, 'inputs were timed');
  assert.deepEqual(browser.problems, []);
});

test('a moved target is followed', async () => {
  const {object: before, target: own} = await atRest(['object', 'target']);
  const centre = await page.evaluate((point) => window.thenar.project(point), before.slice(0, 3));
  const box = await page.locator('#canvas').boundingBox();
  await page.keyboard.down('Shift');
  await page.mouse.move(box.x + centre[0], box.y + centre[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + centre[0], box.y + centre[1] - 20, {steps: 5});
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await until((from) => Math.hypot(...from.map((x, i) => window.thenar.state.target[i] - x)) > 1e-3, own.slice(0, 3));
  const {object, target} = await atRest(['object', 'target']);
  const moved_m = norm(minus(target.slice(0, 3), before.slice(0, 3)));
  assert.ok(moved_m > 1e-3, `the target has moved: ${moved_m} m`);
  assert.ok(norm(minus(object.slice(0, 3), target.slice(0, 3))) < 0.05 * moved_m + 1e-4, 'the object has followed');
  assert.notEqual(await page.evaluate(() => window.thenar.status.outcome), 'lost');
  await page.keyboard.press('b');
  await until((home) => Math.hypot(...home.map((x, i) => window.thenar.state.target[i] - x)) < 1e-9, own.slice(0, 3));
});

test('a poke pushes it, and slow motion is slow', async () => {
  const {object: rest} = await atRest(['object']);
  await setSpeed('2', 0.5);
  // Step by step: a page that draws but some pictures a second would miss how it moves.
  await pause();
  const away = async () => norm(minus((await field('object')).slice(0, 3), rest.slice(0, 3)));
  let pushed_m = 0;
  // 5 N for 30 ms against the damping and the controller: some tenths of a millimetre, and back.
  await page.keyboard.press('Shift+ArrowRight');
  for (let i = 0; i < 20 && pushed_m < 1e-4; ++i) {
    const before_s = await number('time_s');
    await page.keyboard.press('.');
    await untilTime(before_s + 1e-6);
    pushed_m = Math.max(pushed_m, await away());
  }
  assert.deepEqual(await events(), [], 'nothing was refused');
  assert.ok(pushed_m > 1e-4, `it was pushed by ${pushed_m} m`);
  await goOn();
  // Without the integrals what slips at the pulps' rims stays: less than a millimetre.
  assert.ok(norm(minus((await atRest(['object'])).object.slice(0, 3), rest.slice(0, 3))) < 1e-3, 'it comes back');
  assert.notEqual(await page.evaluate(() => window.thenar.status.outcome), 'lost');
  await setSpeed('1', 1);
  assert.deepEqual(browser.problems, []);
});

test('settings change the simulation, and what cannot be is refused', async () => {
  await setSlider('max_sweeps', 3);
  await until(() => window.thenar.status.settings.max_sweeps === 3);
  await setSlider('level', 2);
  await until(() => window.thenar.scene.fingers[0].controls < 320 && window.thenar.contacts > 0);
  await setSlider('level', 0);
  await until(() => window.thenar.scene.fingers[0].controls === 320);
  const own = await page.evaluate(() => window.thenar.scene.settings.find(({name}) => name === 'max_sweeps').default);
  await page.locator('#settings label:has([name=max_sweeps]) .back').click();
  await until((sweeps) => window.thenar.status.settings.max_sweeps === sweeps, own);
  // A contact loop slower than the control loop.
  await setSlider('contact_Hz', 200);
  await until(() => /^Refused: /.test(document.getElementById('say').textContent));
  await setSlider('contact_Hz', 4000);
  await until(() => window.thenar.status.settings.contact_Hz === 4000);
  assert.deepEqual(browser.problems, []);
});

test('every setting of the table has a control with its range and what it is', async () => {
  if (!(await page.locator('#settings').isVisible())) await page.keyboard.press('s');
  const settings = await page.evaluate(() => window.thenar.scene.settings);
  assert.deepEqual(settings.map(({name}) => name).sort(), Object.keys(await page.evaluate(() => window.thenar.status.settings)).sort());
  for (const {name, what, key, type, least, most, choices} of settings) {
    const control = page.locator(`#settings [name=${name}]`);
    const label = await page.locator(`#settings label:has([name=${name}])`).getAttribute('title');
    assert.ok(label.includes(what) && label.includes(key), label);
    if (type === 'choice') {
      assert.deepEqual(await control.locator('option').allTextContents(), choices);
    } else {
      const values = JSON.parse(await control.getAttribute('data-values'));
      assert.deepEqual([values[0], values.at(-1)], [least, most]);
    }
  }
  await shoot('settings');
  await page.keyboard.press('s');
});

test('a picture and a film of the view are saved, with the labels', async () => {
  const saving = page.waitForEvent('download');
  await page.locator('#shoot').click();
  const picture = await saving;
  assert.match(picture.suggestedFilename(), /^box_grasp_[\d.]+_s\.png$/);
  const png = await readFile(await picture.path());
  if (shots) await copyFile(await picture.path(), join(shots, 'saved.png'));
  assert.equal(png.subarray(1, 4).toString(), 'PNG');
  // As large as the canvas; the labels' background is nowhere in the picture without them.
  const size = await page.evaluate(() => [window.thenar.picture.canvas.width, window.thenar.picture.canvas.height]);
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], size);
  const seen = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const place = window.thenar.picture.canvas.getBoundingClientRect();
    return [...document.querySelectorAll('#labels .label:not([hidden])')].map((label) => {
      const box = label.getBoundingClientRect();
      const {data} = context.getImageData(box.left - place.left, box.top - place.top, 4, box.height);
      const middle = 4 * (4 * Math.floor(box.height / 2) + 1); // the edge, in the finger's colour
      return [getComputedStyle(label).borderLeftColor, `rgb(${data[middle]}, ${data[middle + 1]}, ${data[middle + 2]})`];
    });
  }, png.toString('base64'));
  assert.ok(seen.length >= 3);
  assert.ok(seen.some(([color, drawn]) => color === drawn), JSON.stringify(seen)); // one may move meanwhile

  await page.locator('#film').click();
  assert.equal(await page.locator('#film').getAttribute('aria-pressed'), 'true');
  const drawn = await page.evaluate(() => window.thenar.drawn);
  await until((before) => window.thenar.drawn > before + 3, drawn);
  const filming = page.waitForEvent('download');
  await page.locator('#film').click();
  const film = await filming;
  assert.match(film.suggestedFilename(), /\.webm$/);
  const webm = await readFile(await film.path());
  assert.deepEqual([...webm.subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3], 'EBML');
  assert.equal(await page.locator('#film').getAttribute('aria-pressed'), 'false');
  // It plays, and is as large as the view.
  const player = await page.context().newPage(); // the page itself may load no films
  const played = await player.evaluate(async (base64) => {
    const video = document.createElement('video');
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    return new Promise((resolve) => {
      video.onloadedmetadata = () => resolve([video.videoWidth, video.videoHeight]);
      video.onerror = () => resolve([video.error.message]);
      video.src = URL.createObjectURL(new Blob([bytes], {type: 'video/webm'}));
    });
  }, webm.toString('base64'));
  await player.close();
  assert.deepEqual(played, size);
  assert.deepEqual(browser.problems, []);
});

test('the pointer over a plot tells the time and each curve\'s value and unit', async () => {
  const plot = page.locator('#forces .chart').first();
  const box = await plot.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.locator('#reading').waitFor();
  const reading = await page.locator('#reading').evaluate((table) => ({
    time_s: parseFloat(table.caption.textContent), rows: [...table.rows].map((row) => [...row.cells].map((cell) => cell.textContent)),
  }));
  assert.deepEqual(reading.rows.map(([, name]) => name), ['normal, desired', 'tangential, desired', 'normal', 'tangential']);
  assert.ok(reading.rows.every(([, , value]) => /^[\d.]+ N$/.test(value)), JSON.stringify(reading.rows));
  const now_s = await number('time_s');
  assert.ok(reading.time_s > now_s - 30 && reading.time_s <= now_s, `${reading.time_s} s at ${now_s} s`);
  assert.ok(await page.evaluate(() => [...document.querySelectorAll('#grasp .u-cursor-x')].every((line) => line.style.transform)),
            'a line in all plots');
  await shoot('reading');
  await page.mouse.move(box.x - 200, box.y);
  await page.locator('#reading').waitFor({state: 'hidden'});
});

test('a recording is begun and ended in the page, and has the states between', async () => {
  const record = page.locator('#record');
  const recording = () => page.evaluate(() => window.thenar.status.recording);
  const toggle = async (running) => {
    await record.click();
    await until((x) => window.thenar.status.recording?.running === x, running);
  };
  await setSpeed('3', 0.2); // a busy machine, too, has the time to write every state
  const before_s = await number('time_s');
  await toggle(true);
  const {file, begun_s} = await recording();
  assert.equal(dirname(file), folder);
  assert.equal(await record.getAttribute('aria-pressed'), 'true');
  assert.equal((await events())[0], `recording into ${file}`);
  await untilTime(begun_s + 0.5);
  const seen_s = await number('time_s');
  await toggle(false);
  assert.equal((await recording()).note, null, 'nothing is missing in it');
  assert.equal((await events())[0], `recorded into ${file}`);
  assert.equal(await record.getAttribute('aria-pressed'), 'false');
  const ended_s = await number('time_s');
  await untilTime(ended_s + 0.2);

  const bytes = await readFile(file);
  const {frames, whole} = openRecording(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  assert.ok(whole);
  const {begin} = frames[0].scene.fields.find(({name}) => name === 'time_s');
  const times_s = frames.map((frame) => new DataView(frame.bytes.buffer, frame.bytes.byteOffset).getFloat64(8 + 8 * begin, true));
  const kPeriod_s = 0.02 + 1e-9;
  assert.ok(begun_s >= before_s && times_s[0] >= begun_s && times_s[0] <= begun_s + kPeriod_s, `${times_s[0]} s, begun at ${begun_s} s`);
  assert.ok(times_s.every((t, i) => i === 0 || (t >= times_s[i - 1] && t <= times_s[i - 1] + kPeriod_s)), 'a state each 20 ms');
  assert.ok(times_s.at(-1) >= seen_s - kPeriod_s && times_s.at(-1) <= ended_s + 0.1, `${times_s.at(-1)} s after ${seen_s} s, and not long after ${ended_s} s`);
  assert.equal(frames.at(-1).status.recording, undefined);
  await setSpeed('1', 1);
  assert.deepEqual(browser.problems, []);
});

test('plots look back as far as is asked for', async () => {
  for (const [choice, seconds] of [['20', 20], ['Infinity', Infinity], ['5', 5]]) {
    await page.locator('#span').selectOption(choice);
    const times = await page.evaluate(() => window.thenar.plotted());
    assert.ok(times.at(-1) - times[0] <= seconds + 0.5, `${times.at(-1) - times[0]} s`);
    assert.ok(times.length <= 700);
  }
  await page.keyboard.press('Escape'); // else the choice keeps the keys
});

test('too little friction loses the object, and the page says so', async () => {
  await restart();
  await untilTime(0.3);
  await setSlider('friction', 0.2);
  await until(() => window.thenar.status.settings.friction === 0.2);
  await untilTime((await number('time_s')) + 0.3);
  await shoot('sliding');
  // It goes on falling: soon no grasp forces exist either, which is graver, and a slow page sees that alone.
  await until(() => ['lost', 'solver failed'].includes(window.thenar.status.outcome));
  await until(() => /lost|solver failed/.test(document.getElementById('alert').textContent));
  await shoot('lost');
  await setSlider('friction', 0.8);
  await until(() => window.thenar.status.settings.friction === 0.8);
  await restart();
  await until(() => window.thenar.status.outcome === 'held' && window.thenar.state.time_s[0] > 0.3);
  await until(() => document.getElementById('alert').textContent === ''); // with the next picture
  assert.equal(await page.evaluate(() => window.thenar.status.outcome), 'held');
  assert.deepEqual(browser.problems, []);
});

test('a press wets the object, and another one dries it', async () => {
  if (!(await page.locator('#settings').isVisible())) await page.keyboard.press('s');
  const wet = page.locator('#wet');
  await until(() => document.getElementById('wet').getAttribute('aria-pressed') === 'false');
  await wet.click();
  await until(() => window.thenar.state.friction[0] === 0.15);
  await until(() => document.getElementById('wet').getAttribute('aria-pressed') === 'true');
  assert.equal(await page.evaluate(() => window.thenar.status.settings.friction), 0.15);
  assert.ok(await page.locator('#panel-touch').isHidden() && await page.locator('#cells').isHidden(), 'this scene names no touch');
  await wet.click();
  await until(() => window.thenar.state.friction[0] === 0.8);
  await until(() => document.getElementById('wet').getAttribute('aria-pressed') === 'false');
  await page.keyboard.press('s');
  await restart();
  await until(() => window.thenar.status.outcome === 'held' && window.thenar.state.time_s[0] > 0.3);
  assert.deepEqual(browser.problems, []);
});

test('grasps are found, shown and saved, and the one that is clicked runs', async () => {
  await page.keyboard.press('g');
  const before_s = await number('time_s');
  await page.locator('#grasps .find').click();
  await page.waitForFunction(() => window.thenar.grasps.search === 1 && !window.thenar.grasps.running, null, {timeout: kSearch_ms});
  assert.ok((await number('time_s')) > before_s, 'the grasp goes on meanwhile');
  const found = await page.evaluate(() => window.thenar.grasps.grasps);
  assert.ok(found.length > 0, 'this box can be held');
  const cards = page.locator('#grasps li');
  assert.equal(await cards.count(), found.length);
  assert.match(await cards.first().locator('h3').textContent(), /thumb/);
  const shown = await page.evaluate(() => window.thenar.grasps.measures.map(({shown}) => shown));
  assert.deepEqual(await cards.first().locator('dt').evaluateAll((labels) => labels.map((label) => label.firstChild.data)),
                   [...new Set(shown)], 'each name once');
  // The hand and the object are drawn on the background, in several shades.
  await until(() => [...document.querySelectorAll('#grasps canvas')].every((canvas) => {
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size > 20;
  }));
  await shoot('grasps');
  const saving = page.waitForEvent('download');
  await cards.first().locator('a').click();
  const saved = await readFile(await (await saving).path(), 'utf8');
  assert.equal(saved, found[0].scene);
  assert.equal(await page.evaluate(() => window.thenar.grasps.taken), 0, 'saving runs nothing');

  await cards.first().locator('canvas').click();
  await until(() => window.thenar.grasps.taken === 1 && /, grasp 1$/.test(window.thenar.scene.name));
  await untilTime(0.2);
  assert.equal(await cards.first().getAttribute('aria-current'), 'true');
  assert.notEqual(await page.evaluate(() => window.thenar.status.outcome), 'lost');
  await shoot('grasp-taken');
  await page.locator('#grasps .own').click();
  await until(() => window.thenar.grasps.taken === 0 && !/, grasp/.test(window.thenar.scene.name));
  await page.keyboard.press('g');
  assert.deepEqual(browser.problems, []);
});

test('the page says that it lost the connection, and finds it again', async () => {
  try {
    server.signal('SIGSTOP');
    await until(() => /lost/.test(document.querySelector('#link').textContent));
    await page.keyboard.press('5');
    assert.match((await events())[0], /not connected/);
  } finally {
    server.signal('SIGCONT');
  }
  await until(() => window.thenar.connected);
  const time_s = await page.evaluate(() => window.thenar.state.time_s[0]);
  await until((before_s) => window.thenar.state.time_s[0] > before_s, time_s);
  assert.equal(await page.locator('#link').textContent(), 'live');
  assert.equal(await page.evaluate(() => window.thenar.status.speed), 1, 'what was pressed meanwhile is not done');
  await shoot('running');
});

test('what is pressed before the page is connected is done when it is', async () => {
  const other = await page.context().newPage();
  let connect = null;
  const pressed = new Promise((resolve) => (connect = resolve));
  await other.routeWebSocket(/\/live/, async (route) => {
    await pressed;
    route.connectToServer();
  });
  try {
    await other.goto(server.url);
    await other.keyboard.press('2');
    assert.equal(await other.locator('#link').textContent(), 'connecting');
    connect();
    await other.waitForFunction(() => window.thenar.status?.speed === 0.5);
    assert.deepEqual(await events(other), []);
  } finally {
    await other.close();
  }
});

test('a slider makes the grasp stiffer, by muscles that pull harder', async () => {
  const own = await startProgram(program, [join(configs, 'box_stiff.yaml'), '--port', '0', ...kCoarse,
                                           '--set', 'time.control_period=5 ms']);
  const other = await page.context().newPage();
  try {
    await open(other, own.url);
    const seen = () => other.evaluate(() => ({effort: window.thenar.state.muscles_N.reduce((a, b) => a + b), time_s: window.thenar.state.time_s[0],
      across: Math.hypot(...window.thenar.picture.ellipsoids.kinds[0].solid.matrix.elements.slice(0, 3))}));
    const rest = async (asked) => {
      await other.waitForFunction((x) => window.thenar.state.asked_N_per_m[2] === x && window.thenar.state.stiffness_share[0] === 1, asked);
      const {time_s} = await seen();
      await other.waitForFunction((t) => window.thenar.state.time_s[0] > t + 0.3 && window.thenar.picture.ellipsoids.kinds[0].visible, time_s);
      return seen();
    };
    const slide = async (name, value) => {
      const slider = other.locator(`#stiffness [name="${name}"]`);
      await slider.fill(String(JSON.parse(await slider.getAttribute('data-values')).indexOf(value)));
    };
    await other.keyboard.press('3'); // a fifth of real time
    await other.waitForFunction(() => window.thenar.status.speed === 0.2);
    const before = await rest(150);
    await slide('asked_N_per_m x', 50);
    await slide('asked_Nm_per_rad x', 0.02);
    const soft = await rest(50);
    assert.ok(soft.effort < 0.9 * before.effort && soft.across < before.across, JSON.stringify([before, soft]));
    await other.locator('#alike').uncheck();
    await slide('asked_N_per_m y', 100);
    await other.waitForFunction(() => window.thenar.state.asked_N_per_m.join() === '50,100,50');
    await other.locator('#stiffness-back').click();
    await rest(150);
    await other.keyboard.press('k');
    assert.equal(await other.evaluate(() => window.thenar.picture.ellipsoids.kinds[0].visible), false);
    assert.deepEqual(await events(other), [], 'nothing was refused');
  } finally {
    await other.close();
    await own.stop();
  }
});

test('a box slides on a slope that a slider makes slippery, and its contacts say so', async () => {
  const own = await startProgram(program, [join(configs, 'resting_box.yaml'), '--port', '0']);
  const other = await page.context().newPage();
  try {
    await open(other, own.url);
    const comes = (condition, argument) => other.waitForFunction(condition, argument);
    // Sliding contacts have arrows with two heads: waits until all have so many, and the object is so far; says how far.
    const untilHeads = async (heads, from_m) => (await comes(([count, x]) => {
      const {arrows} = window.thenar.picture.touches;
      return arrows.shafts.count > 0 && arrows.heads.count === count * arrows.shafts.count && window.thenar.state.object[0] > x &&
          {x_m: window.thenar.state.object[0]};
    }, [heads, from_m])).jsonValue();
    await comes(() => window.thenar.state.time_s[0] > 0.3);
    assert.ok(await other.locator('#views button', {hasText: 'Surroundings'}).isVisible());
    const {x_m} = await untilHeads(1, -1);
    await other.keyboard.press('3'); // a fifth of real time
    await comes(() => window.thenar.status.speed === 0.2);
    await other.keyboard.press('s');
    const slider = other.locator('#settings [name=around_friction]');
    await slider.fill(String(JSON.parse(await slider.getAttribute('data-values')).indexOf(0.1)));
    await untilHeads(2, x_m + 1e-3);
    await other.locator('#settings label:has([name=around_friction]) .back').click();
    await comes(() => window.thenar.state.touches_margin[0] > 0.2);
    assert.deepEqual(await events(other), [], 'nothing was refused');
    if (shots) await other.screenshot({path: join(shots, 'slope.png')});
  } finally {
    await other.close();
    await own.stop();
  }
});
