// SPDX-License-Identifier: Apache-2.0
// Reads the messages of docs/reference/window.md. Where a number lies is told by the scene's tables, not by this file.

const kMagic = 0x524e4854; // "THNR", little-endian
const kHeader = 8;
export const kVersion = 3;
const kOldest = 1; // of recordings: the object's surface came later
export const kGeometry = 1;
export const kState = 2;

/** Whether messages of a version are read here. */
export const isRead = (version) => version >= kOldest && version <= kVersion;

/** The kind of a binary message; throws if it is none, or of another version. `bytes` is a Uint8Array. */
export function kindOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.byteLength < kHeader || view.getUint32(0, true) !== kMagic) throw new Error('no message of thenar');
  const version = view.getUint16(4, true);
  if (!isRead(version)) throw new Error(`message version ${version}, this page reads ${kOldest} to ${kVersion}: reload it`);
  return view.getUint16(6, true);
}

/** The numbers behind a message's header, copied, so that they are aligned. */
function body(bytes, kind, Numbers) {
  if (kindOf(bytes) !== kind) throw new Error(`message of kind ${kindOf(bytes)} where ${kind} is due`);
  if ((bytes.byteLength - kHeader) % Numbers.BYTES_PER_ELEMENT !== 0) throw new Error('a message was cut off');
  return new Numbers(bytes.slice(kHeader).buffer);
}

/**
 * Points and normals of the object, and of every finger its pulp: Float32Arrays, three numbers a point [m]. The object's
 * surface, if there is one, has `vertices`, likewise, and `triangles`, three numbers of vertices each.
 */
export function readGeometry(bytes, scene) {
  const numbers = body(bytes, kGeometry, Float32Array);
  let at = 0;
  const take = (count) => numbers.subarray(at, (at += count));
  const object = {points: take(3 * scene.object.samples), normals: take(3 * scene.object.samples)};
  const fingers = scene.fingers.map(({samples, controls}) => ({
    points: take(3 * samples),
    normals: take(3 * samples),
    controls: take(3 * controls),
    areas: take(controls),
  }));
  const {vertices = 0, triangles = 0} = scene.object;
  object.vertices = take(3 * vertices);
  const begin = at;
  at += 3 * triangles;
  if (at !== numbers.length) throw new Error(`geometry of ${numbers.length} numbers where the scene has ${at}`);
  object.triangles = new Uint32Array(numbers.buffer, 4 * begin, 3 * triangles);
  if (object.triangles.some((vertex) => vertex >= vertices)) throw new Error('a triangle of a vertex that is not there');
  return {object, fingers};
}

// What recordings made before 0.8 call it.
const kOldNames = {
  force_n_N: 'normal_N', force_t_N: 'tangential_N', desired_n_N: 'desired_normal_N', desired_t_N: 'desired_tangential_N',
};

const end = (fields) => Math.max(0, ...fields.map(({begin, count}) => begin + count));

/** A contact's normal force and friction, and the part of its cell that it stands for. `at`: where its row begins. */
export function splitForce({columns, numbers}, at) {
  if ('normal_N' in columns) {
    return {normal_N: numbers[at + columns.normal_N], friction_N: numbers[at + columns.friction_N], share: numbers[at + columns.share]};
  }
  const f = at + columns.force_N;
  const n = at + columns.normal;
  const normal_N = numbers[f] * numbers[n] + numbers[f + 1] * numbers[n + 1] + numbers[f + 2] * numbers[n + 2];
  const square = numbers[f] ** 2 + numbers[f + 1] ** 2 + numbers[f + 2] ** 2;
  return {normal_N, friction_N: Math.sqrt(Math.max(0, square - normal_N ** 2)), share: 1};
}

/**
 * The newest state. Its memory is taken once: `values.<field>` are views of it, which the next state overwrites.
 * Of contact i, field `name` begins at numbers[state.contact(i) + state.columns.<name>].
 */
export class State {
  constructor(scene) {
    this.fields = scene.fields;
    this.fixed = end(scene.fields);
    this.row = end(scene.contact_fields);
    this.columns = Object.fromEntries(scene.contact_fields.map(({name, begin}) => [name, begin]));
    this.contacts = 0;
    this.reserve(this.fixed + 64 * this.row);
  }

  reserve(count) {
    this.numbers = new Float64Array(count);
    this.bytes = new Uint8Array(this.numbers.buffer);
    this.values = Object.fromEntries(
        this.fields.map(({name, begin, count: n}) => [kOldNames[name] ?? name, this.numbers.subarray(begin, begin + n)]));
  }

  /** Takes a state message; throws, and keeps the last one, if it is none of this scene. */
  take(bytes) {
    if (kindOf(bytes) !== kState) throw new Error(`message of kind ${kindOf(bytes)} where a state is due`);
    const count = (bytes.byteLength - kHeader) / 8;
    const contacts = this.row > 0 ? (count - this.fixed) / this.row : 0;
    if (!Number.isInteger(contacts) || contacts < 0 || count !== this.fixed + contacts * this.row) {
      throw new Error(`a state of ${count} numbers where the scene has ${this.fixed} and ${this.row} a contact`);
    }
    if (count > this.numbers.length) this.reserve(2 * count);
    this.bytes.set(bytes.subarray(kHeader));
    this.contacts = contacts;
  }

  contact(i) {
    return this.fixed + i * this.row;
  }
}

/** The measures that a grasp has: of those that are shown by one name the first. */
export function shownMeasures(measures, grasp) {
  const first = new Map();
  for (const measure of measures) {
    if (grasp[measure.name] !== null && !first.has(measure.shown)) first.set(measure.shown, measure);
  }
  return [...first.values()];
}
