// The picture: what a state looks like. It is drawn when something has changed, not otherwise.

import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DynamicDrawUsage, HemisphereLight, Matrix4, OrthographicCamera,
  PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

import {fingerColors, niceAbove, themed} from './colors.js';
import {Pulp} from './pulp.js';
import {Arrows, Coil, cones} from './rods.js';
import {Muscles, Skeleton} from './skeleton.js';
import {Splats, hitSplats, thinned} from './splats.js';

const kFinger_m_per_N = 10e-3; // of the arrows
const kContact_m_per_N = 40e-3;
const kGhostFrom_m = 0.5e-3;
const kGhostBehind_m = 0.4e-3; // so that the object shows where both nearly are
const kGhostFrom_rad = 1 * Math.PI / 180;
const kEnough = 40000; // splats
const kEnoughForGhost = 6000;
const kTrail = 600; // points of the path,
const kTrailStep_m = 0.1e-3; // no nearer to each other than this
const kSlipping = 0.5; // so much of a patch slides
const kPulpLayer = 1; // what the small views show
const kFrame_ms = 33;
const kLongest_ms = 2000; // of a drawing: graphics that say nothing were lost

const vector = (numbers, at = 0) => new Vector3(numbers[at], numbers[at + 1], numbers[at + 2]);
const isFinite3 = (numbers) => Number.isFinite(numbers[0] + numbers[1] + numbers[2]);

/** A pose of a message: position, then rotation by rows. */
function setPose(matrix, n, at = 0) {
  return matrix.set(n[at + 3], n[at + 4], n[at + 5], n[at], n[at + 6], n[at + 7], n[at + 8], n[at + 1],
                    n[at + 9], n[at + 10], n[at + 11], n[at + 2], 0, 0, 0, 1);
}

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

/** The angle between two poses' rotations [rad]. */
function angleBetween(a, b) {
  const p = a.elements;
  const q = b.elements;
  let trace = 0;
  for (const i of [0, 1, 2, 4, 5, 6, 8, 9, 10]) trace += p[i] * q[i];
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2)));
}

export class Picture {
  options = {
    forces: true, cones: false, ghost: false, muscles: true, path: true, seeThrough: false, exaggeration: 1,
  };
  /** Called after a state was drawn. */
  onDrawn = () => {};
  fullPressure_Pa = 20e3;
  fullActivation = 0.1; // of a muscle's strength
  #object = new Matrix4();
  #target = new Matrix4();
  #poses = [];
  #friction = NaN;
  #fresh = false;
  #wanted = false; // a drawing is asked for,
  #scheduled = false; // is soon begun,
  #drawing = false; // is under way
  #last_ms = 0;
  #pause_ms = kFrame_ms;
  #times_ms = [];
  #trailCount = 0;
  #loaded = [];

  /** `overlay`: an element over the canvas, for labels; `insets`: one element a finger, where its pulp is shown. */
  constructor(canvas, overlay, insets) {
    this.canvas = canvas;
    this.overlay = overlay;
    this.insets = insets;
    this.software = isSoftware();
    this.renderer = new WebGLRenderer({canvas, antialias: !this.software, powerPreference: 'low-power'});
    this.renderer.autoClear = false;
    this.world = new Scene();
    this.above = new Scene(); // is drawn over the world, for forces act inside of things
    this.camera = new PerspectiveCamera(30, 1, 0.02, 3);
    this.close = new OrthographicCamera(-1, 1, 1, -1, -0.1, 0.1);
    this.close.layers.set(kPulpLayer);
    for (const scene of [this.world, this.above]) scene.add(new HemisphereLight(0xffffff, 0xa8a098, 1.75));
    this.lamp = this.#light(this.world);
    this.lampAbove = this.#light(this.above);
    this.closeLamp = new DirectionalLight(0xffffff, 1.3);
    this.world.traverse((light) => light.isLight && light !== this.lamp && light.layers.enable(kPulpLayer));
    this.closeLamp.layers.set(kPulpLayer);
    this.world.add(this.closeLamp, this.closeLamp.target);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.request());
    this.labels = [];
    this.matchTheme();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.matchTheme());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  #light(scene) {
    const light = new DirectionalLight(0xffffff, 1.6);
    scene.add(light, light.target);
    return light;
  }

  matchTheme() {
    this.renderer.setClearColor(new Color(themed('--picture')));
    this.object?.uniforms.color.value.set(themed('--object'));
    this.skeleton?.setColor(themed('--bone'));
    this.request();
  }

  /** A new scene: its message and its geometry. The camera stays, unless this is the first one. */
  load(scene, geometry) {
    this.#unload();
    this.scene = scene;
    this.geometry = geometry;
    this.state = null; // nothing is drawn before its first state: what was seen stays
    this.#poses = scene.segments.map(() => new Matrix4());
    this.object = this.#addSplats(kEnough, themed('--object'), 1, 0);
    this.ghost = this.#addSplats(kEnoughForGhost, themed('--ghost'), 0.3, kGhostBehind_m);
    for (const splats of [this.object, this.ghost]) splats.matrixAutoUpdate = false;
    this.skeleton = this.#keep(this.world, new Skeleton(scene, themed('--bone')));
    this.muscles = this.#keep(this.world, new Muscles(scene));
    this.pulps = geometry.fingers.map((finger) => {
      if (finger.points.length === 0) return null;
      const pulp = this.#keep(this.world, new Pulp(finger));
      pulp.layers.enable(kPulpLayer);
      return pulp;
    });
    this.insets.forEach((inset, k) => (inset.hidden = !this.pulps[k]));
    this.contactArrows = this.#keep(this.above, new Arrows(256));
    this.cones = this.#keep(this.above, cones(256, {transparent: true, opacity: 0.22, depthWrite: false, side: 2}));
    this.fingerArrows = this.#keep(this.above, new Arrows(8));
    this.desiredArrows = this.#keep(this.above, new Arrows(8, {transparent: true, opacity: 0.45}));
    this.coil = this.#keep(this.above, new Coil(0xd03a8c));
    this.path = this.#keep(this.above, trail(themed('--path'), 3));
    this.targetPath = this.#keep(this.above, trail(themed('--ghost'), 2));
    this.#trailCount = 0;
    this.#makeLabels();
    this.#aimed = this.#aimed && this.aimedFor === scene.name;
    this.aimedFor = scene.name;
    this.resize();
  }

  #addSplats(enough, color, opacity, behind) {
    const {points, normals, growth} = thinned(this.geometry.object.points, this.geometry.object.normals, enough);
    const radius = growth * this.scene.object.spacing_m;
    return this.#keep(this.world, new Splats(points, normals, radius, color, {opacity, behind, tilted: !this.software}));
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

  #makeLabels() {
    this.overlay.replaceChildren();
    this.labels = [...this.scene.fingers.map(({name}) => name), 'pull'].map((name, k) => {
      const label = document.createElement('div');
      label.className = 'label';
      label.style.setProperty('--color', fingerColors[k] ?? '#d03a8c');
      label.dataset.name = name;
      label.hidden = true;
      this.overlay.append(label);
      return {element: label, at: new Vector3(), text: ''};
    });
  }

  /** Shows a state. */
  show(state) {
    this.state = state;
    this.#friction = state.values.friction[0];
    const v = state.values;
    setPose(this.#object, v.object);
    setPose(this.#target, v.target);
    this.object.matrix.copy(this.#object);
    this.ghost.matrix.copy(this.#target);
    for (let s = 0; s < this.#poses.length; ++s) setPose(this.#poses[s], v.segments, 12 * s);
    this.skeleton.pose(this.#poses);
    this.#pullMuscles(v.muscles_N);
    this.remember(v);
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
    this.path.visible = this.targetPath.visible = options.path && this.#trailCount > 2;
    this.object.setOpacity(options.seeThrough ? 0.35 : 1);
    this.#movePulps(v);
    this.#drawForces(v);
    this.#drawPull(v);
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
      const f = at + columns.force_N;
      const n = at + columns.normal;
      const normal_N = numbers[f] * numbers[n] + numbers[f + 1] * numbers[n + 1] + numbers[f + 2] * numbers[n + 2];
      pulp.pressure_Pa[control] = Math.max(0, normal_N / pulp.areas[control]);
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
  }

  #drawForces(v) {
    const {contactArrows, cones, fingerArrows, desiredArrows, options, state} = this;
    for (const many of [contactArrows, cones, fingerArrows, desiredArrows]) many.clear();
    for (let i = 0; (options.forces || options.cones) && i < state.contacts; ++i) this.#drawContact(state.contact(i));
    for (let k = 0; k < this.scene.fingers.length; ++k) {
      const force = vector(v.force_N, 3 * k);
      const desired = vector(v.desired_N, 3 * k);
      const acts = vector(v.centre_m, 3 * k);
      const label = this.labels[k];
      label.text = '';
      if (!options.forces || !Number.isFinite(acts.x) || !(force.lengthSq() > 0)) continue;
      const slipping = v.sliding_share[k] > kSlipping;
      color.set(fingerColors[k]);
      if (slipping) color.copy(kSliding);
      fingerArrows.put(label.at.copy(acts).addScaledVector(force, -kFinger_m_per_N), acts, 1.1e-3, color);
      if (desired.lengthSq() > 0) {
        color.lerp(kWhite, 0.35);
        desiredArrows.put(from.copy(acts).addScaledVector(desired, -kFinger_m_per_N), acts, 1.9e-3, color);
      }
      label.text = `${this.scene.fingers[k].name} ${force.length().toFixed(2)} N${slipping ? ', slipping' : ''}`;
      label.element.classList.toggle('bad', slipping);
    }
    for (const many of [contactArrows, cones, fingerArrows, desiredArrows]) many.done();
  }

  #drawContact(at) {
    const {columns, numbers} = this.state;
    to.fromArray(numbers, at + columns.point_m);
    n.fromArray(numbers, at + columns.normal);
    f.fromArray(numbers, at + columns.force_N);
    const f_n = f.dot(n);
    if (!(f_n > 0)) return;
    const f_t = Math.sqrt(Math.max(0, f.lengthSq() - f_n * f_n));
    const margin = 1 - f_t / (this.#friction * f_n);
    // Red at the cone's edge, pale from a third of the way in.
    color.copy(kSafe).lerp(kSliding, Number.isFinite(margin) ? 1 - Math.min(1, Math.max(0, margin - 0.05) / 0.3) : 0);
    // A rigid fingertip has one contact: its force is the finger's, which is drawn already.
    if (this.options.forces && this.state.contacts > this.scene.fingers.length) {
      this.contactArrows.put(from.copy(to).addScaledVector(f, -kContact_m_per_N), to, 2.6e-4, color);
    }
    if (this.options.cones && this.#friction > 0) {
      const height = kContact_m_per_N * f_n;
      this.cones.put(to, from.copy(to).addScaledVector(n, -height), this.#friction * height, color);
    }
  }

  #drawPull(v) {
    const label = this.labels.at(-1);
    label.text = '';
    this.coil.visible = false;
    if (!isFinite3(v.pull_anchor_m) || !isFinite3(v.pull_handle_m)) return;
    from.fromArray(v.pull_anchor_m);
    label.at.fromArray(v.pull_handle_m);
    this.coil.stretch(from, label.at, 1.6e-3);
    label.text = `pull ${Math.hypot(...v.pull_force_N).toFixed(2)} N`;
  }

  /** Adds to the way of the object and its target; `v`: a state's values. */
  remember(v) {
    const last = this.path.geometry.attributes.position.array.subarray(3 * this.#trailCount - 3);
    const moved = Math.hypot(v.object[0] - last[0], v.object[1] - last[1], v.object[2] - last[2]);
    if (this.#trailCount > 0 && moved < kTrailStep_m) return;
    if (this.#trailCount === kTrail) {
      // Half of it is let go at once: seldom, and without a seam.
      for (const {geometry} of [this.path, this.targetPath]) geometry.attributes.position.array.copyWithin(0, 3 * kTrail / 2);
      this.#trailCount = kTrail / 2;
    }
    for (const [points, place] of [[this.path, v.object], [this.targetPath, v.target]]) {
      const {position} = points.geometry.attributes;
      position.array.set(place.subarray(0, 3), 3 * this.#trailCount);
      position.needsUpdate = true;
      points.geometry.setDrawRange(0, this.#trailCount + 1);
    }
    this.#trailCount += 1;
  }

  clearTrail() {
    this.#trailCount = 0;
  }

  /** The camera as at the start: the grip axis level and across, both fingers and the top of the object to be seen. */
  aim() {
    if (!this.state) return;
    const tips = this.scene.fingers.map(({segment, centre_m}) => vector(centre_m).applyMatrix4(this.#poses[segment]));
    const gravity = vector(this.scene.gravity_m_per_s2);
    const up = gravity.lengthSq() > 0 ? gravity.normalize().negate() : new Vector3(0, 0, 1);
    const grip = gripAxis(tips);
    const across = grip.addScaledVector(up, -grip.dot(up)).normalize();
    const level = across.clone().cross(up);
    const kTurn = 0.35, kRise = 0.5;
    const eye = level.multiplyScalar(Math.cos(kTurn)).addScaledVector(across, Math.sin(kTurn))
        .multiplyScalar(Math.cos(kRise)).addScaledVector(up, Math.sin(kRise));
    const centre = new Vector3().setFromMatrixPosition(this.#object);
    // A little towards the hand, of which most should be seen.
    const middle = mean(tips);
    middle.lerp(new Vector3(), 0.35);
    this.controls.target.copy(centre).lerp(middle, 0.45);
    this.camera.up.copy(up);
    const radius = 0.088 / Math.min(1, 1.15 * this.camera.aspect);
    this.camera.position.copy(this.controls.target)
        .addScaledVector(eye, radius / Math.sin((this.camera.fov * Math.PI) / 360));
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
    if (this.scene && this.state) {
      this.#render();
      this.#placeLabels();
    }
    this.#await(start_ms);
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
    this.lamp.position.set(-0.4, 0.7, 0.6).applyQuaternion(camera.quaternion);
    this.lampAbove.position.copy(this.lamp.position);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, this.width, this.height);
    renderer.clear();
    this.closeLamp.visible = false;
    renderer.render(this.world, camera);
    renderer.clearDepth();
    renderer.render(this.above, camera);
    this.#renderInsets();
  }

  /** Each pulp as the object sees it. */
  #renderInsets() {
    const {renderer, close} = this;
    this.closeLamp.visible = true;
    renderer.setScissorTest(true);
    this.pulps.forEach((pulp, k) => {
      const box = this.insetBoxes[k];
      if (!pulp || !box || box.width === 0) return;
      for (const other of this.pulps) if (other) other.visible = other === pulp;
      const {centre_m, radius_m, shape} = this.scene.fingers[k];
      const centre = vector(centre_m).applyMatrix4(pulp.matrix);
      const normal = vector(this.state.values.normal, 3 * k);
      if (!(normal.lengthSq() > 0)) normal.setFromMatrixColumn(pulp.matrix, 1); // palmar
      close.up.setFromMatrixColumn(pulp.matrix, 0); // the finger's tip is up
      close.position.copy(centre);
      close.lookAt(from.copy(centre).sub(normal));
      const reach_m = !shape ? radius_m
          : shape.form === 'capsule' ? shape.half_m[0] + shape.half_m[1] : Math.max(...shape.half_m);
      const half = 1.08 * reach_m;
      close.left = -half * box.width / box.height;
      close.right = -close.left;
      close.top = half;
      close.bottom = -half;
      close.updateProjectionMatrix();
      this.closeLamp.position.set(-0.5, 0.8, 1).applyQuaternion(close.quaternion);
      renderer.setViewport(box.x, box.y, box.width, box.height);
      renderer.setScissor(box.x, box.y, box.width, box.height);
      renderer.clear();
      renderer.render(this.world, close);
    });
    for (const pulp of this.pulps) if (pulp) pulp.visible = true;
    renderer.setScissorTest(false);
  }

  #placeLabels() {
    for (const label of this.labels) {
      label.element.hidden = label.text === '';
      if (label.text === '') continue;
      const [x, y] = this.project(label.at.toArray(place));
      label.element.textContent = label.text;
      label.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
    }
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
    for (const splats of [this.object, this.ghost]) splats?.fit(this.camera, pixels);
    const canvas = this.canvas.getBoundingClientRect();
    this.insetBoxes = this.insets.map((inset) => {
      const box = inset.getBoundingClientRect();
      return {x: box.left - canvas.left, y: canvas.bottom - box.bottom, width: box.width, height: box.height};
    });
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

const kWhite = new Color(1, 1, 1);
const kSafe = new Color('#178a4c');
const kSliding = new Color('#e01b1b');
const color = new Color();
const from = new Vector3();
const to = new Vector3();
const n = new Vector3();
const f = new Vector3();
const place = [0, 0, 0];
const pointer = new Vector2();
const raycaster = new Raycaster();

/** A scale's end, that grows at once and shrinks when a good part of it is not used. */
function steadyScale(full, most, least) {
  return most > full || most < 0.3 * full ? niceAbove(Math.max(most, least)) : full;
}

function trail(color, size) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * kTrail), 3).setUsage(DynamicDrawUsage));
  geometry.setDrawRange(0, 0);
  const points = new Points(geometry, new PointsMaterial({color, size, sizeAttenuation: false}));
  points.frustumCulled = false;
  return points;
}

/** Whether the processor draws, for lack of a graphics card. */
function isSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return true;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|softpipe/i.test(name);
}
