// SPDX-License-Identifier: Apache-2.0
// Small pictures of grasps that were found: the hand on the object, as it would begin.

import {Matrix4, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer} from 'three';

import {fingerColors, themed} from './colors.js';
import {setPose, vector} from './poses.js';
import {pulpGeometry, Skeleton} from './skeleton.js';
import {makeObject} from './surface.js';
import {addLamp, aimAt, backdrop, daylight, followLamp, isSoftware, placesOf, upward} from './view.js';

const kEnough = 12000; // splats

/** The hand with its fingertips at rest, in their fingers' colours, and the places of their centres. */
function handOf({fingers, segments, poses}) {
  const matrices = segments.map((_, s) => setPose(new Matrix4(), poses, 12 * s));
  const hand = new Skeleton({segments, fingers: fingers.map((finger) => ({...finger, samples: 1}))}, themed('--bone'), themed('--skin'));
  hand.pose(matrices);
  const tips = fingers.map((finger, k) => {
    const pulp = new Mesh(pulpGeometry(finger).translate(...finger.centre_m),
                          new MeshLambertMaterial({color: fingerColors[k]}));
    pulp.matrixAutoUpdate = false;
    pulp.matrix.copy(matrices[finger.segment]);
    hand.add(pulp);
    return vector(finger.centre_m).applyMatrix4(matrices[finger.segment]);
  });
  return {hand, tips, matrices};
}

function dispose(thing) {
  thing.traverse((part) => {
    part.geometry?.dispose();
    part.material?.dispose();
    part.dispose?.();
  });
}

/**
 * Draws grasps of a `grasps` message into canvases, one at a time, so that the page stays alive. `scene`, `geometry`: of the
 * object, as a picture takes them; `jobs`: [{canvas, grasp}]. Returns a function that ends it early.
 */
export function drawThumbnails(scene, geometry, jobs) {
  const software = isSoftware();
  const renderer = new WebGLRenderer({antialias: true, powerPreference: 'low-power'});
  const world = new Scene();
  world.background = backdrop(themed('--sky'), themed('--picture'));
  world.add(daylight());
  const lamp = addLamp(world);
  const camera = new PerspectiveCamera(30, 1, 0.02, 3);
  const object = makeObject(scene, geometry, themed('--object'), {enough: kEnough, tilted: !software});
  object.matrixAutoUpdate = false;
  world.add(object);
  let timer = 0;
  const end = () => {
    clearTimeout(timer);
    dispose(object);
    renderer.dispose();
    renderer.forceContextLoss();
  };
  const draw = ([job, ...others]) => {
    const {canvas, grasp} = job;
    renderer.setSize(canvas.width, canvas.height, false);
    camera.aspect = canvas.width / canvas.height;
    camera.updateProjectionMatrix();
    const {hand, tips, matrices} = handOf(grasp.hand);
    world.add(hand);
    setPose(object.matrix, grasp.object);
    const places = placesOf(grasp.hand, matrices, geometry.object.points, object.matrix);
    aimAt(camera, {tips, up: upward(scene), places, centre: new Vector3().setFromMatrixPosition(object.matrix)});
    camera.updateMatrixWorld();
    followLamp(lamp, camera);
    object.fit(camera, canvas.height);
    renderer.render(world, camera);
    canvas.getContext('2d').drawImage(renderer.domElement, 0, 0); // in the same task: its pixels are gone afterwards
    hand.removeFromParent();
    dispose(hand);
    if (others.length > 0) timer = setTimeout(draw, 10, others);
    else end();
  };
  if (jobs.length > 0) timer = setTimeout(draw, 0, jobs);
  else end();
  return end;
}
