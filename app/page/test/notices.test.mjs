// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {noticesOf, restOf} from '../src/notices.js';
import {kNoGraphics, waitText} from '../src/waiting.js';

const values = {grasp_failed: [0], muscles_failed: [0], held: [0], phase: [2]};
const lost = {outcome: 'lost', reason: 'at 4.450 s the major had slid by 8 mm', warnings: ['the patch of the thumb is wide', 'the list is short'], note: 'a remark'};
const kinds = (notices) => notices.map(({kind}) => kind);
const texts = (notices) => notices.map(({text}) => text);

test('a loss comes before warnings, and these before remarks; each is there by itself', () => {
  const all = noticesOf({status: lost, values});
  assert.deepEqual(kinds(all), ['grave', 'warn', 'warn', 'note']);
  assert.deepEqual(texts(all), ['lost: at 4.450 s the major had slid by 8 mm', ...lost.warnings, 'a remark']);
  const failing = noticesOf({status: {...lost, outcome: 'slipping'}, values: {...values, grasp_failed: [1]}});
  assert.match(failing[0].text, /^No grasp forces exist/);
  assert.deepEqual(kinds(failing), ['grave', 'warn', 'warn', 'warn', 'note']);
  assert.match(noticesOf({isLost: true, status: lost, values})[0].text, /connection/);
});

test('a grasp that is held, and a task that is done, are no notices', () => {
  for (const outcome of ['held', 'task done']) {
    assert.deepEqual(noticesOf({status: {...lost, outcome, warnings: [], note: null}, values}), []);
  }
  assert.deepEqual(noticesOf({}), []);
});

test('a notice stays the same one while only its numbers change', () => {
  const key = (reason, outcome = 'lost') => noticesOf({status: {outcome, reason}})[0].key;
  assert.equal(key('at 4.450 s'), key('at 4.460 s'));
  assert.notEqual(key('', 'lost'), key('', 'solver failed'));
  const warning = (text) => noticesOf({status: {outcome: 'held', warnings: [text]}})[0].key;
  assert.equal(warning('in 34 % of the ticks'), warning('in 100 % of the ticks'));
  assert.notEqual(warning('in 34 % of the ticks'), warning('for 34 % of the ticks'));
});

test('the line tells the phase of a task, or the outcome, when there is nothing else', () => {
  const phases = ['close', 'load', 'lift'];
  assert.deepEqual(restOf({status: {outcome: 'held'}, values, phases}), {kind: 'note', text: 'phase 3 of 3: lift'});
  assert.equal(restOf({status: {outcome: 'held'}, values: {...values, phase: [3]}, phases}).text, 'the task is done');
  assert.deepEqual(restOf({status: {outcome: 'held'}, values}), {kind: 'calm', text: 'held'});
  assert.deepEqual(restOf({status: lost, values, phases}), {kind: 'over', text: 'lost'});
  assert.deepEqual(restOf({}), {kind: 'none', text: ''});
});

test('until the first picture is drawn the page says what it waits for, each step in other words', () => {
  const steps = [{isLive: true}, {isLive: true, hasTried: true}, {isLive: true, isConnected: true, hasTried: true},
    {isLive: true, isConnected: true, hasScene: true}, {isLive: true, isConnected: true, hasScene: true, hasState: true},
    {isLive: true, hasState: true, isSoftware: true}, {isLive: false}, {failure: 'the recording holds no states'}];
  const said = steps.map((step) => waitText({drawn: 0, ...step}));
  assert.ok(said.every((text) => text.length > 10), JSON.stringify(said));
  assert.equal(new Set(said).size, steps.length);
  for (const step of steps) assert.equal(waitText({...step, drawn: 1}), '');
  assert.match(kNoGraphics, /WebGL/);
});
