// SPDX-License-Identifier: Apache-2.0
// What the programs of engines in WebAssembly have in common, as peer.h and peer.cpp are for those in C++:
// bench/truth/truth.py hands each of them worlds, and reads what became of the object. This file knows no engine, and
// no engine's file knows a task. Usage of each: node ENGINE.mjs NODE_MODULES, worlds as lines on standard input.
//
// A world has no gravity: all that acts on the object beside its contacts is a wrench at its centre of mass. Its data
// are those of the line, in SI units, quaternions as w, x, y, z, with the shape as {kind, half} and the object's
// moments of inertia added.

import {createInterface} from 'node:readline';
import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

// Standard output is for answers alone: what engines print goes where people read it.
console.log = console.error;

const modules = resolve(process.argv[2] ?? 'node_modules');

/** The address of a file of a package. */
export const packageFile = (...parts) => pathToFileURL(join(modules, ...parts));

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const minus = (a, b) => a.map((value, i) => value - b[i]);
export const times = (a, factor) => a.map((value) => value * factor);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** A vector of the world in the axes of a body of this attitude. */
function inAxesOf([w, ...axis], vector) {
  const turned = times(cross(vector, axis), 2);
  const again = cross(turned, axis);
  return vector.map((value, i) => value + w * turned[i] + again[i]);
}

/** The attitude that takes the axis x to this direction, of length 1. */
export function attitudeAlong(direction) {
  const half = [1 + direction[0], 0, -direction[2], direction[1]];
  const length = Math.hypot(...half);
  return length < 1e-9 ? [0, 0, 0, 1] : times(half, 1 / length);
}

/** Half of each edge of a box; of a sphere the radius; of a capsule about y the radius and half of its axis. */
function shapeOf(shape) {
  const [kind, size] = Object.entries(shape)[0];
  if (kind === 'sphere') return {kind, half: [size, size, size]};
  if (kind === 'box') return {kind, half: size};
  if (kind === 'capsule') return {kind, half: [size[0], size[1], size[0]]};
  throw new Error(`no shape ${kind} here`);
}

/** The moments of inertia of a solid of this shape about its axes [kg m^2]. */
function inertiaOf({kind, half: [a, b, c]}, mass) {
  if (kind === 'sphere') return [0.4 * mass * a * a, 0.4 * mass * a * a, 0.4 * mass * a * a];
  if (kind === 'capsule') {
    // A cylinder of the radius a and the length 2 b, and a ball in two halves at its ends.
    const ball = (mass * (4 / 3) * a) / ((4 / 3) * a + 2 * b);
    const rod = mass - ball;
    const along = 0.5 * rod * a * a + 0.4 * ball * a * a;
    const across = rod * (0.25 * a * a + (b * b) / 3) + ball * (0.4 * a * a + b * b + 0.75 * a * b);
    return [across, along, across];
  }
  return [(mass / 3) * (b * b + c * c), (mass / 3) * (a * a + c * c), (mass / 3) * (a * a + b * b)];
}

function dataOf(asked) {
  const shape = shapeOf(asked.shape);
  return {...asked, shape, inertia: inertiaOf(shape, asked.mass)};
}

/** Kinetic energy [J] of the object, its turning about its own axes, and of the fingers by their speeds. */
export function kineticEnergy(data, velocity, turning, speeds) {
  const fingers = speeds.reduce((sum, speed) => sum + data.finger_mass * speed * speed, 0);
  const turned = turning.reduce((sum, rate, i) => sum + data.inertia[i] * rate * rate, 0);
  return 0.5 * (data.mass * dot(velocity, velocity) + turned + fingers);
}

/**
 * A world of an engine that knows no joint with damping: the user presses fingers by forces, each step anew. Object
 * and fingers have place(), attitude(), velocity(), turning() and push(force); the object has twist(moment), too.
 * Slides are damped by a force against the speed that the finger will have by the damping alone: a force against the
 * present one turns light fingers round within a long step.
 */
export function worldOfBodies(data, object, fingers, {advance, contacts = () => NaN, free}) {
  const damping = data.finger_damping / (1 + (data.step * data.finger_damping) / data.finger_mass);
  return {
    step(force, moment) {
      object.push(force);
      object.twist(moment);
      fingers.forEach((finger, k) => {
        const {along, force: press} = data.fingers[k];
        finger.push(times(along, press - damping * dot(finger.velocity(), along)));
      });
      advance();
    },
    read() {
      const attitude = object.attitude();
      const speeds = fingers.map((finger) => Math.hypot(...finger.velocity()));
      const kinetic = kineticEnergy(data, object.velocity(), inAxesOf(attitude, object.turning()), speeds);
      return {at: object.place(), attitude, kinetic, contacts: contacts()};
    },
    travel: (k) => dot(minus(fingers[k].place(), data.fingers[k].at), data.fingers[k].along),
    free,
  };
}

/** The factor of a load, which follows a polygon in time. */
function factorAt(load, time) {
  const next = load.times.findIndex((other) => other > time);
  if (next === 0) return load.factors[0];
  if (next < 0) return load.factors.at(-1);
  const share = (time - load.times[next - 1]) / (load.times[next] - load.times[next - 1]);
  return load.factors[next - 1] + share * (load.factors[next] - load.factors[next - 1]);
}

function wrenchAt(loads, time) {
  const force = [0, 0, 0];
  const moment = [0, 0, 0];
  for (const load of loads) {
    const factor = factorAt(load, time);
    for (let i = 0; i < 3; ++i) {
      force[i] += factor * load.force[i];
      moment[i] += factor * load.moment[i];
    }
  }
  return [force, moment];
}

/**
 * Runs a world and returns its rows: place, attitude, kinetic and stored energy, contacts, the time that the step took
 * [us], and how far each finger has gone.
 */
function rowsOf(engine, data) {
  const steps = Math.round(data.duration / data.step);
  const world = engine.make(data);
  const rows = [];
  try {
    for (let i = 0; i < steps; ++i) {
      const [force, moment] = wrenchAt(data.loads, i * data.step);
      const from = performance.now();
      world.step(force, moment);
      const us = 1e3 * (performance.now() - from);
      const {at, attitude, kinetic, contacts} = world.read();
      rows.push(...at, ...attitude, kinetic, 0, contacts, us, ...data.fingers.map((_, k) => world.travel(k)));
      // What has fallen away, or is no number, needs no further steps.
      if (!(Math.hypot(...minus(at, data.at)) < data.lost)) break;
    }
  } finally {
    world.free();
  }
  return rows;
}

function answerTo(engine, line) {
  try {
    const data = dataOf(JSON.parse(line));
    const rows = new Float64Array(rowsOf(engine, data));
    const columns = 11 + data.fingers.length;
    const head = JSON.stringify({engine: engine.name, rows: rows.length / columns, columns});
    return Buffer.concat([Buffer.from(`${head}\n`), Buffer.from(rows.buffer)]);
  } catch (error) {
    return Buffer.from(`${JSON.stringify({error: String(error.message ?? error)})}\n`);
  }
}

/**
 * Answers each line of standard input, a world as JSON, by a line {"engine", "rows", "columns"} and the rows as
 * doubles, or by a line {"error"}. An engine has a `name` and make(data), which builds a world of these functions:
 *   step(force, moment)  Advances by a step under this wrench on the object, world axes, and the fingers' forces. All
 *                        that an engine has to do for it is in here: this is what is timed.
 *   read()               {at, attitude, kinetic, contacts}; contacts are NaN where an engine does not tell.
 *   travel(finger)       How far a finger has gone along its slide [m].
 *   free()               Gives its memory back, which WebAssembly does not do by itself.
 */
export async function answer(engine) {
  for await (const line of createInterface({input: process.stdin})) {
    await new Promise((written) => process.stdout.write(answerTo(engine, line), written));
  }
}
