// SPDX-License-Identifier: Apache-2.0
// A small made-up grasp in the format of docs/reference/window.md, and a recording of it.

const kFields = [
  ['time_s', 1], ['tick', 1], ['frame', 1], ['held', 1], ['object', 12], ['target', 12], ['q_rad', 12], ['segments', 48],
  ['force_N', 9], ['desired_N', 9], ['centre_m', 9], ['normal', 9], ['normal_N', 3], ['tangential_N', 3],
  ['desired_normal_N', 3], ['desired_tangential_N', 3], ['margin', 3], ['slip_m', 3], ['start_slip_m', 3], ['spin_rad', 3],
  ['start_spin_rad', 3], ['sliding_share', 3], ['creep_m_per_s', 3], ['friction', 1], ['position_m', 3], ['path_target_m', 3], ['rotation_error_rad', 1],
  ['muscles_N', 2], ['pull_anchor_m', 3], ['pull_handle_m', 3], ['pull_force_N', 3], ['contacts', 1], ['active', 1],
  ['sweeps', 1], ['residual', 1], ['penetration_m', 1], ['frame_age_s', 1], ['grasp_failed', 1], ['muscles_failed', 1],
  ['find_us', 1], ['factors_us', 1], ['grasp_us', 1], ['muscle_us', 1], ['assemble_us', 1], ['solve_us', 1], ['deform_us', 1],
  ['contact_Hz', 1], ['contact_compute_us', 3], ['contact_jitter_us', 3], ['contact_overruns', 1], ['contact_slipped', 1],
  ['control_Hz', 1], ['control_compute_us', 3], ['control_slipped', 1], ['realtime_factor', 1], ['drive_J', 1],
  ['viscous_J', 1], ['deformation_J', 1], ['stored_J', 1], ['injected_J', 1], ['dissipated_J', 1], ['dropped_J', 1], ['unaccounted', 1], ['lost_records', 1], ['reference_error', 1], ['reference_residual', 1], ['latency_us', 3],
  ['latency_counts', 24], ['displacement_m', 3 * 3 * 40],
];
const kContactFields = [['finger', 1], ['control_point', 1], ['point_m', 3], ['normal', 3], ['force_N', 3]];
const kTips = [[-0.02, 0, 0], [0.02, 0.01, 0], [0.02, -0.01, 0]]; // on the faces of a box of 40 mm
const kRadius_m = 0.008;

function table(fields) {
  let begin = 0;
  return fields.map(([name, count]) => ({name, unit: '', begin: (begin += count) - count, count}));
}

/** Points spread evenly over a sphere, as numbers. */
function sphere(count, radius) {
  return Array.from({length: count}, (_, i) => {
    const z = 1 - (2 * i + 1) / count;
    const angle = i * Math.PI * (3 - Math.sqrt(5));
    const r = Math.sqrt(1 - z * z);
    return [radius * r * Math.cos(angle), radius * r * Math.sin(angle), radius * z];
  }).flat();
}

const kSamples = 200, kControls = 40, kObject = 24 * 24 * 6;

export const scene = {
  type: 'scene', version: 1, program: 'thenar test', name: 'made-up grasp', live: false,
  fields: table(kFields), contact_fields: table(kContactFields),
  fingers: ['thumb', 'index', 'major'].map((name, k) => (
    {name, segment: k + 1, centre_m: [0.014, 0.001, 0], radius_m: kRadius_m, samples: kSamples, controls: kControls})),
  segments: [{name: 'palm', finger: 0, length_m: 0, joints: 0},
             ...[0, 1, 2].map((finger) => ({name: `distal ${finger}`, finger, length_m: 0.02, joints: 4}))],
  muscles: ['A', 'B'].map((name, m) => ({name, max_force_N: 100, lines: [[m + 1, 0, 0.005, 0, 0, -0.05, 0, 0.03 * m]]})),
  object: {samples: kObject, spacing_m: 0.04 / 24, mass_kg: 0.1},
  start: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1],
  gravity_m_per_s2: [0, 0, -9.81], step_s: 1e-3, control_period_s: 1e-3, duration_s: 1,
  position_gain_N_per_m: 300, rotation_gain_Nm_per_rad: 0.5, pull: {stiffness_N_per_m: 100, limit_N: 2},
};

export const status = {
  type: 'status', running: false, paused: false, speed: 1, outcome: 'held', reason: '', note: null, scheduling: '',
  settings: {friction: 0.8, internal_force_N: 2, max_sweeps: 60, tolerance: 1e-7, contact_Hz: 4000, control_Hz: 200,
             delay_periods: 0, kernel: 'boussinesq', level: 0},
};

function message(kind, numbers) {
  const header = Buffer.alloc(8);
  header.write('THNR', 'latin1');
  header.writeUInt16LE(1, 4);
  header.writeUInt16LE(kind, 6);
  return Buffer.concat([header, Buffer.from(numbers.buffer, numbers.byteOffset, numbers.byteLength)]);
}

export function geometry() {
  const points = [], normals = [];
  for (let face = 0; face < 6; ++face) {
    for (let i = 0; i < 24; ++i) {
      for (let j = 0; j < 24; ++j) {
        const axis = face >> 1, sign = face % 2 ? 1 : -1;
        const at = [0, 0, 0], n = [0, 0, 0];
        at[axis] = 0.02 * sign;
        at[(axis + 1) % 3] = -0.02 + (0.04 * (i + 0.5)) / 24;
        at[(axis + 2) % 3] = -0.02 + (0.04 * (j + 0.5)) / 24;
        n[axis] = sign;
        points.push(...at);
        normals.push(...n);
      }
    }
  }
  const shifted = (numbers) => numbers.map((x, i) => x + [0.014, 0.001, 0][i % 3]);
  const area = (4 * Math.PI * kRadius_m ** 2) / kControls;
  const finger = [...shifted(sphere(kSamples, kRadius_m)), ...sphere(kSamples, 1), ...shifted(sphere(kControls, kRadius_m)),
                  ...Array(kControls).fill(area)];
  return message(1, new Float32Array([...points, ...normals, ...finger, ...finger, ...finger]));
}

export const kTetrahedron = {vertices: [0, 0, 0, 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01], triangles: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]};

/** Scene and geometry with a surface of the object. */
export function withSurface({vertices, triangles}) {
  const object = {...scene.object, vertices: vertices.length / 3, triangles: triangles.length / 3};
  const message = Buffer.concat([geometry(), Buffer.from(Float32Array.from(vertices).buffer), Buffer.from(Uint32Array.from(triangles).buffer)]);
  message.writeUInt16LE(2, 4);
  return {scene: {...scene, version: 2, object}, geometry: message};
}

/** The state of a time, with three contacts; the box moves along y. */
export function state(time_s) {
  const y = 0.01 * time_s;
  const values = {
    time_s: [time_s], tick: [1000 * time_s], object: [0, y, 0, ...scene.start.slice(3)],
    target: [0, y + 1e-4, 0, ...scene.start.slice(3)],
    segments: [...scene.start, ...kTips.flatMap(([x, dy, z]) =>
        [x + Math.sign(x) * 0.009, y + dy - 0.014, z, 0, -Math.sign(x), 0, 1, 0, 0, 0, 0, 1])],
    force_N: kTips.flatMap(([x]) => [-Math.sign(x), 0, 0.3]), centre_m: kTips.flatMap(([x, dy, z]) => [x, y + dy, z]),
    normal: kTips.flatMap(([x]) => [-Math.sign(x), 0, 0]), normal_N: [1, 1, 1], tangential_N: [0.3, 0.3, 0.3],
    desired_normal_N: [1.1, 1.1, 1.1], desired_tangential_N: [0.3, 0.3, 0.3], margin: [0.6, 0.6, 0.05], slip_m: [0, 1e-6, 2e-4], spin_rad: [0, 0.01, 0.3], sliding_share: [0, 0.1, 0.9], friction: [0.8],
    position_m: [0, y, 0], path_target_m: [0, y + 1e-4, 0], muscles_N: [3, 8], contacts: [3], active: [3],
    displacement_m: Array.from({length: 360}, (_, i) => 1e-4 * Math.sin(i)),
  };
  const numbers = [];
  for (const [name, count] of kFields) numbers.push(...(values[name] ?? Array(count).fill(/_Hz|_us|_s$|_m$/.test(name) ? NaN : 0)));
  kTips.forEach(([x, dy, z], k) => numbers.push(k, 7, x, y + dy, z, -Math.sign(x), 0, 0, -Math.sign(x), 0, 0.3));
  return message(2, new Float64Array(numbers));
}

function record(opcode, content) {
  const header = Buffer.alloc(9);
  header[0] = opcode;
  header.writeBigUInt64LE(BigInt(content.length), 1);
  return Buffer.concat([header, content]);
}

const u16 = (x) => Buffer.from(Uint16Array.of(x).buffer);
const u32 = (x) => Buffer.from(Uint32Array.of(x).buffer);
const u64 = (x) => Buffer.from(BigUint64Array.of(BigInt(x)).buffer);
const text = (x) => Buffer.concat([u32(Buffer.byteLength(x)), Buffer.from(x)]);
const kMagic = Buffer.from('\x89MCAP0\r\n', 'latin1');
const kTopics = ['/scene', '/geometry', '/status', '/state'];

/** The file of a recording, with a status behind the last state if one is given: {bytes, ends}, where `ends` are the places behind its message records. */
export function recording(states, lastStatus = null) {
  const parts = [kMagic, record(1, Buffer.concat([text(''), text('test')]))];
  kTopics.forEach((topic, id) => parts.push(record(4, Buffer.concat([u16(id), u16(0), text(topic), text('json'), u32(0)]))));
  const messages = [[0, 0, Buffer.from(JSON.stringify(scene))], [1, 0, geometry()], [2, 0, Buffer.from(JSON.stringify(status))]];
  for (let i = 0; i < states; ++i) messages.push([3, i / 30, state(i / 30)]);
  if (lastStatus) messages.push([2, states / 30, Buffer.from(JSON.stringify(lastStatus))]);
  const ends = [];
  let size = parts.reduce((sum, {length}) => sum + length, 0);
  messages.forEach(([channel, time_s, data], i) => {
    const time_ns = u64(Math.round(1e9 * time_s));
    parts.push(record(5, Buffer.concat([u16(channel), u32(i), time_ns, time_ns, data])));
    ends.push((size += parts.at(-1).length));
  });
  parts.push(record(15, u32(0)), record(2, Buffer.concat([u64(0), u64(0), u32(0)])), kMagic);
  return {bytes: Buffer.concat(parts), ends};
}
