// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {readdir, readFile} from 'node:fs/promises';
import test from 'node:test';

import {checkParts, readGuide} from '../guide.mjs';

const read = (name) => readFile(new URL(`../${name}`, import.meta.url), 'utf8');
const guide = readGuide(await read('window.md'));
const folder = new URL('../src/', import.meta.url);
const names = (await readdir(folder)).filter((name) => /\.(js|html)$/.test(name));
const sources = await Promise.all(names.map((name) => readFile(new URL(name, folder), 'utf8')));

test('the guide tells of every part of the page, and of no other', () => {
  checkParts(guide, sources);
  assert.ok(Object.keys(guide.parts).length > 20);
  assert.throws(() => checkParts(guide, [...sources, '<b data-tip="Wings">']), /does not say what 'Wings' is/);
  assert.throws(() => checkParts({parts: {...guide.parts, Wings: 'for flying'}}, sources), /the page has no 'Wings'/);
});

test('no text of a part stands in the sources, too', () => {
  for (const text of Object.values(guide.parts)) {
    if (text.split(' ').length > 3) assert.ok(!sources.some((source) => source.includes(text)), text);
  }
});

test('keys and mouse are those of the guide', () => {
  assert.deepEqual(guide.inputs.find(({input}) => input === 'p'), {input: 'p', does: 'pokes it away from you', where: 'live'});
  assert.ok(guide.inputs.every(({input, does}) => input && does));
});

test('a guide without its tables is refused', () => {
  assert.throws(() => readGuide('# The window\n'), /no section 'What the page shows'/);
  assert.throws(() => readGuide('## What the page shows\n\nNothing.\n'), /no table/);
});
