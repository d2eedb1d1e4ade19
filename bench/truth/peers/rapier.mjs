// SPDX-License-Identifier: Apache-2.0
// Rapier, of its own package @dimforge/rapier3d-compat, in single precision. Settings:
//   length_unit         lengthUnit [m], the size of usual objects: lengths that it allows (a gap of 2 cm is a contact
//                       to come, 1 mm of depth is left) are so many of these. Its default is 1.
//   solver_iterations   numSolverIterations, 4 by default: parts of a step. With 12 it creeps three times as fast here,
//                       so that no setting of peers.json takes more.
//   internal_iterations numInternalPgsIterations in each of those, 1 by default.
// Friction of rigid bodies is its "simplified" model: one force for the contacts between two faces.

import {answer, packageFile, worldOfBodies} from './peer.mjs';

const rapier = (await import(packageFile('@dimforge', 'rapier3d-compat', 'dist', 'rapier.mjs'))).default;
await rapier.init();

const toVector = ([x, y, z]) => ({x, y, z});
const toQuaternion = ([w, x, y, z]) => ({w, x, y, z});
const fromVector = ({x, y, z}) => [x, y, z];

const colliderOf = {
  sphere: ([radius]) => rapier.ColliderDesc.ball(radius),
  box: (half) => rapier.ColliderDesc.cuboid(...half),
  capsule: ([radius, half]) => rapier.ColliderDesc.capsule(half, radius),
};

function emptyWorld(data) {
  const world = new rapier.World(toVector([0, 0, 0]));
  world.timestep = data.step;
  const {length_unit, solver_iterations, internal_iterations} = data.setting;
  if (length_unit) world.lengthUnit = length_unit;
  if (solver_iterations) world.numSolverIterations = solver_iterations;
  if (internal_iterations) world.numInternalPgsIterations = internal_iterations;
  return world;
}

/** What worldOfBodies asks of a body. Forces stay until they are reset. */
const bodyOf = (body) => ({
  place: () => fromVector(body.translation()),
  velocity: () => fromVector(body.linvel()),
  turning: () => fromVector(body.angvel()),
  attitude() {
    const {w, x, y, z} = body.rotation();
    return [w, x, y, z];
  },
  push(force) {
    body.resetForces(true);
    body.addForce(toVector(force), true);
  },
  twist(moment) {
    body.resetTorques(true);
    body.addTorque(toVector(moment), true);
  },
});

/** A slide along an axis of the world is locked by the body itself; another one is a joint. */
function addFinger(world, data, finger, material) {
  const description = rapier.RigidBodyDesc.dynamic().setTranslation(...finger.at).setCanSleep(false).lockRotations();
  const free = finger.along.map((value) => Math.abs(value) > 1e-9);
  const body = world.createRigidBody(description.enabledTranslations(...free));
  world.createCollider(material(rapier.ColliderDesc.ball(finger.radius)).setMass(data.finger_mass), body);
  if (free.filter(Boolean).length > 1) {
    const ground = world.createRigidBody(rapier.RigidBodyDesc.fixed().setTranslation(...finger.at));
    const middle = toVector([0, 0, 0]);
    world.createImpulseJoint(rapier.JointData.prismatic(middle, middle, toVector(finger.along)), ground, body, true);
  }
  return bodyOf(body);
}

/** How many points of contact its solver had. */
function countContacts(world, collider) {
  let found = 0;
  world.contactPairsWith(collider, (other) => {
    world.contactPair(collider, other, (manifold) => (found += manifold.numSolverContacts()));
  });
  return found;
}

function make(data) {
  const world = emptyWorld(data);
  // Friction of a pair is the mean of the two.
  const material = (collider) => collider.setFriction(data.friction).setRestitution(0);
  for (const {at, half} of data.walls) {
    world.createCollider(material(rapier.ColliderDesc.cuboid(...half)).setTranslation(...at));
  }
  const fingers = data.fingers.map((finger) => addFinger(world, data, finger, material));
  const description = rapier.RigidBodyDesc.dynamic().setTranslation(...data.at).setCanSleep(false);
  const object = world.createRigidBody(description.setRotation(toQuaternion(data.attitude)));
  const still = toQuaternion([1, 0, 0, 0]);
  const shape = material(colliderOf[data.shape.kind](data.shape.half));
  shape.setMassProperties(data.mass, toVector([0, 0, 0]), toVector(data.inertia), still);
  const collider = world.createCollider(shape, object);
  return worldOfBodies(data, bodyOf(object), fingers, {
    advance: () => world.step(),
    contacts: () => countContacts(world, collider),
    free: () => world.free(),
  });
}

await answer({name: `Rapier ${rapier.version()}`, make});
