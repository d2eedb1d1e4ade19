// SPDX-License-Identifier: Apache-2.0
// Each pulp as the object sees it, in small views over the picture.

import {DirectionalLight, OrthographicCamera, Vector3} from 'three';

import {vector} from './poses.js';

export const kPulpLayer = 1; // what the small views show

const kWhole = 1.08; // of a pulp's reach: all of it is seen,
const kPatch = 0.78; // or, with cells, where it may be pressed

const from = new Vector3();

export class Closeups {
  boxes = [];

  /** `world`: a scene whose lights so far light these views, too. `insets`: one element a finger. */
  constructor(world, insets) {
    this.world = world;
    this.insets = insets;
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -0.1, 0.1);
    this.camera.layers.set(kPulpLayer);
    world.traverse((light) => light.isLight && light.layers.enable(kPulpLayer));
    this.lamp = new DirectionalLight(0xffffff, 1.3);
    this.lamp.layers.set(kPulpLayer);
    this.lamp.visible = false;
    world.add(this.lamp, this.lamp.target);
  }

  /** Where the insets are; `canvas`: its box. */
  resize(canvas) {
    this.boxes = this.insets.map((inset) => {
      const box = inset.getBoundingClientRect();
      return {x: box.left - canvas.left, y: canvas.bottom - box.bottom, width: box.width, height: box.height};
    });
  }

  /** `fingers`: of the scene's message; `normals`: three numbers a finger, into the object. */
  render(renderer, pulps, fingers, normals) {
    this.lamp.visible = true;
    renderer.setScissorTest(true);
    pulps.forEach((pulp, k) => {
      const box = this.boxes[k];
      if (!pulp || !box || box.width === 0) return;
      for (const other of pulps) if (other) other.visible = other === pulp;
      this.#aim(pulp, fingers[k], vector(normals, 3 * k), box);
      renderer.setViewport(box.x, box.y, box.width, box.height);
      renderer.setScissor(box.x, box.y, box.width, box.height);
      renderer.clear();
      renderer.render(this.world, this.camera);
    });
    for (const pulp of pulps) if (pulp) pulp.visible = true;
    renderer.setScissorTest(false);
    this.lamp.visible = false;
  }

  #aim(pulp, {centre_m, radius_m, shape}, normal, box) {
    const {camera} = this;
    const centre = vector(centre_m).applyMatrix4(pulp.matrix);
    if (!(normal.lengthSq() > 0)) normal.setFromMatrixColumn(pulp.matrix, 1); // palmar
    camera.up.setFromMatrixColumn(pulp.matrix, 0); // the finger's tip is up
    camera.position.copy(centre);
    camera.lookAt(from.copy(centre).sub(normal));
    const reach_m = !shape ? radius_m
        : shape.form === 'capsule' ? shape.half_m[0] + shape.half_m[1] : Math.max(...shape.half_m);
    const half = (pulp.cells ? kPatch : kWhole) * reach_m;
    camera.left = -half * box.width / box.height;
    camera.right = -camera.left;
    camera.top = half;
    camera.bottom = -half;
    camera.updateProjectionMatrix();
    this.lamp.position.set(-0.5, 0.8, 1).applyQuaternion(camera.quaternion);
  }
}
