// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {readFile, readdir} from 'node:fs/promises';
import test from 'node:test';

import {Color, Vector3} from 'three';

import {slipping, stuck} from '../src/colors.js';
import palette from '../src/palette.js';
import {Forces} from '../src/forces.js';
import {Arrows} from '../src/rods.js';
import {ciede2000, distance, sights} from './color_vision.mjs';

// Sharma, Wu, Dalal 2005, table 1: pairs 1, 14, 17, 19, 25 and 34.
test('the measure of colours is CIEDE2000', () => {
  for (const [one, other, expected] of [
    [[50, 2.6772, -79.7751], [50, 0, -82.7485], 2.0425], [[50, 2.5, 0], [50, 0, -2.5], 4.3065],
    [[50, 2.5, 0], [73, 25, -18], 27.1492], [[50, 2.5, 0], [58, 24, 15], 19.4535],
    [[60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644], [[2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082],
  ]) assert.ok(Math.abs(ciede2000(one, other) - expected) < 5e-5, `${ciede2000(one, other)}, not ${expected}`);
});

// Two colours that differ by 40 are as unlike as the primaries of a chart; 2 is what one just sees side by side. The green
// and red that were here before differed by 68 to most eyes, and by 14 without one kind of cones.
test('who lacks a kind of cones tells stuck from slipping as others do', () => {
  assert.deepEqual(sights, ['all', 'protanopia', 'deuteranopia', 'tritanopia']);
  for (const sight of sights) assert.ok(distance(stuck, slipping, sight) >= 40, `${sight}: ${distance(stuck, slipping, sight)}`);
  assert.ok(distance('#178a4c', '#e01b1b', 'deuteranopia') < 20, 'the measure tells what is alike');
});

/** The least distance between any two colours to any eyes. */
const least = (colors) => Math.min(...sights.flatMap((sight) =>
  colors.flatMap((one, i) => colors.slice(0, i).map((other) => distance(one, other, sight)))));

// Curves have words or places beside their colours, so that half of what areas need is enough; the least distance of
// plain red, green and blue, as there were before, is 7.
test('who lacks a kind of cones tells fingers, axes and forces apart', () => {
  for (const {normal, tangential, x, y, z} of [palette.light, palette.dark]) {
    assert.ok(least([normal, tangential]) >= 40, `forces: ${least([normal, tangential])}`);
    assert.ok(least([x, y, z]) >= 19, `axes: ${least([x, y, z])}`);
  }
  assert.ok(least(palette.fingers) >= 19, `fingers: ${least(palette.fingers)}`);
  assert.ok(least([palette.stuck, palette.slipping, palette.at_limit]) >= 40);
});

test('the page takes its colours of fingers, axes and forces from the palette alone', async () => {
  const folder = new URL('../src/', import.meta.url);
  const own = Object.values(palette.light).concat(Object.values(palette.dark), palette.fingers, palette.stuck, palette.slipping);
  for (const name of await readdir(folder)) {
    if (name === 'palette.js') continue;
    const text = await readFile(new URL(name, folder), 'utf8');
    for (const color of own) assert.ok(!text.includes(color), `${name} has ${color} a second time`);
    assert.doesNotMatch(text, /--(normal|tangential|x|y|z):/, `${name} sets a colour of the palette`);
  }
});

test('an arrow with two heads has one more, of the same colour, and ends where it should', () => {
  const arrows = new Arrows(4);
  arrows.put(new Vector3(), new Vector3(0, 1, 0), 0.01, new Color(stuck));
  assert.equal(arrows.heads.count, 1);
  arrows.put(new Vector3(), new Vector3(0, 1, 0), 0.01, new Color(slipping), true);
  assert.equal(arrows.heads.count, 3);
  assert.equal(arrows.shafts.count, 2);
});

/** A state of one finger with two contacts: one in the middle of its cone, one at the edge. */
test('contacts at the edge of their cones are red with two heads, others blue with one', () => {
  const state = {
    contacts: 2, columns: {point_m: 0, normal: 3, force_N: 6}, contact: (i) => 9 * i,
    numbers: [0, 0, 0, 1, 0, 0, 1, 0, 0, /**/ 0, 0, 0, 1, 0, 0, 1, 0.5, 0],
    values: {friction: [0.5], force_N: [0, 0, 0], desired_N: [0, 0, 0], centre_m: [NaN, NaN, NaN], sliding_share: [0],
             pull_anchor_m: [NaN, NaN, NaN], pull_handle_m: [NaN, NaN, NaN], pull_force_N: [NaN, NaN, NaN]},
  };
  const forces = new Forces({fingers: [{name: 'thumb'}]});
  const label = () => ({text: '', at: new Vector3(), element: {classList: {toggle() {}}}});
  forces.show(state, {forces: true}, [label(), label()]);
  assert.equal(forces.contactArrows.heads.count, 3);
  const colorOf = (i) => {
    const color = new Color();
    forces.contactArrows.shafts.getColorAt(i, color);
    return `#${color.getHexString()}`;
  };
  assert.deepEqual([colorOf(0), colorOf(1)], [stuck, slipping]);
});

test('what is bad in the panels is striped, too', async () => {
  const style = await readFile(new URL('../src/style.css', import.meta.url), 'utf8');
  assert.match(style, /\.bad \.track > i[^}]*repeating-linear-gradient/);
});
