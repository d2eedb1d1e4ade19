// SPDX-License-Identifier: Apache-2.0
// The current MuJoCo, of Google DeepMind's own package @mujoco/mujoco, in double precision; mujoco.cpp asks Debian's.
// Settings are the attributes of <option>, and cone: 1 for an elliptic one. Its manual's advice, "Preventing slip" in
// the chapter on modeling: an elliptic cone, a larger impratio, then noslip_iterations.

import {answer, kineticEnergy, packageFile} from './peer.mjs';

const mujoco = await (await import(packageFile('@mujoco', 'mujoco', 'mujoco.js'))).default();

function optionsOf(data) {
  const options = Object.entries(data.setting).map(([name, value]) =>
    name === 'cone' ? "cone='elliptic'" : `${name}='${value}'`,
  );
  return [`timestep='${data.step}'`, ...options].join(' ');
}

const geomOf = {
  sphere: ([radius]) => `type='sphere' size='${radius}'`,
  box: (half) => `type='box' size='${half.join(' ')}'`,
  capsule: ([radius, half]) => `type='capsule' size='${radius} ${half}' euler='90 0 0'`,
};

function modelOf(data) {
  const walls = data.walls.map(
    ({at, half}) => `<geom type='box' size='${half.join(' ')}' pos='${at.join(' ')}'/>`,
  );
  const fingers = data.fingers.map(
    ({at, along, radius}) => `<body pos='${at.join(' ')}'>
      <joint type='slide' axis='${along.join(' ')}' damping='${data.finger_damping}'/>
      <geom type='sphere' size='${radius}' mass='${data.finger_mass}'/></body>`,
  );
  // Where two geoms meet, the larger friction counts.
  return `<mujoco><option gravity='0 0 0' ${optionsOf(data)}/>
    <default><geom friction='${data.friction} 0.005 0.0001'/></default>
    <worldbody>${walls.join('')}${fingers.join('')}
      <body name='object' pos='${data.at.join(' ')}' quat='${data.attitude.join(' ')}'><freejoint/>
        <inertial pos='0 0 0' mass='${data.mass}' diaginertia='${data.inertia.join(' ')}'/>
        <geom ${geomOf[data.shape.kind](data.shape.half)}/></body></worldbody></mujoco>`;
}

function make(data) {
  const model = mujoco.MjModel.from_xml_string(modelOf(data));
  const state = new mujoco.MjData(model);
  // Views of the engine's memory, which a step does not move.
  const {qpos, qvel, qfrc_applied: pressed, xfrc_applied: pushed} = state;
  const fingers = data.fingers.length;
  const object = fingers + 1;
  return {
    step(force, moment) {
      data.fingers.forEach((finger, k) => (pressed[k] = finger.force));
      pushed.set([...force, ...moment], 6 * object);
      mujoco.mj_step(model, state);
    },
    read() {
      const [x, y, z, ...attitude] = qpos.subarray(fingers);
      const [vx, vy, vz, ...turning] = qvel.subarray(fingers);
      const kinetic = kineticEnergy(data, [vx, vy, vz], turning, [...qvel.subarray(0, fingers)]);
      return {at: [x, y, z], attitude, kinetic, contacts: state.ncon};
    },
    travel: (k) => qpos[k],
    free() {
      state.delete();
      model.delete();
    },
  };
}

await answer({name: `MuJoCo ${mujoco.mj_versionString()}`, make});
