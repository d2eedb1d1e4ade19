// What the program exports opens from a file with no network, and plays: node offline.mjs THENAR CONFIGS

import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtemp, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

import {findChromium, openBrowser} from './browser.mjs';

const [program, configs] = process.argv.slice(2);
findChromium();
const folder = await mkdtemp(join(tmpdir(), 'thenar-export-'));
const recorded = join(folder, 'grasp.mcap');
const exported = join(folder, 'grasp.html');
execFileSync(program, ['run', join(configs, 'box_grasp.yaml'), '--time', '1 s', '--record', recorded], {cwd: folder});
execFileSync(program, ['export', recorded, '--html', exported], {cwd: folder});

const browser = await openBrowser();
try {
  const {page} = browser;
  await page.context().setOffline(true);
  await page.goto(pathToFileURL(exported).href);
  await page.waitForFunction(() => window.thenar?.drawn > 0 && window.thenar.plots > 0, null, {timeout: 60000});

  // The object is where its pose says, on the screen; contacts carry force.
  const seen = await page.evaluate(() => {
    const {thenar} = window;
    thenar.replay.pause();
    thenar.replay.seek(thenar.replay.duration);
    const [x, y] = thenar.project(Array.from(thenar.state.object.subarray(0, 3)));
    return {contacts: thenar.contacts, hit: thenar.hitObject(x, y), x, y, metres: thenar.metresPerPixel([0, 0, 0])};
  });
  assert.ok(seen.contacts > 0);
  assert.ok(seen.metres > 1e-5 && seen.metres < 1e-3);
  await page.waitForTimeout(500);
  const canvas = await page.locator('#canvas').boundingBox();
  const clip = {x: canvas.x + seen.x - 4, y: canvas.y + seen.y - 4, width: 8, height: 8};
  const drawn = await page.screenshot({clip});
  const empty = await page.screenshot({clip: {...clip, x: canvas.x + 4, y: canvas.y + 4}});
  assert.ok(!drawn.equals(empty), 'the object is not drawn');

  // The slider is the time, by hand and by program.
  const slider = page.locator('#seek');
  await slider.fill('0');
  const start_s = await page.evaluate(() => window.thenar.state.time_s[0]);
  const half = await page.evaluate(() => window.thenar.replay.duration / 2);
  await slider.fill(String(half));
  const middle_s = await page.evaluate(() => window.thenar.state.time_s[0]);
  assert.ok(Math.abs(middle_s - start_s - half) < 0.05, `${middle_s} s where ${start_s + half} s are due`); // a frame or so

  // It plays, and stands.
  await slider.fill('0');
  await page.locator('#play').click();
  await page.waitForFunction(() => window.thenar.replay.time > 0.1, null, {timeout: 60000});
  await page.locator('#play').click();
  assert.equal(await page.evaluate(() => window.thenar.replay.playing), false);

  assert.deepEqual(browser.requests.filter((url) => !url.startsWith('file:') && !url.startsWith('data:')), []);
  assert.deepEqual(browser.problems, []);
  console.log('an exported page opens from a file, draws, seeks and plays');
} finally {
  await browser.close();
  await rm(folder, {recursive: true, force: true});
}
