// SPDX-License-Identifier: Apache-2.0
// From where a grasp is seen, and in which light.

import {DirectionalLight, HemisphereLight, Vector3} from 'three';

const kTurn = 0.35, kRise = 0.5; // [rad]
const kRadius_m = 0.088; // of what is to be seen, at least,
const kAround_m = 0.05; // and around an object that is away from the hand

const mean = (points) => points.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(points.length);

/** From the fingertip that is farthest from the others, as a thumb is, to the middle of these; some axis of one alone. */
function gripAxis(tips) {
  let grip = new Vector3();
  for (const tip of tips) {
    const others = tips.filter((other) => other !== tip);
    if (others.length === 0) continue;
    const way = mean(others).sub(tip);
    if (way.lengthSq() > grip.lengthSq()) grip = way;
  }
  return grip.lengthSq() > 0 ? grip : new Vector3(1, 0, 0);
}

/**
 * Sets a camera so that the grip axis lies level and across, and both fingers and the top of the object are seen. `tips`: the
 * fingertips' centres; `gravity`: as the scene has it; `centre`: of the object. All in the world. Returns what it looks at.
 */
export function aimAt(camera, tips, gravity, centre) {
  const up = gravity.lengthSq() > 0 ? gravity.clone().normalize().negate() : new Vector3(0, 0, 1);
  const grip = gripAxis(tips);
  const across = grip.addScaledVector(up, -grip.dot(up)).normalize();
  const level = across.clone().cross(up);
  const eye = level.multiplyScalar(Math.cos(kTurn)).addScaledVector(across, Math.sin(kTurn))
      .multiplyScalar(Math.cos(kRise)).addScaledVector(up, Math.sin(kRise));
  // A little towards the hand, of which most should be seen.
  const middle = mean(tips);
  const seen_m = Math.max(kRadius_m, 0.55 * centre.distanceTo(middle) + kAround_m);
  middle.lerp(new Vector3(), 0.35);
  const target = centre.clone().lerp(middle, 0.45);
  const radius = seen_m / Math.min(1, 1.15 * camera.aspect);
  camera.up.copy(up);
  camera.position.copy(target).addScaledVector(eye, radius / Math.sin((camera.fov * Math.PI) / 360));
  return target;
}

/** The light from everywhere. */
export const daylight = () => new HemisphereLight(0xffffff, 0xa8a098, 1.75);

/** A lamp that followLamp() keeps above the eye's left shoulder. */
export function addLamp(scene) {
  const lamp = new DirectionalLight(0xffffff, 1.6);
  scene.add(lamp, lamp.target);
  return lamp;
}

export function followLamp(lamp, camera) {
  lamp.position.set(-0.4, 0.7, 0.6).applyQuaternion(camera.quaternion);
}

/** Whether the processor draws, for lack of a graphics card. */
export function isSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return true;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|softpipe/i.test(name);
}
