// SPDX-License-Identifier: Apache-2.0
// What the parts of the page are, and what keys and mouse do: from docs/guide/window.md, of which build.mjs makes GUIDE.

/* global GUIDE */
const {parts, inputs} = typeof GUIDE === 'undefined' ? {parts: {}, inputs: []} : GUIDE;

/** What a part is: the name is one of the guide's. */
export const tip = (name) => parts[name] ?? '';

/** Says of each element with a `data-tip` what it is, where the pointer rests on it. */
export function showTips(root) {
  for (const element of root.querySelectorAll('[data-tip]')) element.title = tip(element.dataset.tip);
}

function addRow(list, name, text) {
  const row = list.appendChild(document.createElement('div'));
  row.appendChild(document.createElement('dt')).textContent = name;
  row.appendChild(document.createElement('dd')).textContent = text;
  return row;
}

/** Fills the help: what keys and mouse do, and what the parts are, for who has no pointer to rest on them. */
export function showHelp(dialog) {
  const [keys, names] = ['#inputs', '#parts'].map((list) => dialog.querySelector(list));
  for (const {input, does, where} of inputs) addRow(keys, input, does).className = {live: 'live', recording: 'replay'}[where] ?? '';
  for (const [name, text] of Object.entries(parts)) addRow(names, name, text);
}
