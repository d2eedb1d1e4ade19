// SPDX-License-Identifier: Apache-2.0
// Elements of the panels.

export const byId = (id) => document.getElementById(id);

export function element(tag, text = '', parent = null) {
  const made = document.createElement(tag);
  made.textContent = text;
  parent?.append(made);
  return made;
}

export const setText = (node, text) => {
  if (node.textContent !== text) node.textContent = text;
};

/** A bar of a share 0 .. 1. */
export function bar(parent) {
  const track = element('span', '', parent);
  track.className = 'track';
  const fill = element('i', '', track);
  return (share, color) => {
    fill.style.transform = `scaleX(${Math.min(1, Math.max(0, share || 0)).toFixed(4)})`;
    if (color) fill.style.setProperty('--fill', color);
  };
}

/** A meter in a row of a table: a bar, and in the cell behind it its number. */
export function meterIn(row) {
  const meter = element('td', '', row);
  meter.className = 'meter';
  const set = bar(meter);
  return {meter, set, text: element('td', '', row)};
}
