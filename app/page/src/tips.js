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

/** Fills the help: two tables of what keys and mouse do. */
export function showInputs(parent) {
  const half = Math.ceil(inputs.length / 2);
  for (const some of [inputs.slice(0, half), inputs.slice(half)]) {
    const table = parent.appendChild(document.createElement('table')).createTBody();
    for (const {input, does, where} of some) {
      const row = table.insertRow();
      row.className = {live: 'live', recording: 'replay'}[where] ?? '';
      row.appendChild(document.createElement('th')).textContent = input;
      row.insertCell().textContent = does;
    }
  }
}
