// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {State, readGeometry, shownMeasures} from '../src/messages.js';
import {geometry, kTetrahedron, scene, state, withSurface} from './synthetic.mjs';

const bytes = (buffer) => new Uint8Array(buffer);

test('fields are found where the table says, not where they used to be', () => {
  const shown = new State(scene);
  shown.take(bytes(state(0.5)));
  assert.equal(shown.values.time_s[0], 0.5);
  assert.equal(shown.values.object[1], 0.005);
  assert.equal(shown.values.displacement_m.length, 360);
  // A table that swaps two fields swaps what they read.
  const swapped = structuredClone(scene);
  const [time, tick] = swapped.fields;
  [time.begin, tick.begin] = [tick.begin, time.begin];
  const other = new State(swapped);
  other.take(bytes(state(0.5)));
  assert.equal(other.values.tick[0], 0.5);
});

test('a recording of an older program shows the same forces', () => {
  const old = structuredClone(scene);
  const names = {normal_N: 'force_n_N', tangential_N: 'force_t_N', desired_normal_N: 'desired_n_N', desired_tangential_N: 'desired_t_N'};
  for (const field of old.fields) field.name = names[field.name] ?? field.name;
  const shown = new State(old);
  shown.take(bytes(state(0.5)));
  assert.equal(shown.values.normal_N[0], 1);
  assert.equal(shown.values.desired_tangential_N[2], 0.3);
});

test('the object\'s surface is read where there is one, and a triangle of nothing is refused', () => {
  const without = readGeometry(bytes(geometry()), scene);
  assert.equal(without.object.triangles.length, 0);
  const {scene: closed, geometry: message} = withSurface(kTetrahedron);
  const {object, fingers} = readGeometry(bytes(message), closed);
  assert.deepEqual([...object.triangles], kTetrahedron.triangles);
  assert.deepEqual([...object.vertices], [...Float32Array.from(kTetrahedron.vertices)]);
  assert.deepEqual(fingers[0].areas, without.fingers[0].areas);
  const broken = withSurface({...kTetrahedron, triangles: [0, 1, 4]});
  assert.throws(() => readGeometry(bytes(broken.geometry), broken.scene), /a vertex that is not there/);
  assert.throws(() => readGeometry(bytes(message), scene), /numbers where the scene has/);
});

test('messages of the versions that there were are read, a newer one is refused', () => {
  for (const version of [1, 2, 3]) {
    const old = Buffer.from(geometry());
    old.writeUInt16LE(version, 4);
    readGeometry(bytes(old), scene);
  }
  const newer = Buffer.from(geometry());
  newer.writeUInt16LE(4, 4);
  assert.throws(() => readGeometry(bytes(newer), scene), /reload it/);
});

test('contacts are read by row, from any place in memory', () => {
  const message = bytes(state(0));
  const off = new Uint8Array(message.length + 3).subarray(3); // no multiple of eight
  off.set(message);
  const shown = new State(scene);
  shown.take(off);
  assert.equal(shown.contacts, 3);
  const at = shown.contact(2);
  assert.equal(shown.numbers[at + shown.columns.finger], 2);
  assert.equal(shown.numbers[at + shown.columns.control_point], 7);
  assert.equal(shown.numbers[at + shown.columns.force_N + 2], 0.3);
});

test('more contacts than there was room for', () => {
  const row = state(0).subarray(-11 * 8);
  const shown = new State(scene);
  shown.take(bytes(Buffer.concat([state(0), ...Array(500).fill(row)])));
  assert.equal(shown.contacts, 503);
  assert.equal(shown.numbers[shown.contact(502) + shown.columns.finger], 2);
  assert.equal(shown.values.margin[0], 0.6);
});

test('what is no state of this scene is refused, and the last one stays', () => {
  const shown = new State(scene);
  shown.take(bytes(state(0.25)));
  const broken = [
    Buffer.alloc(0), Buffer.from('THNR'), state(1).subarray(0, -1), state(1).subarray(0, -8), state(1).subarray(0, 800), geometry(),
  ];
  const version = Buffer.from(state(1));
  version[4] = 4;
  for (const message of [...broken, version]) assert.throws(() => shown.take(bytes(message)));
  assert.equal(shown.values.time_s[0], 0.25);
});

test('geometry has every point of object and pulps, and no number more', () => {
  const {object, fingers} = readGeometry(bytes(geometry()), scene);
  assert.equal(object.points.length, 3 * scene.object.samples);
  for (let i = 0; i < object.points.length; i += 3) {
    const n = object.normals.subarray(i, i + 3);
    const out = object.points.subarray(i, i + 3).reduce((sum, x, k) => sum + x * n[k], 0);
    assert.ok(Math.abs(out - 0.02) < 1e-8); // each sample lies on the face of its normal
  }
  // The areas of a sphere's cells sum to its area; float32 has 1e-7 of relative rounding, forty times.
  const area = 4 * Math.PI * 0.008 ** 2;
  for (const finger of fingers) assert.ok(Math.abs(finger.areas.reduce((a, b) => a + b) - area) < 4e-6 * area);
  assert.throws(() => readGeometry(bytes(geometry().subarray(0, -4)), scene));
  assert.throws(() => readGeometry(bytes(Buffer.concat([geometry(), Buffer.alloc(4)])), scene));
});

test('a grasp shows the first measure of each name that it has', () => {
  const measures = [{name: 'width_m', shown: 'width'}, {name: 'muscle_share', shown: 'effort'}, {name: 'torque_Nm', shown: 'effort'}];
  const names = (grasp) => shownMeasures(measures, grasp).map(({name}) => name);
  assert.deepEqual(names({width_m: 0.04, muscle_share: 0.3, torque_Nm: 0.1}), ['width_m', 'muscle_share']);
  assert.deepEqual(names({width_m: 0.04, muscle_share: null, torque_Nm: 0.1}), ['width_m', 'torque_Nm']);
});
