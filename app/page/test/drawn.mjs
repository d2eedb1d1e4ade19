// SPDX-License-Identifier: Apache-2.0
// The 3-D topics of a recording, drawn by what their schemas say alone: entities in their frames, nothing of Thenar's own.
//     node drawn.mjs THENAR CONFIGS [PICTURE.png [RECORDING.mcap]]

import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';

import {McapIndexedReader} from '@mcap/core';
import {build} from 'esbuild';
import {decompress} from 'fzstd';

import {findChromium, openBrowser} from './browser.mjs';

const [program, configs, picture, given] = process.argv.slice(2);
findChromium();

/** The last message of each 3-D topic and all entities by topic and id: {transforms, entities}. */
async function shownAtEnd(bytes) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
  const decompressHandlers = {zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size)))};
  const reader = await McapIndexedReader.Initialize({readable, decompressHandlers});
  const frames = new Map();
  const entities = new Map();
  for await (const {channelId, data} of reader.readMessages()) {
    const {topic, schemaId} = reader.channelsById.get(channelId);
    const schema = reader.schemasById.get(schemaId).name;
    if (!['foxglove.SceneUpdate', 'foxglove.FrameTransforms'].includes(schema)) continue;
    const message = JSON.parse(new TextDecoder().decode(data));
    for (const transform of message.transforms ?? []) frames.set(transform.child_frame_id, transform);
    for (const {type, id} of message.deletions ?? []) {
      for (const key of [...entities.keys()]) {
        if (key.startsWith(`${topic} `) && (type === 1 || key === `${topic} ${id}`)) entities.delete(key);
      }
    }
    for (const entity of message.entities ?? []) entities.set(`${topic} ${entity.id}`, entity);
  }
  return {transforms: [...frames.values()], entities: [...entities.values()]};
}

/** In the browser: draws it, and says where on the screen the object's frame is. */
const kDrawing = `
import * as THREE from 'three';

window.draw = ({transforms, entities}) => {
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setSize(innerWidth, innerHeight);
  document.body.append(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(1, 1, 1);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8899aa, 1.8));
  const sun = new THREE.DirectionalLight(0xffffff, 0.9);
  sun.position.set(1, 2, 3);
  scene.add(sun);
  const frames = new Map([['world', scene]]);
  const waiting = [...transforms];
  for (const {parent_frame_id, child_frame_id, translation: t, rotation: q} of waiting) {
    const frame = new THREE.Group();
    frame.position.set(t.x, t.y, t.z);
    frame.quaternion.set(q.x, q.y, q.z, q.w);
    frames.get(parent_frame_id).add(frame);
    frames.set(child_frame_id, frame);
  }
  const material = ({r, g, b, a}) => new THREE.MeshLambertMaterial(
      {color: new THREE.Color(r, g, b), transparent: a < 1, opacity: a, depthWrite: a === 1, side: THREE.DoubleSide});
  const posed = (object, {position: p, orientation: q}) => {
    object.position.set(p.x, p.y, p.z);
    object.quaternion.set(q.x, q.y, q.z, q.w);
    return object;
  };
  for (const entity of entities) {
    const frame = frames.get(entity.frame_id);
    for (const {pose, size, color} of entity.spheres) {
      const ball = new THREE.SphereGeometry(0.5, 32, 24).scale(size.x, size.y, size.z);
      frame.add(posed(new THREE.Mesh(ball, material(color)), pose));
    }
    for (const {pose, size, bottom_scale, top_scale, color} of entity.cylinders) {
      const rod = new THREE.CylinderGeometry(0.5 * top_scale, 0.5 * bottom_scale, 1, 32).rotateX(Math.PI / 2);
      frame.add(posed(new THREE.Mesh(rod.scale(size.x, size.y, size.z), material(color)), pose));
    }
    for (const {pose, shaft_length: l, shaft_diameter: d, head_length: hl, head_diameter: hd, color} of entity.arrows) {
      const arrow = new THREE.Group();
      const shaft = new THREE.CylinderGeometry(d / 2, d / 2, l, 16).rotateZ(-Math.PI / 2).translate(l / 2, 0, 0);
      const head = new THREE.ConeGeometry(hd / 2, hl, 16).rotateZ(-Math.PI / 2).translate(l + hl / 2, 0, 0);
      for (const part of [shaft, head]) arrow.add(new THREE.Mesh(part, material(color)));
      frame.add(posed(arrow, pose));
    }
    for (const {pose, points, indices, color} of entity.triangles) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.Float32BufferAttribute(points.flatMap(({x, y, z}) => [x, y, z]), 3));
      geometry.setIndex(indices);
      geometry.computeVertexNormals();
      frame.add(posed(new THREE.Mesh(geometry, material(color)), pose));
    }
  }
  scene.updateMatrixWorld(true);
  const centre = new THREE.Vector3().setFromMatrixPosition(frames.get('object').matrixWorld);
  const camera = new THREE.PerspectiveCamera(30, innerWidth / innerHeight, 0.01, 10);
  camera.position.copy(centre).add(new THREE.Vector3(0.16, 0.16, 0.12));
  camera.up.set(0, 0, 1);
  camera.lookAt(centre.clone().add(new THREE.Vector3(-0.02, 0, -0.01)));
  // Which colours there are, by hue, without what is translucent, which blends with all that is behind it.
  const translucent = [];
  scene.traverse((part) => part.material?.transparent && translucent.push(part));
  const show = (shown) => {
    for (const part of translucent) part.visible = shown;
    renderer.render(scene, camera);
  };
  show(false);
  const gl = renderer.getContext();
  const pixels = new Uint8Array(4 * innerWidth * innerHeight);
  gl.readPixels(0, 0, innerWidth, innerHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const seen = {red: 0, yellow: 0, blue: 0, drawn: 0};
  for (let i = 0; i < pixels.length; i += 4) {
    const [r, g, b] = pixels.subarray(i, i + 3);
    if (r + g + b < 740) ++seen.drawn;
    if (r > 1.5 * g && r > 1.5 * b) ++seen.red;
    if (r > 2 * b && g > 1.4 * b) ++seen.yellow;
    if (b > 1.5 * r) ++seen.blue;
  }
  show(true);
  return seen;
};
`;

test('viewers that know the schemas draw the hand, the object, its forces and pressures', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'thenar-drawn-'));
  try {
    const film = given ?? join(folder, 'film.mcap');
    if (!given) execFileSync(program, ['run', join(configs, 'box_grasp.yaml'), '--quiet', '--time', '0.6 s', '--record', film]);
    const shown = await shownAtEnd(await readFile(film));
    const here = dirname(fileURLToPath(import.meta.url));
    const bundle = await build({stdin: {contents: kDrawing, resolveDir: here}, bundle: true, write: false, format: 'iife'});
    const page = join(folder, 'drawn.html');
    await writeFile(page, `<!doctype html><body style="margin:0"><script>${
        bundle.outputFiles[0].text.replaceAll('</script', '<\\/script')}</script>`);
    const browser = await openBrowser({width: 1000, height: 750});
    try {
      await browser.page.goto(pathToFileURL(page).href);
      const seen = await browser.page.evaluate((what) => window.draw(what), shown);
      if (picture) await browser.page.screenshot({path: picture});
      assert.deepEqual(browser.problems, []);
      // The fingers' arrows are blue, contacts' red, pressed points from yellow to red; bones and box fill the picture.
      assert.ok(seen.drawn > 15_000, `${seen.drawn} pixels are drawn`);
      for (const colour of ['red', 'yellow', 'blue']) assert.ok(seen[colour] > 100, `${seen[colour]} pixels are ${colour}: ${JSON.stringify(seen)}`);
    } finally {
      await browser.close();
    }
  } finally {
    await rm(folder, {recursive: true, force: true});
  }
});
