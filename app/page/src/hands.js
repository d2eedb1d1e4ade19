// SPDX-License-Identifier: Apache-2.0
// Hands on the object: pulling, pushing, moving and turning its target.

import {Matrix4, Vector3} from 'three';

const kRepeat_ms = 25; // the simulation lets go after 200 ms without a message
const kHover_ms = 60;
const kReach_m = 1; // a handle farther out is refused
const kShiftLimit_m = 0.05;
const kTurnLimit_rad = 0.5;
const kTurn_rad_per_pixel = 2.5e-3;
export const kPoke_N = 2;
export const kHardPoke_N = 5;

const clamp = (x, limit) => Math.min(limit, Math.max(-limit, x));

export class Hands {
  shift_m = new Vector3(); // of the target, in the object's axes at the start
  turn_rad = new Vector3();
  #picture;
  #send;
  #toStart = new Matrix4(); // world axes -> the object's at the start
  #drag = null;
  #timer = 0;
  #hovered_ms = 0;

  /** `send(message)` stamps and sends; nothing is dragged while `enabled` is false. */
  constructor(picture, send) {
    this.#picture = picture;
    this.#send = send;
    this.enabled = false;
    const {canvas} = picture;
    // Before the camera's controls hear of it.
    const first = {capture: true};
    canvas.addEventListener('pointerdown', (event) => this.#down(event), first);
    canvas.addEventListener('pointermove', (event) => this.#move(event), first);
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      canvas.addEventListener(end, (event) => this.#up(event), first);
    }
    addEventListener('blur', () => this.release());
  }

  /** `start`: the object's pose at the start, as the scene tells it. */
  load({start}) {
    const [, , , a, b, c, d, e, f, g, h, i] = start;
    this.#toStart.set(a, d, g, 0, b, e, h, 0, c, f, i, 0, 0, 0, 0, 1);
    this.release();
  }

  get pulling() {
    return this.#drag?.kind === 'pull';
  }

  /** A push at the object's origin, a world vector [N]. */
  poke(force_N) {
    if (this.#picture.scene) this.#send({type: 'poke', force_N: force_N.toArray()});
  }

  /** Lets go of everything. */
  release() {
    const pulled = this.pulling;
    this.#drag = null;
    clearInterval(this.#timer);
    this.#picture.canvas.classList.remove('pulling');
    if (pulled) this.#send({type: 'release'});
  }

  /** The target as the task has it. */
  home() {
    this.shift_m.set(0, 0, 0);
    this.turn_rad.set(0, 0, 0);
    this.#sendTarget();
  }

  #down(event) {
    if (!this.enabled || !this.#picture.state || event.button !== 0) return;
    this.release(); // one hand
    const {offsetX: x, offsetY: y} = event;
    const drag = this.#begin(event, x, y);
    if (!drag) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.#picture.canvas.focus();
    this.#picture.canvas.setPointerCapture(event.pointerId);
    this.#picture.canvas.classList.add('pulling');
    this.#drag = {...drag, pointer: event.pointerId, x, y};
    const act = {pull: () => this.#sendPull(), shift: () => this.#shift(this.#drag), turn: () => this.#turn(this.#drag)}[drag.kind];
    act();
    this.#timer = setInterval(act, kRepeat_ms);
  }

  #begin(event, x, y) {
    const picture = this.#picture;
    if (event.shiftKey) {
      const through = new Vector3().fromArray(picture.state.values.target);
      return {kind: 'shift', through, from: picture.onPlane(x, y, through), before: this.shift_m.clone()};
    }
    if (event.ctrlKey || event.altKey) return {kind: 'turn', before: this.turn_rad.clone(), from: [x, y]};
    const hit = picture.hitObject(x, y);
    return hit && {kind: 'pull', point: hit.local, through: hit.world};
  }

  #move(event) {
    const drag = this.#drag;
    const {offsetX: x, offsetY: y} = event;
    if (!drag) return this.#hover(x, y, event.buttons);
    if (event.pointerId !== drag.pointer) return;
    event.stopImmediatePropagation();
    // The timer sends it: a fast display has more of these than the server takes.
    drag.x = x;
    drag.y = y;
  }

  #up(event) {
    if (event.pointerId !== this.#drag?.pointer) return;
    event.stopImmediatePropagation();
    if (this.#drag.kind === 'shift') this.#shift(this.#drag);
    if (this.#drag.kind === 'turn') this.#turn(this.#drag);
    this.release();
  }

  #hover(x, y, buttons) {
    const now_ms = performance.now();
    if (!this.enabled || buttons !== 0 || now_ms < this.#hovered_ms + kHover_ms) return;
    this.#hovered_ms = now_ms;
    this.#picture.canvas.classList.toggle('can-pull', this.#picture.hitObject(x, y) !== null);
  }

  /** Again and again while it is held, also without motion: else the simulation takes us for gone. */
  #sendPull() {
    const {point, through, x, y} = this.#drag;
    const handle = this.#picture.onPlane(x, y, through).clampLength(0, kReach_m);
    this.#send({type: 'pull', point_m: point.toArray(), handle_m: handle.toArray()});
  }

  #shift({from, through, before, x, y}) {
    const moved = this.#picture.onPlane(x, y, through).sub(from).applyMatrix4(this.#toStart);
    this.shift_m.addVectors(before, moved);
    this.#sendTarget();
  }

  #turn({from, before, x, y}) {
    const {right, up} = this.#picture.axes();
    const turned = up.multiplyScalar(kTurn_rad_per_pixel * (x - from[0]))
        .addScaledVector(right, kTurn_rad_per_pixel * (y - from[1]));
    this.turn_rad.addVectors(before, turned.applyMatrix4(this.#toStart));
    this.#sendTarget();
  }

  #sendTarget() {
    for (const axis of ['x', 'y', 'z']) {
      this.shift_m[axis] = clamp(this.shift_m[axis], kShiftLimit_m);
      this.turn_rad[axis] = clamp(this.turn_rad[axis], kTurnLimit_rad);
    }
    this.#send({type: 'target', shift_m: this.shift_m.toArray(), turn_rad: this.turn_rad.toArray()});
  }
}
