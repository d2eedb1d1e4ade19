// SPDX-License-Identifier: Apache-2.0
// Bones, and muscles along them.

import {CapsuleGeometry, Color, Group, LatheGeometry, Matrix4, Mesh, MeshLambertMaterial, SphereGeometry, Vector2, Vector3}
    from 'three';

import {activationColor} from './colors.js';
import {rods} from './rods.js';

/** A bone along y: wider at its ends. */
function boneGeometry(length, radius) {
  const outline = [[0, -0.9], [0.55, -0.75], [0.95, -0.25], [1.0, 0.2], [0.72, 1.2]];
  const ends = [[0.66, length / radius / 2]];
  for (const [r, y] of [...outline].reverse()) ends.push([r * 0.92, length / radius - 0.85 * y]);
  const profile = [...outline, ...ends].filter(([, y], i, all) => i === 0 || y > all[i - 1][1]);
  return new LatheGeometry(profile.map(([r, y]) => new Vector2(r * radius, y * radius)), 18);
}

/** An ellipsoid, or a capsule along its first axis. */
function shapeGeometry({form, half_m: [a, b, c], axes}) {
  const turn = new Matrix4().makeBasis(...axes.map((axis) => new Vector3(...axis)));
  const geometry = form === 'capsule' ? new CapsuleGeometry(b, 2 * a, 12, 24).rotateZ(-Math.PI / 2)
                                      : new SphereGeometry(1, 24, 16).scale(a, b, c);
  return geometry.applyMatrix4(turn);
}

/** A fingertip of a `scene` message at rest, about its centre. */
export const pulpGeometry = ({shape, radius_m}) => (shape ? shapeGeometry(shape) : new SphereGeometry(radius_m, 24, 16));

export class Skeleton extends Group {
  /** `scene`: the message. */
  constructor(scene, color) {
    super();
    this.material = new MeshLambertMaterial({color});
    this.bones = scene.segments.map(({finger, length_m, joints}) => {
      if (joints === 0) return null;
      const bone = new Mesh(boneGeometry(length_m, 0.5 * scene.fingers[finger].radius_m).rotateZ(-Math.PI / 2),
                            this.material);
      bone.matrixAutoUpdate = false;
      bone.frustumCulled = false;
      this.add(bone);
      return bone;
    });
    for (const finger of scene.fingers) {
      if (finger.samples > 0) continue; // a pulp is drawn there
      const tip = new Mesh(pulpGeometry(finger), this.material);
      tip.position.fromArray(finger.centre_m);
      this.bones[finger.segment]?.add(tip);
    }
    this.metacarpals = [];
    if (scene.slides) return; // rods without a hand
    // From the wrist, the world's origin, to where each finger begins.
    this.metacarpals = scene.fingers.map(({radius_m}, finger) => {
      const bone = new Mesh(undefined, this.material);
      bone.userData = {radius: 0.5 * radius_m, first: scene.segments.findIndex((s) => s.finger === finger && s.joints > 0)};
      this.add(bone);
      return bone;
    });
    const wrist = Math.max(...scene.fingers.map(({radius_m}) => 0.75 * radius_m));
    this.add(new Mesh(new SphereGeometry(wrist, 24, 16), this.material));
  }

  /** `poses`: Matrix4 of every segment. */
  pose(poses) {
    this.bones.forEach((bone, i) => bone?.matrix.copy(poses[i]));
    for (const bone of this.metacarpals) this.#reach(bone, poses[bone.userData.first]);
  }

  /** The wrist does not move, and neither does where a finger begins: its bone is made once. */
  #reach(bone, pose) {
    if (bone.userData.done || !pose) return;
    const end = new Vector3().setFromMatrixPosition(pose);
    bone.geometry = boneGeometry(end.length(), bone.userData.radius);
    bone.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), end.normalize());
    bone.userData.done = true;
  }

  setColor(color) {
    this.material.color.set(color);
  }
}

const a = new Vector3();
const b = new Vector3();
const color = new Color();
const rgb = [0, 0, 0];

/** Muscles as cords: the harder one pulls, the thicker and redder it is. */
export class Muscles extends Group {
  constructor(scene) {
    super();
    this.muscles = scene.muscles;
    const lines = this.muscles.reduce((sum, {lines}) => sum + lines.length, 0);
    this.cords = rods(Math.max(1, lines));
    this.add(this.cords);
  }

  /** `full`: the share of a muscle's strength that has the last colour. */
  pull(poses, force_N, full) {
    this.cords.clear();
    this.muscles.forEach(({lines, max_force_N}, m) => {
      const share = Math.min(1, force_N[m] / max_force_N / full || 0);
      activationColor(share, rgb, 0);
      color.setRGB(...rgb);
      for (const [s, x, y, z, t, u, v, w] of lines) {
        this.cords.put(a.set(x, y, z).applyMatrix4(poses[s]), b.set(u, v, w).applyMatrix4(poses[t]),
                       4e-4 + 8e-4 * share, color);
      }
    });
    this.cords.done();
  }
}
