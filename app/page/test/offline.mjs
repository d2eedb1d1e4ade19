// SPDX-License-Identifier: Apache-2.0
// Recordings in a browser: exported, cut off, and served.
//     node offline.mjs THENAR CONFIGS

import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {pathToFileURL} from 'node:url';

import {findChromium, kPatience_ms, openBrowser} from './browser.mjs';
import {startProgram} from './program.mjs';

const [program, configs] = process.argv.slice(2);
findChromium();

let folder = null;
let recorded = null;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'thenar-export-'));
  recorded = join(folder, 'grasp.mcap');
  thenar('run', join(configs, 'box_grasp.yaml'), '--time', '3 s', '--record', recorded);
});
after(() => rm(folder, {recursive: true, force: true}));

const thenar = (...args) => execFileSync(program, args, {cwd: folder, stdio: ['ignore', 'ignore', 'inherit']});

/** Opens an address without a network, and gives the page and what it complained of to `look`. */
async function open(url, look, {offline = true} = {}) {
  const browser = await openBrowser();
  try {
    const {page} = browser;
    await page.context().setOffline(offline);
    await page.goto(url);
    await page.waitForFunction(() => window.thenar?.drawn > 0);
    await page.evaluate(() => window.thenar.replay.pause());
    await look(page, browser);
    assert.deepEqual(browser.problems, []);
  } finally {
    await browser.close();
  }
}

async function exported(recording) {
  const html = join(folder, 'grasp.html');
  thenar('export', recording, '--html', html);
  return pathToFileURL(html).href;
}

const seek = (page, time_s) =>
  page.evaluate((t) => (window.thenar.replay.seek(t), window.thenar.state.time_s[0]), time_s);

/** The object is where its pose says, on the screen; contacts carry force. */
async function expectDrawn(page) {
  const seen = await page.evaluate(() => {
    const {thenar} = window;
    const [x, y] = thenar.project(Array.from(thenar.state.object.subarray(0, 3)));
    return {contacts: thenar.contacts, hit: thenar.hitObject(x, y), x, y};
  });
  assert.ok(seen.contacts > 0);
  assert.ok(seen.hit, 'the object is where it is drawn');
  const canvas = await page.locator('#canvas').boundingBox();
  const clip = {x: canvas.x + seen.x - 4, y: canvas.y + seen.y - 4, width: 8, height: 8};
  // A machine without a graphics card takes its time.
  for (const end_ms = Date.now() + kPatience_ms; ;) {
    const drawn = await page.screenshot({clip});
    const empty = await page.screenshot({clip: {...clip, x: canvas.x + 4, y: canvas.y + 4}});
    if (!drawn.equals(empty)) return;
    assert.ok(Date.now() < end_ms, 'the object is drawn');
  }
}

test('an exported page opens from a file with no network, draws, seeks and plays', async () => {
  await open(await exported(recorded), async (page, browser) => {
    const end_s = await seek(page, await page.evaluate(() => window.thenar.replay.duration));
    await expectDrawn(page);
    const slider = page.locator('#seek');
    await slider.fill('0');
    const start_s = await page.evaluate(() => window.thenar.state.time_s[0]);
    const half_s = (await page.evaluate(() => window.thenar.replay.duration)) / 2;
    await slider.fill(String(half_s));
    const middle_s = await page.evaluate(() => window.thenar.state.time_s[0]);
    assert.ok(Math.abs(middle_s - start_s - half_s) < 0.021, `a state each 20 ms: ${middle_s} s where ${start_s + half_s} s are due`);
    await slider.fill('0');
    await page.locator('#play').click();
    await page.waitForFunction((end) => window.thenar.state.time_s[0] === end, end_s);
    await page.waitForFunction(() => !window.thenar.replay.playing);
    assert.deepEqual(browser.requests.filter((url) => !url.startsWith('file:') && !url.startsWith('data:')), []);
  });
});

test('it draws within a page, as notebooks show it', async () => {
  const html = await readFile(new URL(await exported(recorded)), 'utf8');
  const within = join(folder, 'notebook.html');
  await writeFile(within, `<iframe srcdoc="${html.replaceAll('&', '&amp;').replaceAll('"', '&quot;')}"></iframe>`);
  const {page, problems, close} = await openBrowser();
  try {
    await page.goto(pathToFileURL(within).href);
    await page.frames()[1].waitForFunction(() => window.thenar?.drawn > 0 && window.thenar.contacts > 0);
    assert.deepEqual(problems, []);
  } finally {
    await close();
  }
});

const fingers = (what) => ['thumb', 'index', 'major'].map((finger) => `${finger}_${what}`);

test('it shows the numbers of the table, bit by bit', async () => {
  const csv = join(folder, 'grasp.csv');
  thenar('export', recorded, '--csv', csv);
  const [header, ...rows] = (await readFile(csv, 'utf8')).trim().split('\n').map((line) => line.split(','));
  // The table has a column a number, in the words and units of signals.csv; the state has fields.
  const fields = {margin: [1, ...fingers('margin')], tangential_N: [1, ...fingers('tangential_N')],
    normal_N: [1, ...fingers('normal_N')], slip_m: [1e6, ...fingers('slip_um')],
    object: [1e3, ...['x', 'y', 'z'].map((axis) => `object_pose_${axis}_mm`)]};
  const shown = header.flatMap((name, i) => {
    const [field, [factor, ...names]] = Object.entries(fields).find(([, found]) => found.includes(name)) ?? [name, [1, name]];
    return [{i, field, factor, at: names.indexOf(name)}];
  });
  await open(await exported(recorded), async (page) => {
    for (const row of [rows[0], rows[20], rows.at(-1)]) {
      await seek(page, Number(row[0]) - Number(rows[0][0]));
      const state = await page.evaluate(() =>
        Object.fromEntries(Object.entries(window.thenar.state).map(([name, values]) => [name, Array.from(values, String)])));
      const found = shown.filter(({field}) => field in state);
      assert.ok(found.length >= 40, `${found.length} columns are fields`);
      for (const {i, field, factor, at} of found) {
        // Number has the double that the digits stand for, String the digits that stand for it alone.
        assert.equal(String(factor * Number(state[field][at])), String(Number(row[i])), `${header[i]} at ${row[0]} s`);
      }
    }
  });
});

test('a recording that was cut off plays to the last state of its last whole chunk', async () => {
  const cut = join(folder, 'cut.mcap');
  const bytes = await readFile(recorded);
  await writeFile(cut, bytes.subarray(0, Math.round(0.7 * bytes.length)));
  await open(await exported(cut), async (page) => {
    const duration_s = await page.evaluate(() => window.thenar.replay.duration);
    assert.ok(duration_s > 0.7 && duration_s < 2.2, `${duration_s} s of it`);
    await seek(page, duration_s);
    await expectDrawn(page);
    assert.match(await page.locator('#link').textContent(), /cut off/);
  });
});

test('a served recording plays', async () => {
  const server = await startProgram(join(dirname(program), 'thenar-window'), [recorded, '--port', '0']);
  try {
    await open(server.url, async (page) => {
      await seek(page, 0.5);
      await expectDrawn(page);
    }, {offline: false});
  } finally {
    assert.equal(await server.stop(), 0);
  }
});

test('a recording of fingertips that feel shows their cells, touch and the last reflex', async () => {
  const wet = join(folder, 'wet.mcap');
  thenar('run', join(configs, 'box_wet.yaml'), '--time', '1.2 s', '--record', wet);
  await open(await exported(wet), async (page) => {
    const shown = async (time_s) => {
      await seek(page, time_s);
      return page.evaluate(() => window.thenar.picture.pulps.map(({cells}) => {
        const {state, color} = {state: [], color: cells.cones.instanceColor.array};
        for (let i = 0; i < cells.cones.count; ++i) state.push(color[3 * i] > color[3 * i + 2] ? 'slips' : 'holds');
        return state;
      }));
    };
    for (const states of await shown(0.7)) {
      assert.ok(states.length >= 5 && states.every((state) => state === 'holds'), `before it is wet: ${states}`);
    }
    await page.waitForFunction(() => document.getElementById('touch').rows.length === 4 && !document.getElementById('panel-touch').hidden);
    assert.equal(await page.locator('#last-reflex').textContent(), '–');
    for (const states of await shown(0.84)) {
      assert.ok(states.length >= 5 && states.every((state) => state === 'slips'), `before the hand feels it: ${states}`);
    }
    await seek(page, 1.1);
    await page.waitForFunction(() => /^(thumb|index|major), slip, 0\.8\d s$/.test(document.getElementById('last-reflex').textContent));
    assert.ok(await page.locator('#cells').isVisible());
  });
});

test('fingertips that feel without a controller are shown, too', async () => {
  const drag = join(folder, 'drag.mcap');
  thenar('run', join(configs, 'pulp_drag.yaml'), '--set', 'fingertips.leaves=320', '--time', '0.2 s', '--record', drag);
  await open(await exported(drag), async (page) => {
    await seek(page, 0.15);
    await page.waitForFunction(() => document.getElementById('touch').rows.length === 4);
    assert.equal(await page.locator('#last-reflex').textContent(), '–');
  });
});

test('a recording of a stiffness that is chosen shows its ellipsoid, and what it costs', async () => {
  const stiff = join(folder, 'stiff.mcap');
  thenar('run', join(configs, 'box_stiff.yaml'), '--set', 'object.points=6000', '--time', '0.6 s', '--record', stiff);
  await open(await exported(stiff), async (page) => {
    await seek(page, 0.5);
    await page.waitForFunction(() => document.getElementById('stiffness').rows.length === 7);
    assert.ok(await page.locator('#panel-stiffness').isVisible());
    assert.equal(await page.locator('#stiffness input[type=range]').count(), 0, 'nothing can be asked of a recording');
    const seen = await page.evaluate(() => {
      const {state, picture: {ellipsoids: {kinds: [along, about]}}} = window.thenar;
      const across = [0, 4, 8].map((i) => Math.hypot(...along.solid.matrix.elements.slice(i, i + 3)));
      const least = state.least_muscles_N.reduce((a, b) => a + b);
      return {visible: along.visible, hidden: !about.visible, across, trace: [0, 4, 8].reduce((sum, i) => sum + state.stiffness_N_per_m[i], 0),
              asked: state.asked_N_per_m[0], least, effort: state.muscles_N.reduce((a, b) => a + b)};
    });
    assert.ok(seen.visible && seen.hidden);
    // The sum of the principal stiffnesses is the trace; 30 mm for 1000 N/m.
    const sum = seen.across.reduce((a, b) => a + b);
    assert.ok(Math.abs(sum / (seen.trace * 30e-6) - 1) < 1e-9, JSON.stringify(seen));
    assert.ok(Math.min(...seen.across) >= 0.999 * seen.asked * 30e-6, 'what is asked for is inside of what there is');
    assert.ok(seen.least > 1 && seen.effort > 1.2 * seen.least, JSON.stringify(seen));
    assert.equal(await page.locator('#muscles .track > b').count(), 23);
  });
});

test('a recording of a box on a slope shows what it rests on, and with which force', async () => {
  const rest = join(folder, 'rest.mcap');
  thenar('run', join(configs, 'resting_box.yaml'), '--time', '0.4 s', '--record', rest);
  await open(await exported(rest), async (page) => {
    await seek(page, 0.3);
    const seen = await page.evaluate(() => {
      const {state, scene, picture: {bodies, touches, labels}} = window.thenar;
      const {part} = bodies.bodies[0];
      part.updateWorldMatrix(true, false);
      const {elements} = part.matrixWorld;
      return {shape: scene.bodies[0].shape, visible: bodies.visible, middle: Array.from(elements.slice(12, 15)), pose: Array.from(state.bodies),
              object: Array.from(state.object.slice(0, 3)), arrows: touches.arrows.shafts.count, sums: touches.sums.shafts.count,
              force: Math.hypot(...state.bodies_N), weight: scene.object.mass_kg * 9.80665, label: labels.find(({element}) => element.dataset.name === 'around slope').text};
    });
    assert.ok(seen.visible && seen.shape === 'plane');
    // What is drawn of the slope lies in it, and within half of a grid's square of the place below the object.
    const normal = [5, 8, 11].map((i) => seen.pose[i]);
    const off = seen.middle.map((x, i) => x - seen.pose[i]).reduce((sum, x, i) => sum + x * normal[i], 0);
    assert.ok(Math.abs(off) < 1e-12, `${off} m off the slope`);
    const apart = Math.hypot(...seen.middle.map((x, i) => x - seen.object[i]));
    assert.ok(apart < 0.03 + 0.01 * Math.SQRT2 + 1e-3, `${apart} m from the object's middle, which is 30 mm above`);
    assert.ok(seen.arrows >= 3 && seen.sums === 1, JSON.stringify(seen));
    // It came to rest long ago.
    assert.ok(Math.abs(seen.force / seen.weight - 1) < 1e-3, JSON.stringify(seen));
    assert.equal(seen.label, `slope ${seen.force.toFixed(2)} N`);
    await page.keyboard.press('o');
    assert.equal(await page.evaluate(() => window.thenar.picture.bodies.visible), false);
    assert.equal(await page.evaluate(() => window.thenar.picture.touches.sums.shafts.count), 0);
  });
});

/** Width and height of a PNG file. */
const sizeOf = (png) => [png.readUInt32BE(16), png.readUInt32BE(20)];

test('a picture is as large as asked for, and shows its time', async () => {
  const shot = async (...options) => {
    const file = join(folder, 'shot.png');
    thenar('export', recorded, '--png', file, ...options);
    return readFile(file);
  };
  const alone = ['--alone', '--size', '400x300'];
  const [start, middle, again] = [await shot('--at', '0', ...alone), await shot('--at', '1 s', ...alone), await shot('--at', '1 s', ...alone)];
  assert.deepEqual(sizeOf(start), [400, 300]);
  assert.ok(middle.equals(again), 'the same time has the same pixels');
  assert.ok(!start.equals(middle), 'another time has others');
  assert.deepEqual(sizeOf(await shot()), [1280, 800]);
});

test('a film has every frame, also where drawing takes longer than it lasts', (context) => {
  if (spawnSync('ffmpeg', ['-version'], {stdio: 'ignore'}).status !== 0) return context.skip('no ffmpeg here');
  const frames = (name, ...options) => {
    const file = join(folder, name);
    // The box moves in this time: no two frames are alike, which a format might make one of.
    thenar('export', recorded, '--film', file, '--from', '0.6 s', '--to', '1 s', '--alone', '--size', '320x240', ...options);
    const counted = execFileSync('ffprobe', ['-v', 'error', '-count_frames', '-show_entries', 'stream=nb_read_frames,width,height',
                                             '-of', 'csv=p=0', file], {encoding: 'utf8'});
    return counted.trim().split(',').map(Number);
  };
  assert.deepEqual(frames('a.gif', '--fps', '10'), [320, 240, 5]);
  assert.deepEqual(frames('a.mp4', '--fps', '20', '--speed', '0.5'), [320, 240, 17]);
});
