// SPDX-License-Identifier: Apache-2.0
// The grasps that a search has found: what it is doing, a card for each grasp, and what to do with it.

import {fixed} from './format.js';
import {shownMeasures} from './messages.js';
import {drawThumbnails} from './thumbnails.js';

const kBest = [5, 10, 20];
const kThumbnail = {width: 264, height: 232}; // twice its size on the page

function element(tag, text = '', parent = null) {
  const made = document.createElement(tag);
  made.textContent = text;
  parent?.append(made);
  return made;
}

/** "box, grasp 2" as the name of a file. */
const fileName = (scene, rank) => `${scene.replace(/, grasp \d+$/, '').replace(/[^\w-]+/g, '_')}-grasp-${rank}.yaml`;

export class Grasps {
  #message = null;
  #shown = ''; // which search's cards there are
  #scene = null;
  #geometry = null;
  #cards = [];
  #urls = [];
  #drawn = false;
  #endDrawing = () => {};

  /** `root`: the section; `send(message)`: to the program. */
  constructor(root, send) {
    this.send = send;
    const part = (name) => root.querySelector(`.${name}`);
    this.parts = {find: part('find'), best: part('best'), bar: part('bar'), say: part('say'), refusal: part('refusal'),
                  list: part('found'), own: part('own')};
    for (const best of kBest) this.parts.best.add(new Option(String(best), best));
    this.parts.find.addEventListener('click', () => this.#search());
    this.parts.own.addEventListener('click', () => this.#take(0));
  }

  get message() {
    return this.#message;
  }

  /** What the object looks like. */
  load(scene, geometry) {
    this.#scene = scene;
    this.#geometry = geometry;
    if (!this.#drawn) this.#draw();
  }

  /** What comes next may be another program's. */
  forget() {
    this.#shown = '';
  }

  show(message) {
    this.#message = message;
    const {find, bar, say, refusal, own} = this.parts;
    find.textContent = message.running ? 'Stop' : message.search > 0 ? 'Search again' : 'Find grasps';
    find.disabled = message.stopping;
    bar.hidden = !message.running;
    say.textContent = words(message);
    refusal.hidden = !message.refusal;
    refusal.replaceChildren();
    if (message.refusal) {
      element('b', `No grasp: ${message.refusal.reason}.`, refusal);
      if (message.refusal.help) element('span', ` What would help: ${message.refusal.help}.`, refusal);
    }
    own.hidden = message.grasps.length === 0 && message.taken === 0;
    own.setAttribute('aria-pressed', String(message.taken === 0));
    const search = `${message.search} ${message.running}`;
    if (search !== this.#shown) {
      this.#shown = search;
      this.#makeCards();
    }
    this.#cards.forEach(({card, run}, i) => {
      const runs = message.taken === i + 1;
      if (runs && card.getAttribute('aria-current') !== 'true') requestAnimationFrame(() => card.scrollIntoView({block: 'nearest'}));
      card.setAttribute('aria-current', String(runs));
      run.textContent = runs ? 'Runs: start again' : 'Run';
    });
  }

  /** Has the grasp of a rank run; 0: the scene's own start. */
  #take(grasp) {
    this.send({type: 'take', search: this.#message?.search ?? 0, grasp});
  }

  #search() {
    if (this.#message?.running) this.send({type: 'stop_finding'});
    else this.send({type: 'find', best: Number(this.parts.best.value)});
  }

  #makeCards() {
    for (const url of this.#urls) URL.revokeObjectURL(url);
    this.#urls = [];
    this.parts.list.replaceChildren();
    this.#cards = this.#message.grasps.map((grasp, i) => this.#makeCard(grasp, i + 1));
    this.#draw();
  }

  #makeCard(grasp, rank) {
    const card = element('li', '', this.parts.list);
    const canvas = Object.assign(element('canvas', '', card), kThumbnail);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `grasp ${rank} before it begins`);
    const title = element('h3', '', card);
    element('b', String(rank), title);
    element('span', grasp.fingers.join(', '), title);
    const figures = element('dl', '', card);
    for (const {name, shown, shown_unit, factor, digits, sentence} of shownMeasures(this.#message.measures, grasp)) {
      const figure = element('div', '', figures);
      figure.title = name === 'limit_rad' ? `${sentence} It is that of ${grasp.limit_joint}.` : sentence;
      const label = element('dt', shown, figure);
      if (shown_unit) element('i', shown_unit, label);
      element('dd', fixed(factor * grasp[name], digits), figure);
    }
    if (!grasp.within_limits) element('p', 'A muscle passes its limit when it is tried.', card).className = 'warns';
    const actions = element('div', '', card);
    actions.className = 'actions';
    const run = element('button', 'Run', actions);
    run.type = 'button';
    const save = element('a', 'Save scene', actions);
    save.href = URL.createObjectURL(new Blob([grasp.scene], {type: 'text/yaml'}));
    this.#urls.push(save.href);
    save.download = fileName(this.#scene?.name ?? 'scene', rank);
    element('p', capitalized(grasp.words), card).className = 'words';
    card.addEventListener('click', (event) => {
      if (event.target !== save && !getSelection().toString()) this.#take(rank);
    });
    return {card, canvas, run, grasp};
  }

  #draw() {
    this.#endDrawing();
    this.#endDrawing = () => {};
    this.#drawn = this.#geometry !== null;
    if (this.#drawn && this.#cards.length > 0) {
      this.#endDrawing = drawThumbnails(this.#scene, this.#geometry, this.#cards);
    }
  }
}

const capitalized = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** What a search is doing, or what came of it. How many stages it will have nobody knows, so no share of it is shown. */
function words({search, running, stopping, share, found, took_s}) {
  if (search === 0) return '';
  if (stopping) return 'stopping as soon as one is tried';
  if (running && share >= 1) return `trying what fits: ${found} held`;
  if (running) return `searching: ${found} fit`;
  return `${found} found in ${fixed(took_s ?? NaN, 1)} s`;
}
