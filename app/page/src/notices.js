// SPDX-License-Identifier: Apache-2.0
// What there is to say of a grasp: the gravest of it in a line above the picture, which can be closed, and all in a list.

import {element, setText} from './elements.js';
import {fixed} from './format.js';

const kEvent_ms = 6000; // so long what has happened stands in the line,
const kEvents = 20; // and so many of it stay in the list
const kCalm = new Set(['held', 'task done']);
const kGrave = new Set(['lost', 'task failed', 'solver failed']);

/** Which phase of a task runs: 'phase 3 of 5: lift'. */
function phaseWords(phases, phase) {
  return phase < phases.length ? `phase ${phase + 1} of ${phases.length}: ${phases[phase]}` : 'the task is done';
}

/** A text without its numbers: a notice is the same one while only these change. */
const withoutNumbers = (text) => text.replaceAll(/\d[\d.,]*/g, '#');

/**
 * What holds now, the gravest first: [{kind, text, key}] where kind is grave, warn or note. `failure`: why nothing more can
 * be shown; `isLost`: the connection is; `status`: the last one; `values`: of the last state. Each may be missing.
 */
export function noticesOf({failure, isLost, status, values}) {
  const outcome = status?.outcome ?? '';
  const found = [];
  const say = (holds, kind, text, key = withoutNumbers(text)) => holds && found.push({kind, text, key});
  say(failure, 'grave', failure ?? '');
  say(isLost, 'warn', 'The connection is lost: the page tries again, and does nothing meanwhile. A new run has a new address');
  say(kGrave.has(outcome), 'grave', `${outcome}: ${status?.reason}`, outcome);
  say(values?.grasp_failed?.[0], 'grave', 'No grasp forces exist: the fingers cannot hold this object so');
  say(outcome && !kGrave.has(outcome) && !kCalm.has(outcome), 'warn', `${outcome}: ${status?.reason}`, outcome);
  say(values?.muscles_failed?.[0], 'warn', 'The muscles cannot make these torques');
  say(values?.held?.[0], 'warn', 'The frame is too old: its drive is held');
  for (const warning of status?.warnings ?? []) say(true, 'warn', warning);
  say(status?.note, 'note', status?.note ?? '');
  return found;
}

/** What the line says when there is nothing else to say: the phase of a task, or the outcome so far. */
export function restOf({status, values, phases}) {
  const outcome = status?.outcome ?? '';
  const phase = phases && values && !kGrave.has(outcome) ? phaseWords(phases, values.phase[0]) : '';
  return {kind: kGrave.has(outcome) ? 'over' : phase ? 'note' : outcome ? 'calm' : 'none', text: phase || outcome};
}

export class Notices {
  #line;
  #parts;
  #now = []; // what holds
  #rest = {kind: 'note', text: ''};
  #events = []; // what has happened, the newest first: {kind, text, at, until_ms}
  #closed = new Set(); // keys of what holds and was closed
  #timer = 0;
  #same = '';

  /** `line`: the element of them all. */
  constructor(line) {
    this.#line = line;
    const part = (id) => line.querySelector(`#${id}`);
    this.#parts = {alert: part('alert'), say: part('say'), all: part('all-notices'), close: part('close-notice'), list: part('notice-list')};
    const {close, list} = this.#parts;
    close.addEventListener('click', () => this.#close());
    list.addEventListener('beforetoggle', ({newState}) => newState === 'open' && this.#place());
    addEventListener('resize', () => list.hidePopover());
    new ResizeObserver(() => this.#measure()).observe(line);
  }

  /** Texts of what has happened, the newest first. */
  get events() {
    return this.#events.map(({text}) => text);
  }

  /** Shows what holds now: noticesOf(), and where all of it was closed, restOf(). */
  show(now, rest) {
    const same = JSON.stringify([now, rest]);
    if (same === this.#same) return;
    this.#same = same;
    this.#now = now;
    this.#rest = rest;
    for (const key of this.#closed) if (!now.some((notice) => notice.key === key)) this.#closed.delete(key);
    this.#render();
  }

  /** Says what has happened, `at` which time [s] of the simulation. */
  say(text, {kind = 'warn', at} = {}) {
    this.#events.unshift({kind, text, at, until_ms: performance.now() + kEvent_ms});
    this.#events.length = Math.min(this.#events.length, kEvents);
    this.#render();
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#render(), kEvent_ms + 50);
  }

  get #top() {
    const event = this.#events.find(({until_ms}) => until_ms > performance.now());
    return event ?? this.#now.find(({key}) => !this.#closed.has(key));
  }

  #close() {
    const top = this.#top;
    if (top?.key) this.#closed.add(top.key);
    else if (top) top.until_ms = 0;
    this.#render();
  }

  #render() {
    const {alert, say, all, close, list} = this.#parts;
    const top = this.#top;
    const {kind, text} = top ?? this.#rest;
    this.#line.dataset.kind = kind;
    // Who is told by ear hears at once of what is grave.
    setText(alert, kind === 'grave' ? text : '');
    setText(say, kind === 'grave' ? '' : text);
    close.hidden = !top;
    const count = this.#now.length + this.#events.length;
    all.hidden = count === 0;
    setText(all, count > 1 ? `all ${count}` : 'more');
    if (count === 0) list.hidePopover();
    list.replaceChildren();
    for (const notice of this.#now) this.#add('now', notice);
    for (const notice of this.#events) this.#add(notice.at === undefined ? '' : `${fixed(notice.at, 2)} s`, notice);
    this.#measure();
  }

  #add(when, {kind, text}) {
    const item = element('li', '', this.#parts.list);
    item.dataset.kind = kind;
    element('b', when, item);
    element('span', text, item);
  }

  /** A single notice that is seen whole needs no list. */
  #measure() {
    const {alert, say, all} = this.#parts;
    const isWhole = [alert, say].every((part) => part.scrollHeight <= part.clientHeight + 1 && part.scrollWidth <= part.clientWidth + 1);
    const isAll = this.#now.length + this.#events.length === 1 && Boolean(this.#top);
    all.classList.toggle('needless', isAll && isWhole);
  }

  #place() {
    const box = this.#line.getBoundingClientRect();
    Object.assign(this.#parts.list.style, {left: `${box.left}px`, top: `${box.bottom + 2}px`, width: `${box.width}px`});
  }
}
