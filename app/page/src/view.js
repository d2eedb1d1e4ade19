// SPDX-License-Identifier: Apache-2.0
// From where a grasp is seen, and in which light.

import {CanvasTexture, DirectionalLight, HemisphereLight, SRGBColorSpace, Vector3} from 'three';

import {vector} from './poses.js';

const kTurn = 0.35, kRise = 0.5; // [rad]
const kAround_m = 8e-3; // around each point that is to be seen
const kObjectPoints = 400; // that stand for the object's surface
/** Shares of the view that stay free at its edges. */
const kMargins = {left: 0.03, right: 0.03, top: 0.03, bottom: 0.03};

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

/** Against gravity; z without any. */
export const upward = ({gravity_m_per_s2}) => {
  const up = vector(gravity_m_per_s2).negate();
  return up.lengthSq() > 0 ? up.normalize() : new Vector3(0, 0, 1);
};

/** World points of the whole hand and of the object. `hand`: fingers, segments, slides of a message; `poses`: of its segments; `points`: of the object's surface. */
export function placesOf(hand, poses, points, object) {
  const places = hand.slides ? [] : [new Vector3()]; // the wrist
  hand.segments.forEach(({length_m, joints}, s) => {
    if (joints > 0) places.push(new Vector3().applyMatrix4(poses[s]), new Vector3(length_m, 0, 0).applyMatrix4(poses[s]));
  });
  for (const {segment, centre_m} of hand.fingers) places.push(vector(centre_m).applyMatrix4(poses[segment]));
  const stride = 3 * Math.ceil(points.length / 3 / kObjectPoints);
  for (let i = 0; i < points.length; i += stride) places.push(vector(points, i).applyMatrix4(object));
  return places;
}

/** How far away an eye must at least be to see places between two slopes of its view, and where it then is across. */
function reach(across, depth, low, high) {
  const above = Math.max(...across.map((x, i) => x + high * depth[i]));
  const below = Math.max(...across.map((x, i) => low * depth[i] - x));
  return {least: (above + below) / (low + high), at: (distance) => (above - below + (low - high) * distance) / 2};
}

/**
 * Sets a camera so that the grip axis lies level and across, and all `places` are seen between `margins`, shares of the
 * view. `tips`: the fingertips' centres; `up`: unit; `centre`: of the object. All in the world. Returns what it looks at.
 */
export function aimAt(camera, {tips, up, places, centre}, margins = kMargins) {
  const grip = gripAxis(tips);
  const across = grip.addScaledVector(up, -grip.dot(up)).normalize();
  const level = across.clone().cross(up);
  const back = level.multiplyScalar(Math.cos(kTurn)).addScaledVector(across, Math.sin(kTurn))
      .multiplyScalar(Math.cos(kRise)).addScaledVector(up, Math.sin(kRise)).normalize();
  const right = up.clone().cross(back).normalize();
  const top = back.clone().cross(right);
  const along = (axis) => places.map((place) => place.dot(axis));
  const depth = along(back).map((z) => z + kAround_m);
  const slope = Math.tan((camera.fov * Math.PI) / 360);
  const wide = reach(along(right), depth, slope * camera.aspect * (1 - 2 * margins.left), slope * camera.aspect * (1 - 2 * margins.right));
  const high = reach(along(top), depth, slope * (1 - 2 * margins.bottom), slope * (1 - 2 * margins.top));
  const distance = Math.max(wide.least, high.least) + kAround_m / slope;
  camera.up.copy(up);
  camera.position.set(0, 0, 0).addScaledVector(right, wide.at(distance)).addScaledVector(top, high.at(distance)).addScaledVector(back, distance);
  const target = camera.position.clone().addScaledVector(back, centre.dot(back) - distance);
  camera.lookAt(target);
  return target;
}

/** The light from everywhere. */
export const daylight = () => new HemisphereLight(0xffffff, 0xb5afa8, 1.9);

/** A lamp that followLamp() keeps above the eye's left shoulder. */
export function addLamp(scene) {
  const lamp = new DirectionalLight(0xfff6e8, 1.5);
  scene.add(lamp, lamp.target);
  return lamp;
}

export function followLamp(lamp, camera) {
  lamp.position.set(-0.4, 0.7, 0.6).applyQuaternion(camera.quaternion);
}

/** A background that goes from a colour at the top to another at the bottom. */
export function backdrop(top, bottom) {
  const canvas = Object.assign(document.createElement('canvas'), {width: 1, height: 256});
  const context = canvas.getContext('2d');
  const gradient = context.createLinearGradient(0, 0, 0, canvas.height);
  gradient.addColorStop(0, top);
  gradient.addColorStop(1, bottom);
  context.fillStyle = gradient;
  context.fillRect(0, 0, 1, canvas.height);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
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
