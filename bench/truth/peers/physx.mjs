// SPDX-License-Identifier: Apache-2.0
// PhysX, of the package physx-js-webidl, in single precision. Settings:
//   tgs                                        1 for the solver TGS in place of PGS.
//   position_iterations, velocity_iterations   of the solver, 4 and 1 by default, 255 at most.
//   length                                     PxTolerancesScale::length [m], "the approximate size of objects", 1 by
//                                              default: contacts are looked for within 2 % of it.
// Its manual (PxFrictionType): PGS takes the two directions of friction one by one, TGS their combined impulse.

import {readFile} from 'node:fs/promises';

import {answer, attitudeAlong, packageFile, worldOfBodies} from './peer.mjs';

const physx = await load();
const foundation = physx.CreateFoundation(
  physx.PHYSICS_VERSION,
  new physx.PxDefaultAllocator(),
  new physx.PxDefaultErrorCallback(),
);
const dispatcher = physx.DefaultCpuDispatcherCreate(0);

/** The package is built for browsers alone: while it loads it sees the little that it asks of one, and no node. */
async function load() {
  globalThis.window = globalThis;
  globalThis.document = {currentScript: null};
  const versions = Object.getOwnPropertyDescriptor(process, 'versions');
  Object.defineProperty(process, 'versions', {...versions, value: {...process.versions, node: undefined}});
  try {
    const {default: create} = await import(packageFile('physx-js-webidl', 'physx-js-webidl.mjs'));
    return await create({wasmBinary: await readFile(packageFile('physx-js-webidl', 'physx-js-webidl.wasm'))});
  } finally {
    Object.defineProperty(process, 'versions', versions);
  }
}

const fromVector = ({x, y, z}) => [x, y, z];

/** Keeps what is made of the engine's own values, to be freed together. */
function store() {
  const kept = [];
  const keep = (value) => {
    kept.push(value);
    return value;
  };
  const vector = (a) => keep(new physx.PxVec3(...a));
  const pose = (at, [w, ...axis]) => keep(new physx.PxTransform(vector(at), keep(new physx.PxQuat(...axis, w))));
  return {keep, vector, pose, free: () => kept.reverse().forEach((value) => physx.destroy(value))};
}

function emptyScene({setting}, {keep, vector}) {
  const scale = keep(new physx.PxTolerancesScale());
  if (setting.length) scale.length = setting.length;
  const physics = physx.CreatePhysics(physx.PHYSICS_VERSION, foundation, scale);
  const description = keep(new physx.PxSceneDesc(scale));
  description.gravity = vector([0, 0, 0]);
  description.cpuDispatcher = dispatcher;
  description.filterShader = physx.DefaultFilterShader();
  if (setting.tgs) description.solverType = physx.PxSolverTypeEnum.eTGS;
  return {physics, scene: physics.createScene(description)};
}

/** Makes shapes of the world's friction. Friction of a pair is the mean of the two. */
function shapes(physics, friction, {keep}) {
  const material = physics.createMaterial(friction, friction, 0);
  const flags = keep(new physx.PxShapeFlags(physx.PxShapeFlagEnum.eSIMULATION_SHAPE));
  const all = keep(new physx.PxFilterData(1, 1, 0, 0));
  return (geometry) => {
    const shape = physics.createShape(keep(geometry), material, true, flags);
    shape.setSimulationFilterData(all);
    return shape;
  };
}

/** The object's shape; the axis of a capsule is x here. */
function shapeOf({kind, half}, shape, {pose}) {
  if (kind === 'sphere') return shape(new physx.PxSphereGeometry(half[0]));
  if (kind === 'box') return shape(new physx.PxBoxGeometry(...half));
  const capsule = shape(new physx.PxCapsuleGeometry(half[0], half[1]));
  capsule.setLocalPose(pose([0, 0, 0], attitudeAlong([0, 1, 0])));
  return capsule;
}

/** What worldOfBodies asks of a body. */
function bodyOf(body, {vector}) {
  const value = vector([0, 0, 0]);
  const set = (a) => {
    [value.x, value.y, value.z] = a;
    return value;
  };
  return {
    place: () => fromVector(body.getGlobalPose().p),
    velocity: () => fromVector(body.getLinearVelocity()),
    turning: () => fromVector(body.getAngularVelocity()),
    attitude() {
      const {w, x, y, z} = body.getGlobalPose().q;
      return [w, x, y, z];
    },
    push: (force) => body.addForce(set(force)),
    twist: (moment) => body.addTorque(set(moment)),
  };
}

function setIterations(solved, {position_iterations = 4, velocity_iterations = 1}) {
  solved.setSolverIterationCounts(position_iterations, velocity_iterations);
  solved.setSleepThreshold(0);
}

/** A finger is a robot of one link on a slide: its coordinate is reduced, so that no solver has to hold it there. */
function addFinger({physics, scene}, data, {at, along, radius}, shape, made) {
  const {pose, vector} = made;
  const robot = physics.createArticulationReducedCoordinate();
  robot.setArticulationFlag(physx.PxArticulationFlagEnum.eFIX_BASE, true);
  setIterations(robot, data.setting);
  const [start, middle] = [pose(at, attitudeAlong(along)), pose([0, 0, 0], [1, 0, 0, 0])];
  const base = robot.createLink(null, start);
  const link = robot.createLink(base, start);
  const moment = 0.4 * data.finger_mass * radius * radius;
  for (const part of [base, link]) {
    part.setMass(data.finger_mass);
    part.setMassSpaceInertiaTensor(vector([moment, moment, moment]));
    part.setAngularDamping(0);
  }
  link.attachShape(shape(new physx.PxSphereGeometry(radius)));
  const joint = physx.castObject(link.getInboundJoint(), physx.PxArticulationJointReducedCoordinate);
  joint.setJointType(physx.PxArticulationJointTypeEnum.ePRISMATIC);
  joint.setMotion(physx.PxArticulationAxisEnum.eX, physx.PxArticulationMotionEnum.eFREE);
  joint.setParentPose(middle);
  joint.setChildPose(middle);
  joint.setFrictionCoefficient(0);
  scene.addArticulation(robot);
  return bodyOf(link, made);
}

function addObject({physics, scene}, data, shape, made) {
  const object = physics.createRigidDynamic(made.pose(data.at, data.attitude));
  object.attachShape(shapeOf(data.shape, shape, made));
  object.setMass(data.mass);
  object.setMassSpaceInertiaTensor(made.vector(data.inertia));
  object.setAngularDamping(0);
  setIterations(object, data.setting);
  scene.addActor(object);
  return bodyOf(object, made);
}

function make(data) {
  const made = store();
  const world = emptyScene(data, made);
  const shape = shapes(world.physics, data.friction, made);
  for (const {at, half} of data.walls) {
    const wall = world.physics.createRigidStatic(made.pose(at, [1, 0, 0, 0]));
    wall.attachShape(shape(new physx.PxBoxGeometry(...half)));
    world.scene.addActor(wall);
  }
  const fingers = data.fingers.map((finger) => addFinger(world, data, finger, shape, made));
  const object = addObject(world, data, shape, made);
  return worldOfBodies(data, object, fingers, {
    advance() {
      world.scene.simulate(data.step);
      world.scene.fetchResults(true);
    },
    free() {
      world.scene.release();
      world.physics.release();
      made.free();
    },
  });
}

await answer({name: 'PhysX 5.6.1 (physx-js-webidl 2.7.3)', make});
