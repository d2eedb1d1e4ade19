// Jolt, of its own package jolt-physics, in single precision. Settings:
//   velocity_steps, position_steps   of its solver, 10 and 2 by default.
//   collision_steps                  Step()'s second argument: parts of a step, 1 by default.
//   penetration_slop, speculative_distance, manifold_tolerance   lengths [m], 20, 20 and 1 mm by default.
//   convex_radius                    of boxes [m]: 50 mm by default, which it cuts to the box.
// Its manual ("Conventions and limits"): dynamic objects should be 0.1 to 10 m long; those that are not are to be
// scaled.

import {answer, packageFile, worldOfBodies} from './peer.mjs';

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

/** Layers: what moves touches everything, what stands nothing that stands. */
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
