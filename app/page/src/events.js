// SPDX-License-Identifier: Apache-2.0
// What happened in a run, as states tell it: in the words of engine/results/run_events.h, of which the figures are marked.

const kFelt = {1: 'load', 2: 'slip'};

export class Events {
  /** {time_s, what}, in the order of time. */
  list = [];
  #scene = null;
  #last = null; // what the last state said

  load(scene) {
    this.#scene = scene;
    this.clear();
  }

  clear() {
    this.list = [];
    this.#last = null;
  }

  /** A state's values; `outcome`: of the status then. A time before the last one begins anew. */
  add(v, outcome = '') {
    const time_s = v.time_s[0];
    if (time_s < this.#last?.time_s) this.clear();
    const now = {time_s, outcome, friction: v.friction?.[0], phase: v.phase?.[0], reflex_s: v.last_reflex_s?.[0]};
    const last = this.#last ?? {...now, phase: -1, reflex_s: NaN};
    this.#last = now;
    const note = (at_s, what) => this.list.push({time_s: at_s, what});
    if (now.friction !== last.friction) note(time_s, `friction ${now.friction < last.friction ? 'falls' : 'rises'} to ${Number(now.friction.toPrecision(3))}`);
    if (now.phase !== last.phase && now.phase >= 0) note(time_s, this.#scene.phases?.[now.phase] ?? 'task done');
    if (Number.isFinite(now.reflex_s) && now.reflex_s !== last.reflex_s) {
      note(now.reflex_s, `grip answers ${kFelt[v.last_reflex[0]]}, ${this.#scene.fingers[v.last_reflex_finger[0]].name}`);
    }
    if (outcome !== last.outcome && /^(lost|task failed)$/.test(outcome)) note(time_s, outcome);
  }
}

/** Those of the page. */
export const events = new Events();
