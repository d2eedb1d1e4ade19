// SPDX-License-Identifier: Apache-2.0
// The search of the built site finds what users ask for: Sphinx's own program of the search, here with a document that
// only keeps the list of results. Ends with 77 where the site is not built.
//
//     node search.mjs HTML

import {existsSync, readFileSync} from 'node:fs';
import path from 'node:path';
import vm from 'node:vm';

/** A question, and the page that answers it: it must be among the first results. */
const QUESTIONS = [
  ['how do I import my hand from URDF', 'docs/guide/hands'],
  ['friction of a wet object', 'docs/guide/window', 'docs/guide/reflex', 'docs/guide/scenes'],
  ['exit codes', 'docs/guide/run'],
  ['real time', 'docs/guide/realtime'],
  ['muscle limits', 'docs/reference/muscles', 'docs/guide/hands', 'docs/guide/run'],
  ['grasp my own mesh', 'docs/guide/objects'],
  ['scan point cloud', 'docs/guide/objects'],
  ['parameter sweep', 'docs/guide/sweeps'],
  ['stiffness of the object', 'docs/guide/stiffness'],
  ['python', 'docs/guide/python', 'docs/site/python'],
  ['why does my peg jam', 'docs/guide/environment'],
  ['table and walls', 'docs/guide/environment'],
  ['replay a recording', 'docs/guide/window', 'docs/reference/recordings'],
  ['MuJoCo comparison', 'docs/guide/truth', 'docs/guide/python'],
  ['pick and place', 'docs/guide/tasks'],
  ['own controller torques', 'docs/guide/controller'],
  ['link C++ library cmake', 'docs/guide/embed'],
  ['signals.csv columns', 'docs/reference/results'],
  ['unknown key error message', 'docs/guide/refusals', 'docs/guide/scenes'],
  ['Delassus operator', 'engine/grasp/delassus', 'docs/NOTATION', 'docs/ARCHITECTURE'],
  ['slip detection reflex', 'docs/guide/reflex'],
  ['original paper', 'docs/guide/paper'],
  ['how hard can the hand pinch', 'docs/guide/hands'],
  ['Jupyter notebook', 'docs/guide/python'],
  ['haptic device', 'docs/guide/embed'],
  ['SCHED_FIFO', 'docs/guide/realtime'],
  ['contact_tick', 'engine/grasp/contact_tick'],
  ['Simulation.step', 'docs/site/python'],
];
const FIRST = 3;

const html = process.argv[2];
if (!existsSync(path.join(html, 'searchindex.js'))) {
  console.log(`skipped: ${html} has no site; ./dev docs builds it`);
  process.exit(77);
}

/** Something of a page, which keeps what is put into it. */
function element() {
  return {
    dataset: {}, style: {}, classList: {add() {}}, children: [],
    appendChild(child) {
      this.children.push(child);
      return child;
    },
    removeChild() {},
  };
}

const later = [];
const page = {
  document: {
    readyState: 'loading', addEventListener() {}, createElement: element, documentElement: element(),
    querySelector: () => null, getElementById: () => ({getAttribute: () => '', removeChild() {}}),
  },
  localStorage: {setItem() {}, getItem: () => null, removeItem() {}},
  location: {search: '', href: ''},
  // What waits for 10 ms marks words on the page.
  setTimeout: (call, ms) => ms < 10 && later.push(call),
  URLSearchParams, console, URL,
};
page.window = page;
vm.createContext(page);
const load = (name) => vm.runInContext(readFileSync(path.join(html, name), 'utf8'), page, {filename: name});
for (const name of ['documentation_options', 'doctools', 'sphinx_highlight', 'language_data', 'searchtools']) {
  if (existsSync(path.join(html, '_static', `${name}.js`))) load(path.join('_static', `${name}.js`));
}
load('searchindex.js');

/** The pages of the first results, as the page of the search lists them. */
function found(question) {
  page.question = question;
  page.location.search = `?${new URLSearchParams({q: question})}`;
  page.list = element();
  vm.runInContext(`Object.assign(Search, {output: list, title: {}, status: {}, stopPulse() {}, dots: {}});
                   Search.query(question);`, page);
  for (let i = 0; i < 100 && later.length > 0; ++i) later.shift()();
  later.length = 0;
  return page.list.children.map((item) => item.children[0].href.replace(/\.html(#.*)?$/, ''));
}

let wrong = 0;
for (const [question, ...answers] of QUESTIONS) {
  const pages = [...new Set(found(question))];
  const place = pages.findIndex((name) => answers.includes(name));
  if (place >= 0 && place < FIRST) continue;
  ++wrong;
  console.log(`'${question}': ${answers[0]} is ${place < 0 ? 'missing' : `result ${place + 1}`} of ${pages.length}: ` +
              pages.slice(0, 6).join(', '));
}
console.log(`${QUESTIONS.length - wrong} of ${QUESTIONS.length} questions have their page among the first ${FIRST} results`);
process.exit(wrong > 0 ? 1 : 0);
