// SPDX-License-Identifier: Apache-2.0
// Jolt, of its own package jolt-physics, in single precision. Settings:
//   velocity_steps, position_steps   of its solver, 10 and 2 by default.
//   collision_steps                  Step()'s second argument: parts of a step, 1 by default.
//   penetration_slop, speculative_distance, manifold_tolerance   lengths [m], 20, 20 and 1 mm by default.
//   convex_radius                    how round the edges of boxes are [m], 50 mm by default. Larger ones are cut to the
//                                    box, so that a box of 40 mm is round like a ball where it is looked for contacts.
// Its manual ("Conventions and limits"): dynamic objects should be 0.1 to 10 m long; smaller ones are to be scaled. To
// scale them by 10 is to divide the lengths above by 10.

import {answer, cross, packageFile, times, worldOfBodies} from './peer.mjs';

const jolt = await (await import(packageFile('jolt-physics', 'dist', 'jolt-physics.wasm-compat.js'))).default();

const [STILL, MOVING] = [0, 1];  // Layers of objects.

const fromVector = (vector) => [vector.GetX(), vector.GetY(), vector.GetZ()];

/** Calls a function with vectors of the engine, which are freed after it. */
function withVectors(vectors, use) {
  const made = vectors.map((vector) => new jolt.Vec3(...vector));
  const result = use(...made);
  made.forEach((vector) => jolt.destroy(vector));
  return result;
}

/** What moves touches everything, what stands nothing that stands. */
function layers() {
  const settings = new jolt.JoltSettings();
  const pairs = new jolt.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(STILL, MOVING);
  pairs.EnableCollision(MOVING, MOVING);
  const broad = new jolt.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [STILL, MOVING]) {
    const broadLayer = new jolt.BroadPhaseLayer(layer);
    broad.MapObjectToBroadPhaseLayer(layer, broadLayer);
    jolt.destroy(broadLayer);
  }
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = broad;
  settings.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 2, pairs, 2);
  return settings;
}

/** A world without bodies; it owns the layers. */
function emptyWorld({setting}) {
  const init = layers();
  const world = new jolt.JoltInterface(init);
  jolt.destroy(init);
  const system = world.GetPhysicsSystem();
  withVectors([[0, 0, 0]], (none) => system.SetGravity(none));
  const settings = system.GetPhysicsSettings();
  settings.mAllowSleeping = false;
  if (setting.velocity_steps) settings.mNumVelocitySteps = setting.velocity_steps;
  if (setting.position_steps) settings.mNumPositionSteps = setting.position_steps;
  if (setting.penetration_slop) settings.mPenetrationSlop = setting.penetration_slop;
  if (setting.speculative_distance) settings.mSpeculativeContactDistance = setting.speculative_distance;
  if (setting.manifold_tolerance) settings.mManifoldTolerance = setting.manifold_tolerance;
  system.SetPhysicsSettings(settings);
  return world;
}

function shapeOf({kind, half}, setting) {
  if (kind === 'sphere') return new jolt.SphereShape(half[0]);
  if (kind === 'capsule') return new jolt.CapsuleShape(half[1], half[0]);
  return withVectors([half], (edges) => new jolt.BoxShape(edges, setting.convex_radius));
}

/** Adds a body; one with a mass moves. */
function addBody(world, data, {shape, at, attitude = [1, 0, 0, 0], mass, inertia, freedoms}) {
  const [w, ...axis] = attitude;
  const turned = new jolt.Quat(...axis, w);
  const motion = mass ? jolt.EMotionType_Dynamic : jolt.EMotionType_Static;
  const settings = withVectors(
    [at],
    (place) => new jolt.BodyCreationSettings(shape, place, turned, motion, mass ? MOVING : STILL),
  );
  jolt.destroy(turned);
  // Friction of a pair is the root of the product of the two.
  Object.assign(settings, {mFriction: data.friction, mRestitution: 0, mLinearDamping: 0, mAngularDamping: 0});
  if (mass) {
    settings.mOverrideMassProperties = jolt.EOverrideMassProperties_MassAndInertiaProvided;
    settings.mMassPropertiesOverride.mMass = mass;
    const matrix = withVectors([inertia], (diagonal) => jolt.Mat44.prototype.sScaleVec3(diagonal));
    settings.mMassPropertiesOverride.mInertia = matrix;
  }
  if (freedoms) settings.mAllowedDOFs = freedoms;
  const bodies = world.GetPhysicsSystem().GetBodyInterface();
  const body = bodies.CreateBody(settings);
  jolt.destroy(settings);
  bodies.AddBody(body.GetID(), jolt.EActivation_Activate);
  return body;
}

/** What worldOfBodies asks of a body. */
function bodyOf(body) {
  const vector = new jolt.Vec3(0, 0, 0);
  const set = ([x, y, z]) => {
    vector.Set(x, y, z);
    return vector;
  };
  return {
    place: () => fromVector(body.GetCenterOfMassPosition()),
    velocity: () => fromVector(body.GetLinearVelocity()),
    turning: () => fromVector(body.GetAngularVelocity()),
    attitude() {
      const rotation = body.GetRotation();
      return [rotation.GetW(), ...fromVector(rotation)];
    },
    push: (force) => body.AddForce(set(force)),
    twist: (moment) => body.AddTorque(set(moment)),
    free: () => jolt.destroy(vector),
  };
}

/** A slide along an axis of the world is a freedom of the body itself; another one is a constraint. */
function addFinger(world, data, {at, along, radius}) {
  const axes = [jolt.EAllowedDOFs_TranslationX, jolt.EAllowedDOFs_TranslationY, jolt.EAllowedDOFs_TranslationZ];
  const free = axes.filter((_, i) => Math.abs(along[i]) > 1e-9);
  const mass = data.finger_mass;
  const moment = 0.4 * mass * radius * radius;
  const body = addBody(world, data, {
    shape: new jolt.SphereShape(radius), at, mass, inertia: [moment, moment, moment],
    freedoms: free.reduce((all, axis) => all | axis),
  });
  if (free.length > 1) {
    const settings = new jolt.SliderConstraintSettings();
    settings.mAutoDetectPoint = true;
    const across = cross(along, along[2] ** 2 < 0.5 ? [0, 0, 1] : [1, 0, 0]);
    withVectors([along, times(across, 1 / Math.hypot(...across))], (slide, normal) => {
      settings.mSliderAxis1 = settings.mSliderAxis2 = slide;
      settings.mNormalAxis1 = settings.mNormalAxis2 = normal;
    });
    const ground = jolt.JoltInterface.prototype.sGetFixedToWorldBody();
    world.GetPhysicsSystem().AddConstraint(settings.Create(ground, body));
    jolt.destroy(settings);
  }
  return bodyOf(body);
}

function make(data) {
  const world = emptyWorld(data);
  for (const {at, half} of data.walls) {
    addBody(world, data, {shape: shapeOf({kind: 'box', half}, data.setting), at});
  }
  const fingers = data.fingers.map((finger) => addFinger(world, data, finger));
  const shape = shapeOf(data.shape, data.setting);
  const object = bodyOf(addBody(world, data, {...data, shape}));
  const parts = data.setting.collision_steps ?? 1;
  return worldOfBodies(data, object, fingers, {
    advance: () => world.Step(data.step, parts),
    free() {
      [object, ...fingers].forEach((body) => body.free());
      jolt.destroy(world);
    },
  });
}

await answer({name: 'Jolt (jolt-physics 1.1.0)', make});
