// SPDX-License-Identifier: Apache-2.0
// Makes pictures and the film of the documents anew, by the page itself: node pictures.mjs PROGRAMS SCENES DOCS [NAME...]
// PROGRAMS has thenar and thenar-window. Without names all are made: film, grasp, grip_lift, stiff, touch, window.

import {execFileSync} from 'node:child_process';
import {mkdtemp, readFile, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

import {openBrowser} from './test/browser.mjs';
import {startProgram} from './test/program.mjs';

const [programs, scenes, docs, ...asked] = process.argv.slice(2);
const work = await mkdtemp(join(tmpdir(), 'thenar-pictures-'));
const thenar = (...args) => execFileSync(join(programs, 'thenar'), args, {stdio: ['ignore', 'ignore', 'inherit']});

/** A recording of a scene, with these options of `thenar run`. */
function record(scene, ...options) {
  const file = join(work, `${scene}.mcap`);
  thenar('run', join(scenes, `${scene}.yaml`), '--quiet', ...options, '--record', file);
  return file;
}

const exported = (recording, ...options) => thenar('export', recording, ...options);

/** Opens a page, and lets `take` make pictures of it. */
async function withPage(size, url, take) {
  const {page, close} = await openBrowser(size);
  try {
    await page.goto(url);
    await take(page);
  } finally {
    await close();
  }
}

/** The live window, while the mouse pulls at the box. */
async function windowPicture() {
  const server = await startProgram(join(programs, 'thenar-window'), [join(scenes, 'box_grasp.yaml'), '--port', '0']);
  try {
    await withPage({width: 1440, height: 900}, server.url, async (page) => {
      await page.waitForFunction(() => window.thenar?.connected && thenar.state?.time_s[0] > 3);
      const box = await page.locator('#canvas').boundingBox();
      const [x, y] = await page.evaluate(() => thenar.project(Array.from(thenar.state.object.subarray(0, 3))));
      await page.mouse.move(box.x + x, box.y + y);
      await page.mouse.down();
      await page.mouse.move(box.x + x + 60, box.y + y - 40, {steps: 20});
      await page.waitForFunction(() => {
        const times_s = thenar.plotted();
        return thenar.state.pull_force_N[0] ** 2 > 0 && times_s.at(-1) - times_s[0] > 4; // the plots have something to show
      });
      await page.screenshot({path: join(docs, 'window.png')});
      await page.mouse.up();
    });
  } finally {
    await server.stop();
  }
}

/** The box with little stiffness asked for, and with much: picture, stiffness and muscles, side by side. */
async function stiffPicture() {
  const columns = [];
  for (const [along, about] of [['50 N/m', '0.02 N*m/rad'], ['300 N/m', '0.08 N*m/rad']]) {
    const three = (value) => `[${[value, value, value].join(', ')}]`;
    const key = 'control.muscles.object_stiffness';
    const recording = record('box_stiff', '--time', '1 s', '--set', `${key}.translation=${three(along)}`, '--set', `${key}.rotation=${three(about)}`);
    const html = join(work, 'stiff.html');
    exported(recording, '--html', html);
    await withPage({width: 1180, height: 860}, pathToFileURL(html).href, async (page) => {
      await page.waitForFunction(() => window.thenar?.drawn > 0);
      await page.evaluate(() => thenar.showAt(thenar.replay.duration));
      const parts = [];
      for (const id of ['picture', 'panel-stiffness', 'panel-muscles']) parts.push(await page.locator(`#${id}`).screenshot());
      columns.push(parts.map((png) => `<img width="560" src="data:image/png;base64,${png.toString('base64')}">`).join(''));
    });
  }
  await withPage({width: 1160, height: 700}, 'about:blank', async (page) => {
    await page.setContent(`<body style="margin:8px;display:flex;gap:16px;background:#eceff3">${
        columns.map((column) => `<div style="display:grid;gap:8px">${column}</div>`).join('')}`);
    await page.screenshot({path: join(docs, 'stiff.png'), fullPage: true});
  });
}

/** A figure of a run, as a picture. */
async function figure(scene, name, file) {
  const out = join(work, scene);
  thenar('run', join(scenes, `${scene}.yaml`), '--quiet', '--out', out);
  const svg = await readFile(join(out, name), 'utf8');
  const [, width, height] = /<svg\s+width="(\d+)" height="(\d+)"/.exec(svg).map(Number);
  await withPage({width, height}, pathToFileURL(join(out, name)).href, (page) => page.screenshot({path: file}));
}

const pictures = {
  grasp: () => exported(record('mug'), '--png', join(docs, 'grasp.png'), '--alone', '--size', '1000x720'),
  touch: () => exported(record('box_wet'), '--png', join(docs, 'touch.png'), '--at', '0.88 s', '--size', '1440x900'),
  window: windowPicture,
  stiff: stiffPicture,
  grip_lift: () => figure('grip_lift', 'task.svg', join(docs, 'guide', 'grip_lift.png')),
  film: () => exported(record('pick_and_place'), '--film', join(docs, 'film.webp'), '--fps', '10', '--size', '960x620'),
};

try {
  for (const name of asked.length > 0 ? asked : Object.keys(pictures)) {
    if (!pictures[name]) throw new Error(`there is no picture '${name}', but ${Object.keys(pictures).join(', ')}`);
    console.error(`making ${name}`);
    await pictures[name]();
  }
} finally {
  await rm(work, {recursive: true, force: true});
}
