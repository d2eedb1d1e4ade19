// SPDX-License-Identifier: Apache-2.0
// Bones, and muscles along them.

import {
  BufferGeometry, CapsuleGeometry, Color, Group, LatheGeometry, Matrix4, Mesh, MeshLambertMaterial, SphereGeometry, Vector2, Vector3,
} from 'three';
import {ConvexGeometry} from 'three/addons/geometries/ConvexGeometry.js';
import {mergeVertices} from 'three/addons/utils/BufferGeometryUtils.js';

import {activationColor} from './colors.js';
import {rods} from './rods.js';

const kShaft = 0.5, kSkin = 0.9, kDistalSkin = 0.72, kWrist = 1.2; // of a fingertip's radius
const kGlass = 0.3; // opacity of the skin

/** A bone along y, with round ends that are wider than its shaft; the joint with the bone before it lies in y = 0. */
function boneGeometry(length, radius) {
  const outline = [];
  const end = 1.15 * radius; // radius of the balls
  for (let i = 0; i <= 8; ++i) outline.push([end * Math.sin((Math.PI * i) / 12), -end * Math.cos((Math.PI * i) / 12)]);
  for (const [share, width] of [[0.3, 0.78], [0.5, 0.7], [0.7, 0.74]]) outline.push([width * radius, share * length]);
  for (let i = 8; i >= 0; --i) outline.push([0.9 * end * Math.sin((Math.PI * i) / 12), length + 0.9 * end * (Math.cos((Math.PI * i) / 12) - 1)]);
  const profile = outline.filter(([, y], i) => outline.slice(0, i).every(([, before]) => y > before));
  return new LatheGeometry(profile.map(([r, y]) => new Vector2(r, y)), 18);
}

/** What spheres {at, radius} span, as a smooth surface. */
function hull(spheres) {
  const unit = new SphereGeometry(1, 16, 10).attributes.position;
  const points = spheres.flatMap(({at, radius}) => Array.from({length: unit.count}, (_, i) =>
    new Vector3().fromBufferAttribute(unit, i).multiplyScalar(radius).add(at)));
  const {position} = new ConvexGeometry(points).attributes;
  const merged = mergeVertices(new BufferGeometry().setAttribute('position', position), 1e-6);
  merged.computeVertexNormals();
  return merged;
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

/** Bones of a hand in a translucent skin. */
export class Skeleton extends Group {
  /** `hand`: fingers, segments and slides, as a `scene` message has them. */
  constructor(hand, color, skinColor) {
    super();
    this.material = new MeshLambertMaterial({color});
    // As of the object seen through, a first pass leaves the nearest faces, so that overlapping parts are one layer.
    this.skin = new MeshLambertMaterial({color: skinColor, transparent: true, opacity: kGlass});
    this.skinDepth = new MeshLambertMaterial({colorWrite: false, transparent: true});
    this.bones = hand.segments.map(({finger, length_m, joints}, s) => {
      if (joints === 0) return null;
      const {radius_m, segment} = hand.fingers[finger];
      const bone = this.#add(new Mesh(boneGeometry(length_m, kShaft * radius_m).rotateZ(-Math.PI / 2), this.material));
      const radius = (s === segment ? kDistalSkin : kSkin) * radius_m; // there the pulp is around it
      this.#cover(bone, new CapsuleGeometry(radius, length_m, 8, 18).translate(0, length_m / 2, 0).rotateZ(-Math.PI / 2));
      bone.matrixAutoUpdate = false;
      return bone;
    });
    for (const finger of hand.fingers) {
      if (finger.samples > 0) continue; // a pulp is drawn there
      const tip = new Mesh(pulpGeometry(finger), this.material);
      tip.position.fromArray(finger.centre_m);
      this.bones[finger.segment]?.add(tip);
    }
    if (!hand.slides) this.palmOf = hand; // else rods without a palm
  }

  #add(mesh, parent = this) {
    mesh.frustumCulled = false;
    parent.add(mesh);
    return mesh;
  }

  /** Skin of this shape around a part. */
  #cover(part, geometry) {
    const layers = [this.skinDepth, this.skin].map((material) => this.#add(new Mesh(geometry, material), part));
    layers[0].castShadow = true;
    layers.forEach((layer, i) => Object.assign(layer, {renderOrder: 5 + i, raycast() {}})); // hands reach through it
  }

  /** `poses`: Matrix4 of every segment. */
  pose(poses) {
    this.bones.forEach((bone, i) => bone?.matrix.copy(poses[i]));
    if (this.palmOf) this.#addPalm(this.palmOf, poses);
    this.palmOf = null;
  }

  /** Bones from the wrist, the world's origin, to where each finger begins, and the palm around them: these do not move. */
  #addPalm({fingers, segments}, poses) {
    const bases = fingers.map(({radius_m}, finger) => {
      const first = segments.findIndex((segment) => segment.finger === finger && segment.joints > 0);
      return {at: new Vector3().setFromMatrixPosition(poses[first]), radius: kSkin * radius_m};
    });
    for (const {at, radius} of bases) {
      const bone = this.#add(new Mesh(boneGeometry(at.length(), (kShaft / kSkin) * radius), this.material));
      bone.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), at.clone().normalize());
    }
    const wrist = {at: new Vector3(), radius: kWrist * Math.max(...bases.map(({radius}) => radius))};
    this.#cover(this, hull([wrist, ...bases]));
  }

  setColors(color, skinColor) {
    this.material.color.set(color);
    this.skin.color.set(skinColor);
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
