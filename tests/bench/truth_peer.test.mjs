// SPDX-License-Identifier: Apache-2.0
// The common part of the truth bench's programs in JavaScript, judged by closed forms through a tiny engine: one free
// body, whose speeds follow the wrench.

import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import test from 'node:test';

const peer = new URL('../../bench/truth/peers/peer.mjs', import.meta.url);

// It prints, as engines do, and its body turns about its own z axis at 3 rad/s.
const engine = `
  import {answer, worldOfBodies} from '${peer}';
  const body = (at, mass, step, attitude) => {
    const [place, velocity, pushed] = [[...at], [0, 0, 0], [0, 0, 0]];
    const [w, x, y, z] = attitude;
    const turning = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)].map((value) => 3 * value);
    return {
      place: () => place, velocity: () => velocity, attitude: () => attitude, turning: () => turning,
      push: (force) => force.forEach((value, i) => (pushed[i] = value)), twist() {},
      advance: () => place.forEach((_, i) => {
        velocity[i] += (step * pushed[i]) / mass;
        place[i] += step * velocity[i];
      }),
    };
  };
  const make = (data) => {
    console.log('what engines print');
    const object = body(data.at, data.mass, data.step, data.attitude);
    const fingers = data.fingers.map(({at}) => body(at, data.finger_mass, data.step, [1, 0, 0, 0]));
    const advance = () => [object, ...fingers].forEach((moved) => moved.advance());
    return worldOfBodies(data, object, fingers, {advance, free() {}});
  };
  await answer({name: 'tiny', make});`;

const world = {
  shape: {box: [0.01, 0.02, 0.03]}, mass: 0.3, friction: 0.5, step: 0.01, duration: 0.5, lost: 10,
  at: [0.1, 0, 0], attitude: [0.8, 0.36, -0.48, 0], fingers: [], walls: [], finger_mass: 0.05, finger_damping: 5,
  damping: 1, setting: {},
  loads: [{force: [0, 0.6, 0], moment: [0, 0, 0], times: [0.1, 0.3], factors: [0, 1]}],
};

/** What comes back for lines: {head, rows}. */
function answersTo(lines) {
  const input = lines.map((line) => `${line}\n`).join('');
  const {stdout} = spawnSync(process.execPath, ['--input-type=module', '-e', engine], {input});
  const answers = [];
  for (let at = 0; at < stdout.length; ) {
    const end = stdout.indexOf('\n', at);
    const head = JSON.parse(stdout.subarray(at, end));
    const size = 8 * (head.rows ?? 0) * (head.columns ?? 0);
    const bytes = new Uint8Array(stdout.subarray(end + 1, end + 1 + size));
    const values = new Float64Array(bytes.buffer);
    const {rows: length = 0, columns} = head;
    const rows = Array.from({length}, (_, i) => values.subarray(i * columns, (i + 1) * columns));
    answers.push({head, rows});
    at = end + 1 + size;
  }
  return answers;
}

function near(value, expected) {
  assert.ok(Math.abs(value - expected) <= 1e-12 + 1e-9 * Math.abs(expected), `${value} in place of ${expected}`);
}

test('a load follows its polygon, and what engines print is no answer', () => {
  const [{head, rows}] = answersTo([JSON.stringify(world)]);
  assert.deepEqual(head, {engine: 'tiny', rows: 50, columns: 11});
  // Factors of the steps that begin before 0.1 s are 0, then they rise by 1/20 a step to 1 at 0.3 s.
  let [speed, place] = [0, 0];
  for (let i = 0; i < 50; ++i) {
    const factor = Math.min(1, Math.max(0, (i - 10) / 20));
    speed += (0.01 * factor * 0.6) / 0.3;
    place += 0.01 * speed;
    near(rows[i][1], place);
    // A box of these half edges has the moment m / 3 (a^2 + b^2) about z.
    near(rows[i][7], 0.5 * 0.3 * speed * speed + 0.5 * (0.3 / 3) * (0.01 ** 2 + 0.02 ** 2) * 3 * 3);
  }
  assert.ok(Number.isNaN(rows[0][9]));
});

test('a body that is lost needs no further steps, and a line that is no world does not end the program', () => {
  const worlds = [{...world, shape: {cone: 1}}, {...world, lost: 0.02}];
  const [broken, strange, lost] = answersTo(['{', ...worlds.map((asked) => JSON.stringify(asked))]);
  assert.ok(broken.head.error);
  assert.match(strange.head.error, /cone/);
  const gone = lost.rows.map((row) => Math.hypot(row[0] - 0.1, row[1], row[2]) >= 0.02);
  assert.equal(gone.indexOf(true), lost.rows.length - 1);
  assert.ok(lost.rows.length < 50);
});

test('a finger is pressed along its slide, and its damping does not turn it round in a long step', () => {
  const finger = {at: [0, 0, 0], along: [0.6, 0.8, 0], radius: 0.008, force: 2};
  const asked = {...world, step: 1 / 60, duration: 1, fingers: [finger], finger_damping: 20};
  const [{rows}] = answersTo([JSON.stringify(asked)]);
  const travels = rows.map((row) => row[11]);
  assert.ok(travels.every((travel, i) => i === 0 || travel > travels[i - 1]));
});
