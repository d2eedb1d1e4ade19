// SPDX-License-Identifier: Apache-2.0
// The page on a large desktop, a laptop, a tablet and a phone, in light and dark: nothing is cut off, and all can be reached.
//     node layout.mjs THENAR CONFIGS [FOLDER FOR SCREENSHOTS]

import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtemp, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {pathToFileURL} from 'node:url';

import {findChromium, openBrowser} from './browser.mjs';
import {startProgram} from './program.mjs';

const [program, configs, shots] = process.argv.slice(2);
findChromium();

const kSizes = [[1440, 900], [1280, 800], [1000, 700], [800, 900], [390, 844]];
const kSchemes = ['light', 'dark'];
const kPhone = 560; // windows up to this width are used with fingers,
const kFinger = 40; // which need so many pixels
const kPictureShare = 0.5; // of the window's height, at least
const kReason = 'at 4.450 s the major had slid by more than its pulp\'s radius, 8 mm; before that the index had slid by 3.2 mm, ' +
    'and the grasp forces were at their limits for 0.4 s; the object was 13.5 mm off its target';
const kWarnings = ['the patch of the thumb is wider than its pulp is good for: 9.1 mm of 8 mm in 34 % of the ticks',
  'the list of contacts of the index is too short (contact.max_per_finger: 30) in 100 % of the ticks: 35 would serve'];

let folder = null;
let server = null;
let browser = null;
let page = null;
let link = null; // to the page, as the program has it
const said = []; // on the console

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'thenar-layout-'));
  server = await startProgram(join(dirname(program), 'thenar-window'),
                              [join(configs, 'box_wet.yaml'), '--port', '0', '--set', 'object.points=6000']);
  browser = await openBrowser();
  page = browser.page;
  page.on('console', (message) => said.push(message.text()));
  await page.routeWebSocket(/\/live/, (route) => {
    link = route;
    route.connectToServer();
  });
  await page.goto(server.url);
  await page.waitForFunction(() => window.thenar?.drawn > 0 && window.thenar.plots > 0 && window.thenar.contacts > 0);
  await page.locator('#pause').click(); // what is shown stays
  await page.waitForFunction(() => window.thenar.status.paused && !window.thenar.status.running);
});

after(async () => {
  await browser?.close();
  await server?.stop();
  await rm(folder, {recursive: true, force: true});
});

/** Calls `look(name, width, height)` at each size in both schemes, when the page has settled there. */
async function atEachSize(what, look) {
  for (const colorScheme of kSchemes) {
    await page.emulateMedia({colorScheme});
    for (const [width, height] of kSizes) {
      await page.setViewportSize({width, height});
      // Observers of sizes, then a drawing.
      await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50)))));
      await look(`${what} at ${width} x ${height}, ${colorScheme}`, width, height);
    }
  }
  assert.deepEqual([said, browser.problems], [[], []], 'the console is silent');
}

async function shoot(name) {
  if (!shots) return;
  await page.waitForTimeout(1500); // without a graphics card a picture takes its time
  await page.screenshot({path: join(shots, `${name.replaceAll(/\W+/g, '-')}.png`)});
}

/** Texts that are seen in part: beyond the window, or cut off by what holds them. A list may be scrolled down, not across. */
const cutTexts = () => page.evaluate(() => {
  // In full they are elsewhere: in the title, in the list of notices; labels follow places of the picture.
  const mayBeCut = '#scene-name, #notices .text, #grasps h3, #labels, option, script, style';
  const found = [];
  const range = document.createRange();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text = walker.nextNode(); text; text = walker.nextNode()) {
    const parent = text.parentElement;
    if (!text.data.trim() || parent.closest(mayBeCut) || !parent.checkVisibility({visibilityProperty: true, opacityProperty: true})) continue;
    range.selectNodeContents(text);
    for (const {left, right, top, bottom, width} of range.getClientRects()) {
      let isCut = width > 0 && (left < -1 || right > innerWidth + 1);
      let scrolls = false;
      for (let part = parent; part && !isCut; part = part.parentElement) {
        const {display, overflowX, overflowY, position} = getComputedStyle(part);
        if (display === 'inline' || display === 'contents') continue;
        const box = part.getBoundingClientRect();
        scrolls ||= /auto|scroll/.test(overflowY);
        isCut = (overflowX !== 'visible' && (left < box.left - 1 || right > box.right + 1)) ||
            (overflowY !== 'visible' && !scrolls && (top < box.top - 2 || bottom > box.bottom + 2));
        if (position === 'fixed') break;
      }
      if (isCut) found.push(`${parent.closest('[id]')?.id}: ${text.data.trim()}`);
    }
  }
  return found;
});

/** Buttons and figures within a part that lie on one another, or beyond it. */
const overlaps = (selector) => page.locator(selector).evaluate((whole) => {
  const parts = [...whole.querySelectorAll('button, select, a, h1, .badge, .figure, input, output')]
      .filter((part) => part.checkVisibility({visibilityProperty: true}) && !part.closest(':popover-open'))
      .map((part) => ({name: part.id || part.textContent, box: part.getBoundingClientRect()}));
  const edge = whole.getBoundingClientRect();
  const isOut = ({left, right}) => left < edge.left - 1 || right > edge.right + 1;
  const isOn = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  return parts.flatMap(({name, box}, i) => [...(isOut(box) ? [`${name} beyond it`] : []),
    ...parts.slice(0, i).filter((other) => isOn(box, other.box)).map((other) => `${name} on ${other.name}`)]);
});

const boxOf = (selector) => page.locator(selector).evaluate((part) => {
  const {left, top, right, bottom, width, height} = part.getBoundingClientRect();
  return {left, top, right, bottom, width, height};
});

/** Nothing goes beyond the window, no text is cut, and the picture has its share. */
async function expectFits(name, height) {
  const over = await page.evaluate(() => [document.documentElement, document.body, document.querySelector('main')]
      .map((part) => part.scrollWidth - part.clientWidth));
  assert.ok(Math.max(...over) <= 0, `${name}: nothing is to be scrolled across: ${over}`);
  assert.deepEqual(await cutTexts(), [], `${name}: cut texts`);
  assert.deepEqual(await overlaps('body > header'), [], `${name}: one part of the header lies on another`);
  const share = (await boxOf('#picture')).height / height;
  assert.ok(share >= kPictureShare, `${name}: the picture has ${share} of the height`);
}

/** What fingers press is large enough for them. */
async function expectFingers(name) {
  const small = await page.evaluate((least) => [...document.querySelectorAll('button, select, summary, a, input')]
      .filter((part) => part.checkVisibility({visibilityProperty: true}))
      .map((part) => [part.id || part.textContent || part.name, (part.closest('label:has(> input[type=checkbox])') ?? part).getBoundingClientRect()])
      .filter(([, {width, height}]) => width < least || height < least).map(([what, {width, height}]) => `${what}: ${width} x ${height}`), kFinger);
  assert.deepEqual(small, [], `${name}: too small for a finger`);
}

/** Values as long as they may become. */
const lengthen = () => page.evaluate(() => {
  const fill = (selector, text) => document.querySelectorAll(selector).forEach((part) => (part.textContent = text));
  fill('#time', '3599.999');
  fill('#latency-p50, #latency-p99', '1234.56');
  fill('#reference-error, #reference-residual', '1.2·10⁻¹²');
  fill('#path-error', '−123.456');
  fill('#turn-error', '−179.99');
  fill('#rates td', '9999 µs');
  fill('#figures td', '320 of 320');
  fill('#stages span:last-child', '9999');
  fill('#touch td:not(.meter)', '100 %');
  fill('#last-reflex', 'thumb, load, 3599.99 s');
});

test('the running page fits, with values as long as they may become', async () => {
  await atEachSize('live', async (name, width, height) => {
    await lengthen();
    await expectFits(name, height);
    if (width <= kPhone) await expectFingers(name);
    await shoot(name);
    if (width > 1200) return;
    // Below the picture, which stays, the last panel can be reached.
    await page.locator('#latency').scrollIntoViewIfNeeded();
    const [last, picture] = [await boxOf('#latency'), await boxOf('#picture')];
    assert.ok(last.bottom <= height + 1 && last.bottom > picture.bottom && picture.top >= 0, `${name}: the last panel is seen below the picture`);
    await shoot(`${name}, at its end`);
    await page.evaluate(() => document.querySelector('main').scrollTo(0, 0));
  });
});

test('menus and settings open where there is no room for them, and hold all of it', async () => {
  await atEachSize('opened', async (name, width, height) => {
    for (const menu of ['tools', 'views']) {
      const opener = page.locator(`#show-${menu}`);
      assert.equal(await opener.isVisible(), width <= kPhone, `${name}: ${menu}`);
      if (width > kPhone) continue;
      await opener.click();
      assert.ok((await boxOf(`#${menu}`)).bottom <= height && (await boxOf(`#${menu}`)).left >= 0, `${name}: ${menu}`);
      await expectFits(name, height);
      await expectFingers(name);
      await shoot(`${name}, ${menu}`);
      await page.keyboard.press('Escape');
      assert.ok(!(await page.locator(`#${menu}`).isVisible()));
      assert.equal(await page.evaluate(() => document.activeElement.id), `show-${menu}`, 'the focus comes back');
    }
    if (width <= kPhone) await page.locator('#show-tools').click();
    await page.locator('#show-settings').click();
    await expectFits(name, height);
    assert.deepEqual(await overlaps('#settings'), [], name);
    if (width <= kPhone) await expectFingers(name);
    await shoot(`${name}, settings`);
    await page.locator('#close-settings').click();
    assert.ok(!(await page.locator('#settings').isVisible()));
  });
});

test('the help fits, is scrolled, keeps the focus, and gives it back', async () => {
  await atEachSize('help', async (name, width, height) => {
    const opener = width <= kPhone ? '#show-tools' : '#show-help';
    await page.locator(opener).focus();
    await page.keyboard.press('h');
    const {left, top, right, bottom} = await boxOf('#help');
    assert.ok(left >= 0 && top >= 0 && right <= width && bottom <= height, `${name}: ${[left, top, right, bottom]}`);
    assert.deepEqual(await cutTexts(), [], `${name}: cut texts`);
    await shoot(name);
    // Its last line can be reached by keys alone.
    await page.locator('#help .inside').focus();
    await page.keyboard.press('End');
    await page.waitForFunction((end) => document.querySelector('#parts > :last-child').getBoundingClientRect().bottom <= end, bottom);
    for (let i = 0; i < 6; ++i) {
      await page.keyboard.press('Tab');
      assert.ok(await page.evaluate(() => document.activeElement === document.body || document.activeElement.closest('#help')), `${name}: the focus stays`);
    }
    await page.keyboard.press('Escape');
    assert.ok(!(await page.locator('#help').isVisible()));
    assert.equal(await page.evaluate(() => `#${document.activeElement.id}`), opener, `${name}: the focus comes back`);
    await page.keyboard.press('h');
    await page.locator('#help button').click();
    assert.ok(!(await page.locator('#help').isVisible()));
  });
});

test('a loss is told before warnings, beside the picture, and is closed; all stays in the list', async () => {
  const status = await page.evaluate(() => window.thenar.status);
  const line = () => page.evaluate(() => ['alert', 'say'].map((id) => document.getElementById(id).textContent));
  await atEachSize('lost', async (name, width, height) => {
    link.send(JSON.stringify({...status, outcome: 'lost', reason: kReason, warnings: kWarnings, note: null}));
    await page.waitForFunction(() => document.getElementById('alert').textContent.startsWith('lost: '));
    assert.deepEqual(await line(), [`lost: ${kReason}`, '']);
    assert.ok((await boxOf('#notices')).bottom <= (await boxOf('#picture')).top, `${name}: it is not on the picture`);
    await expectFits(name, height);
    await shoot(name);
    await page.locator('#all-notices').click();
    assert.deepEqual(await page.locator('#notice-list li span').allTextContents(), [`lost: ${kReason}`, ...kWarnings]);
    assert.deepEqual(await cutTexts(), [], `${name}: cut texts of the list`);
    await shoot(`${name}, all`);
    await page.keyboard.press('Escape');
    assert.ok(!(await page.locator('#notice-list').isVisible()));
    for (const text of kWarnings) {
      await page.locator('#close-notice').click();
      assert.deepEqual(await line(), ['', text], name);
    }
    await page.locator('#close-notice').click();
    assert.deepEqual(await line(), ['', 'lost'], `${name}: the outcome itself stays`);
    assert.ok(!(await page.locator('#close-notice').isVisible()));
    assert.ok(await page.locator('#all-notices').isVisible());
    link.send(JSON.stringify({...status, outcome: 'held', reason: '', warnings: [], note: null}));
    await page.waitForFunction(() => document.getElementById('say').textContent === 'held');
  });
});

test('found grasps fit, with all their figures', async () => {
  const figures = [['width', 'mm', 1], ['press', 'N', 2], ['margin', '', 2], ['needed friction', '', 2], ['limit', 'deg', 0], ['effort', 'N m', 3],
    ['patch', '', 2], ['travel', 'mm', 0]].map(([shown, shown_unit, digits]) => ({name: shown, shown, shown_unit, digits, factor: 1, sentence: shown}));
  const {fingers, segments, poses, object} = await page.evaluate(() => ({fingers: window.thenar.scene.fingers, segments: window.thenar.scene.segments,
    poses: Array.from(window.thenar.state.segments), object: Array.from(window.thenar.state.object)}));
  const grasp = {...Object.fromEntries(figures.map(({name}) => [name, 88.888])), fingers: fingers.map(({name}) => name), limit_joint: 'a joint',
    within_limits: true, words: 'the thumb faces the others across the middle of the box. '.repeat(5), hand: {fingers, segments, poses}, object, scene: ''};
  link.send(JSON.stringify({type: 'grasps', search: 1, running: false, stopping: false, share: 1, found: 3, taken: 2, refusal: null, took_s: 123.4,
    measures: figures, grasps: [grasp, {...grasp, within_limits: false}, grasp]}));
  await page.keyboard.press('g');
  await page.locator('#grasps li').first().waitFor();
  await atEachSize('grasps', async (name, width, height) => {
    await expectFits(name, height);
    for (let i = 0; i < 3; ++i) assert.deepEqual(await overlaps(`#grasps li:nth-child(${i + 1})`), [], name);
    if (width <= kPhone) await expectFingers(name);
    await shoot(name);
  });
  await page.keyboard.press('g');
});

test('a replay fits', async () => {
  const recorded = join(folder, 'stiff.mcap');
  const run = (...args) => execFileSync(program, args, {cwd: folder, stdio: ['ignore', 'ignore', 'inherit']});
  run('run', join(configs, 'box_stiff.yaml'), '--set', 'object.points=6000', '--time', '0.6 s', '--record', recorded);
  run('export', recorded, '--html', join(folder, 'stiff.html'));
  await page.goto(pathToFileURL(join(folder, 'stiff.html')).href);
  await page.waitForFunction(() => window.thenar?.drawn > 0 && window.thenar.plots > 0);
  await page.evaluate(() => {
    window.thenar.replay.pause();
    window.thenar.replay.seek(0.2);
  });
  await page.waitForTimeout(300); // plots are drawn ten times a second
  await atEachSize('replay', async (name, width, height) => {
    await expectFits(name, height);
    if (width <= kPhone) await expectFingers(name);
    const slider = await boxOf('#seek');
    assert.ok(slider.width > 120, `${name}: the slider of time has ${slider.width} pixels`);
    await shoot(name);
  });
});

test('a page that waits says for what', async () => {
  const other = await page.context().newPage();
  try {
    let connect = null;
    const allowed = new Promise((resolve) => (connect = resolve));
    await other.routeWebSocket(/\/live/, async (route) => {
      await allowed;
      route.connectToServer();
    });
    await other.goto(server.url);
    const says = (words) => other.waitForFunction((text) => document.getElementById('wait').textContent.includes(text), words);
    await says('Connecting to the program');
    if (shots) await other.screenshot({path: join(shots, 'waits.png')});
    connect();
    await other.waitForFunction(() => window.thenar.drawn > 0);
    assert.equal(await other.locator('#wait').textContent(), '');
    assert.equal(await other.locator('#link').textContent(), 'live');
  } finally {
    await other.close();
  }
  const without = await page.context().newPage();
  try {
    await without.addInitScript(() => (HTMLCanvasElement.prototype.getContext = () => null));
    await without.goto(server.url);
    await without.waitForFunction(() => document.getElementById('wait').textContent.includes('WebGL'));
    if (shots) await without.screenshot({path: join(shots, 'no-graphics.png')});
  } finally {
    await without.close();
  }
});
