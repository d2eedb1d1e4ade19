// SPDX-License-Identifier: Apache-2.0
// A soft shadow of hand and object in the direction of gravity, on the bodies of the environment or on a floor below.

import {CircleGeometry, DirectionalLight, Group, Mesh, ShadowMaterial, Vector3} from 'three';

const kReach_m = 0.16; // of the shadow around what is looked at
const kHeight_m = 0.4; // of the light above
const kBelow_m = 6e-3; // of the floor below all that casts a shadow
const kShade = 0.26;

export class Ground extends Group {
  /** `texels`: of the shadow's map, along each side. */
  constructor(texels) {
    super();
    this.light = new DirectionalLight(0xffffff, 0.5);
    this.light.castShadow = true;
    const {camera, mapSize} = this.light.shadow;
    Object.assign(camera, {left: -kReach_m, right: kReach_m, top: kReach_m, bottom: -kReach_m, near: 0.05, far: 2 * kHeight_m});
    mapSize.set(texels, texels);
    this.light.shadow.radius = 5;
    this.floor = new Mesh(new CircleGeometry(kReach_m, 48), new ShadowMaterial({opacity: kShade}));
    this.floor.receiveShadow = true;
    this.add(this.light, this.light.target, this.floor);
  }

  /** `up`: unit; `places`: of all that casts a shadow; `centre`: of the object; `bodies`: whether others take the shadow. */
  place(up, places, centre, bodies) {
    this.light.target.position.copy(centre);
    this.light.position.copy(centre).addScaledVector(up, kHeight_m);
    this.floor.visible = !bodies;
    const lowest = Math.min(...places.map((place) => place.dot(up))) - kBelow_m;
    this.floor.position.copy(centre).addScaledVector(up, lowest - centre.dot(up));
    this.floor.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), up);
  }
}
