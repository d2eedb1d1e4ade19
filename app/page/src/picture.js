// SPDX-License-Identifier: Apache-2.0
// The picture: what a state looks like. It is drawn when something has changed, not otherwise.

import {Matrix4, PCFShadowMap, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

import {Bodies, Touches, bodyLabels, hasBodies} from './bodies.js';
import {Cells, cellsOf} from './cells.js';
import {Closeups, kPulpLayer} from './closeups.js';
import {niceAbove, themed} from './colors.js';
import {Ellipsoids, ellipsoidLabels} from './ellipsoids.js';
import {Forces} from './forces.js';
import {Gauge, gaugeLabels} from './gauge.js';
import {Ground} from './ground.js';
import {makeLabels, placeLabels} from './labels.js';
import {splitForce} from './messages.js';
import {angleBetween, setPose, vector} from './poses.js';
import {Pulp} from './pulp.js';
import {Muscles, Skeleton} from './skeleton.js';
import {hitSplats} from './splats.js';
import {hideBehind, makeObject} from './surface.js';
import {feels} from './touch.js';
import {Trail} from './trail.js';
import {addLamp, aimAt, backdrop, daylight, followLamp, isSoftware, placesOf, upward} from './view.js';

const kGhostFrom_m = 0.5e-3;
const kGhostFrom_rad = 1 * Math.PI / 180;
const kEnough = 40000; // splats
const kEnoughForGhost = 6000;
const kFrame_ms = 33;
const kLongest_ms = 2000; // of a drawing: graphics that say nothing were lost

export class Picture {
  options = {
    forces: true, cones: false, ghost: false, muscles: true, path: true, bodies: true, stiffness: true, turning: false, seeThrough: false, exaggeration: 1,
  };
  /** Called after a state was drawn. */
  onDrawn = () => {};
  /** Called in the task in which the canvas was drawn, so that its pixels can be read. */
  onPixels = () => {};
  alone = false; // nothing of the page is around it
  fullPressure_Pa = 20e3;
  fullActivation = 0.1; // of a muscle's strength
  #object = new Matrix4();
  #target = new Matrix4();
  #poses = [];
  #fresh = false;
  #wanted = false; // a drawing is asked for,
  #scheduled = false; // is soon begun,
  #drawing = false; // is under way
  #last_ms = 0;
  #pause_ms = kFrame_ms;
  #times_ms = [];
  #loaded = [];

  /** `overlay`: an element over the canvas, for labels; `insets`: one element a finger, where its pulp is shown. */
  constructor(canvas, overlay, insets) {
    this.canvas = canvas;
    this.overlay = overlay;
    this.insets = insets;
    this.software = isSoftware();
    this.renderer = new WebGLRenderer({canvas, antialias: !this.software, stencil: true, powerPreference: 'low-power'});
    this.renderer.autoClear = false;
    Object.assign(this.renderer.shadowMap, {enabled: true, type: PCFShadowMap});
    this.world = new Scene();
    this.above = new Scene(); // is drawn over the world, for forces act inside of things
    this.camera = new PerspectiveCamera(30, 1, 0.02, 3);
    for (const scene of [this.world, this.above]) scene.add(daylight());
    this.closeups = new Closeups(this.world, insets);
    this.lamp = addLamp(this.world);
    this.lampAbove = addLamp(this.above);
    this.ground = new Ground(this.software ? 256 : 1024);
    this.world.add(this.ground);
    this.gauge = new Gauge();
    this.above.add(this.gauge);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.request());
    this.labels = [];
    this.matchTheme();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.matchTheme());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  matchTheme() {
    this.world.background?.dispose();
    this.world.background = backdrop(themed('--sky'), themed('--picture'));
    this.object?.setColor(themed('--object'));
    this.skeleton?.setColors(themed('--bone'), themed('--skin'));
    this.bodies?.setColor(themed('--around'), themed('--around-edge'));
    this.request();
  }

  /** A new scene: its message and its geometry. The camera stays, unless this is the first one. */
  load(scene, geometry) {
    this.#unload();
    this.scene = scene;
    this.geometry = geometry;
    this.state = null; // nothing is drawn before its first state: what was seen stays
    this.#poses = scene.segments.map(() => new Matrix4());
    const tilted = !this.software;
    this.object = this.#keep(this.world, makeObject(scene, geometry, themed('--object'), {enough: kEnough, tilted}));
    this.ghost = this.#keep(this.world, makeObject(scene, geometry, themed('--ghost'),
                                                   {enough: kEnoughForGhost, opacity: 0.4, tilted}));
    hideBehind(this.object, this.ghost);
    for (const shown of [this.object, this.ghost]) shown.matrixAutoUpdate = false;
    this.skeleton = this.#keep(this.world, new Skeleton(scene, themed('--bone'), themed('--skin')));
    this.muscles = this.#keep(this.world, new Muscles(scene));
    this.bodies = this.#keep(this.world, new Bodies(scene));
    this.pulps = geometry.fingers.map((finger) => {
      if (finger.points.length === 0) return null;
      const pulp = this.#keep(this.world, new Pulp(finger));
      pulp.layers.enable(kPulpLayer);
      if (feels(scene)) pulp.add((pulp.cells = new Cells(finger, kPulpLayer)));
      return pulp;
    });
    for (const part of [this.object, ...this.pulps]) if (part) part.castShadow = true;
    this.insets.forEach((inset, k) => (inset.hidden = !this.pulps[k]));
    this.forces = this.#keep(this.above, new Forces(scene));
    this.touches = this.#keep(this.above, new Touches(scene));
    this.ellipsoids = this.#keep(this.above, new Ellipsoids(scene));
    this.trail = this.#keep(this.above, new Trail());
    this.overlay.replaceChildren();
    this.labels = makeLabels(this.overlay, [...scene.fingers.map(({name}) => name), ...bodyLabels(scene), ...ellipsoidLabels, 'pull']);
    this.gaugeLabels = makeLabels(this.overlay, gaugeLabels);
    this.#aimed = this.#aimed && this.aimedFor === scene.name;
    this.aimedFor = scene.name;
    this.resize();
  }

  #keep(parent, thing) {
    parent.add(thing);
    this.#loaded.push(thing);
    return thing;
  }

  #unload() {
    for (const thing of this.#loaded) {
      thing.removeFromParent();
      thing.traverse((part) => {
        part.geometry?.dispose();
        part.material?.dispose();
        part.dispose?.();
      });
    }
    this.#loaded = [];
  }

  /** Shows a state. */
  show(state) {
    this.state = state;
    const v = state.values;
    setPose(this.#object, v.object);
    setPose(this.#target, v.target);
    this.object.matrix.copy(this.#object);
    this.ghost.matrix.copy(this.#target);
    for (let s = 0; s < this.#poses.length; ++s) setPose(this.#poses[s], v.segments, 12 * s);
    this.skeleton.pose(this.#poses);
    this.#pullMuscles(v.muscles_N);
    this.trail.remember(v);
    if (!this.#aimed) this.aim();
    this.#fresh = true;
    this.update();
  }

  /** Applies the options to the state that is shown. */
  update() {
    if (!this.state) return;
    const v = this.state.values;
    const {options} = this;
    const apart = Math.hypot(v.object[0] - v.target[0], v.object[1] - v.target[1], v.object[2] - v.target[2]);
    this.ghost.visible = options.ghost || apart > kGhostFrom_m || angleBetween(this.#object, this.#target) > kGhostFrom_rad;
    this.muscles.visible = options.muscles;
    this.bodies.visible = options.bodies;
    this.bodies.show(v, this.#object);
    this.trail.visible = options.path && this.trail.count > 2;
    this.object.setOpacity(options.seeThrough ? 0.35 : 1);
    this.#movePulps(v);
    this.forces.show(this.state, options, this.labels);
    const fingers = this.scene.fingers.length;
    this.touches.show(v, options, this.labels.slice(fingers, -1 - ellipsoidLabels.length));
    this.ellipsoids.show(v, this.#object, options, this.labels.slice(-1 - ellipsoidLabels.length, -1));
    this.request();
  }

  #pullMuscles(force_N) {
    let most = 0;
    this.scene.muscles.forEach(({max_force_N}, m) => (most = Math.max(most, force_N[m] / max_force_N || 0)));
    this.fullActivation = Math.min(1, steadyScale(this.fullActivation, most, 0.05));
    this.muscles.pull(this.#poses, force_N, this.fullActivation);
  }

  #movePulps(v) {
    const {columns, numbers} = this.state;
    let most_Pa = 0;
    for (const pulp of this.pulps) pulp?.pressure_Pa.fill(0);
    for (let i = 0; i < this.state.contacts; ++i) {
      const at = this.state.contact(i);
      const pulp = this.pulps[numbers[at + columns.finger]];
      if (!pulp) continue;
      const control = numbers[at + columns.control_point];
      const {normal_N, share} = splitForce(this.state, at);
      // An edge has no end of pressure: it is told as the mean over a twentieth of a cell, at least.
      pulp.pressure_Pa[control] = Math.max(0, normal_N / (Math.max(0.05, share) * pulp.areas[control]));
      most_Pa = Math.max(most_Pa, pulp.pressure_Pa[control]);
    }
    this.fullPressure_Pa = steadyScale(this.fullPressure_Pa, most_Pa, 5e3);
    let u = 0;
    this.pulps.forEach((pulp, k) => {
      if (!pulp) return;
      const count = 3 * this.scene.fingers[k].controls;
      pulp.displace(v.displacement_m.subarray(u, u + count), this.options.exaggeration);
      pulp.paint(this.fullPressure_Pa);
      pulp.matrix.copy(this.#poses[this.scene.fingers[k].segment]);
      u += count;
    });
    if (feels(this.scene)) this.#showCells(v);
  }

  /** Shows which of the pulps' cells stick. */
  #showCells(v) {
    const begin = [];
    let u = 0;
    this.pulps.forEach((pulp, k) => {
      begin.push(u);
      u += 3 * this.scene.fingers[k].controls;
      pulp?.cells.clear();
    });
    for (const cell of cellsOf(this.state)) {
      const pulp = this.pulps[cell.finger];
      const normal = vector(this.state.numbers, cell.at).transformDirection(toPulp.copy(pulp.matrix).invert());
      pulp.cells.put(cell, v.displacement_m.subarray(begin[cell.finger]), this.options.exaggeration, normal);
    }
    for (const pulp of this.pulps) pulp?.cells.done();
  }

  /** Adds to the way of the object and its target; `v`: a state's values. */
  remember(v) {
    this.trail.remember(v);
  }

  clearTrail() {
    this.trail?.clear();
  }

  /** Shares of the view that other things cover: the small views at the right, buttons below. */
  #margins() {
    const {left, right, top, bottom} = this.canvas.getBoundingClientRect();
    const insets = this.insets.filter(({hidden}) => !hidden).map((inset) => inset.getBoundingClientRect().left);
    const covered = (px, whole) => Math.min(0.35, px / whole); // more is not left free
    const buttons = document.getElementById('views').getBoundingClientRect();
    return {left: 0.03, right: 0.03 + covered(right - Math.min(right, ...insets), right - left), top: 0.04,
            bottom: 0.04 + (buttons.height > 0 ? covered(bottom - buttons.top, bottom - top) : 0)};
  }

  /** The camera as at the start: the grip axis level and across, the whole hand and the object to be seen. */
  aim() {
    if (!this.state) return;
    const tips = this.scene.fingers.map(({segment, centre_m}) => vector(centre_m).applyMatrix4(this.#poses[segment]));
    const centre = new Vector3().setFromMatrixPosition(this.#object);
    const up = upward(this.scene);
    const places = placesOf(this.scene, this.#poses, this.geometry.object.points, this.#object);
    this.controls.target.copy(aimAt(this.camera, {tips, up, places, centre}, this.#margins()));
    this.ground.place(up, places, centre, hasBodies(this.scene));
    this.controls.update();
    this.camera.updateMatrixWorld(); // hands may reach for something before it is drawn
    this.#aimed = true;
    this.request();
  }
  #aimed = false;

  /** Draws soon: at most thirty times a second, and on a processor instead of a graphics card less than half of the time. */
  request() {
    this.#wanted = true;
    if (this.#scheduled || this.#drawing) return;
    this.#scheduled = true;
    const wait_ms = this.#last_ms + this.#pause_ms - performance.now();
    const draw = () => requestAnimationFrame(() => this.#draw());
    if (wait_ms > 8) setTimeout(draw, wait_ms - 8);
    else draw();
  }

  #draw() {
    this.#scheduled = this.#wanted = false;
    this.#drawing = true;
    const start_ms = performance.now();
    this.#last_ms = start_ms;
    this.draw();
    this.onPixels();
    this.#await(start_ms);
  }

  /** Draws at once. Its pixels can be read until the task ends. */
  draw() {
    if (!this.scene || !this.state) return;
    this.#render();
    placeLabels(this.labels, (point) => this.project(point));
    placeLabels(this.gaugeLabels, (point) => this.project(point));
  }

  /** A drawing is done when the graphics have done it, which this thread must not wait for: it has hands to serve. */
  #await(start_ms) {
    const gl = this.renderer.getContext();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      const late = performance.now() - start_ms > kLongest_ms;
      if (!late && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return setTimeout(look, 4);
      gl.deleteSync(fence);
      this.#finish(start_ms);
    };
    setTimeout(look, 2);
  }

  #finish(start_ms) {
    const end_ms = performance.now();
    this.#pause_ms = Math.max(kFrame_ms, this.software ? 2 * (end_ms - start_ms) : 0);
    this.#times_ms.push(end_ms);
    if (this.#times_ms.length > 30) this.#times_ms.shift();
    this.#drawing = false;
    if (this.#wanted) this.request();
    if (!this.#fresh) return;
    this.#fresh = false;
    this.onDrawn();
  }

  #render() {
    const {renderer, camera} = this;
    followLamp(this.lamp, camera);
    this.lampAbove.position.copy(this.lamp.position);
    this.bodies.face(camera);
    const down = vector(this.scene.gravity_m_per_s2).lengthSq() > 0 ? upward(this.scene).negate() : null;
    this.gauge.place(this, down, this.controls.target, this.gaugeLabels);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, this.width, this.height);
    renderer.clear();
    renderer.render(this.world, camera);
    renderer.clearDepth();
    renderer.render(this.above, camera);
    this.closeups.render(renderer, this.pulps, this.scene.fingers, this.state.values.normal);
  }

  resize() {
    const {clientWidth, clientHeight} = this.canvas.parentElement;
    if (clientWidth !== this.width || clientHeight !== this.height) {
      this.width = Math.max(1, clientWidth);
      this.height = Math.max(1, clientHeight);
      this.renderer.setPixelRatio(this.software ? 1 : Math.min(devicePixelRatio, 2));
      this.renderer.setSize(this.width, this.height, false); // which wipes it
    }
    this.camera.aspect = this.width / this.height;
    this.camera.updateProjectionMatrix();
    const pixels = this.height * this.renderer.getPixelRatio();
    for (const shown of [this.object, this.ghost]) shown?.fit(this.camera, pixels);
    this.closeups.resize(this.canvas.getBoundingClientRect());
    this.request();
  }

  get fps() {
    const times = this.#times_ms;
    return times.length < 2 ? 0 : (1e3 * (times.length - 1)) / (times.at(-1) - times[0]);
  }

  /** Where a world point [m] is, in pixels of the canvas. */
  project(point) {
    const p = new Vector3(...point).project(this.camera);
    return [(0.5 + 0.5 * p.x) * this.width, (0.5 - 0.5 * p.y) * this.height];
  }

  /** How far a pixel reaches at a world point, across the view [m]. */
  metresPerPixel(point) {
    const depth = -new Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse).z;
    return (2 * depth * Math.tan((this.camera.fov * Math.PI) / 360)) / this.height;
  }

  #ray(x, y) {
    raycaster.setFromCamera(pointer.set((2 * x) / this.width - 1, 1 - (2 * y) / this.height), this.camera);
    return raycaster.ray;
  }

  /** What of the object is under a pixel: {world, local}, the point in both frames [m], or null. */
  hitObject(x, y) {
    if (!this.state) return null;
    const ray = this.#ray(x, y);
    const before = raycaster.intersectObjects([this.skeleton, ...this.pulps.filter(Boolean)], true)[0];
    const local = ray.clone().applyMatrix4(this.#object.clone().invert());
    const {points, normals} = this.geometry.object;
    const hit = hitSplats(points, normals, this.scene.object.spacing_m, local.origin, local.direction);
    if (!hit || (before && before.distance < hit.distance)) return null;
    const point = local.at(hit.distance, new Vector3());
    return {local: point.clone(), world: point.applyMatrix4(this.#object)};
  }

  /** Where a pixel's ray meets the plane through a world point across the view. */
  onPlane(x, y, through) {
    const ray = this.#ray(x, y);
    const normal = this.camera.getWorldDirection(new Vector3());
    const distance = normal.dot(from.subVectors(through, ray.origin)) / normal.dot(ray.direction);
    return ray.at(distance, new Vector3());
  }

  /** The camera's axes in the world: right, up, away. */
  axes() {
    const {matrixWorld} = this.camera;
    const [right, up, back] = [0, 1, 2].map((i) => new Vector3().setFromMatrixColumn(matrixWorld, i));
    return {right, up, away: back.negate()};
  }
}

const from = new Vector3();
const toPulp = new Matrix4();
const pointer = new Vector2();
const raycaster = new Raycaster();

/** A scale's end, that grows at once and shrinks when a good part of it is not used. */
function steadyScale(full, most, least) {
  return most > full || most < 0.3 * full ? niceAbove(Math.max(most, least)) : full;
}
