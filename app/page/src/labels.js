// SPDX-License-Identifier: Apache-2.0
// Labels over the picture, that follow places in it.

import {Vector3} from 'three';

import {fingerColors} from './colors.js';

const place = [0, 0, 0];
const kNamed = [['around', 'var(--around-force)'], ['stiffness', 'var(--stiffness)'], ['turning', 'var(--turning)'], ['scale', 'transparent'], ['gravity', 'transparent'], ['pull', '#d03a8c']]; // beginnings of names
const kWide = 100, kHigh = 18; // of a label, in pixels

/** Labels in an element over the picture: {element, at [m, world], text} each; without text they are hidden. */
export function makeLabels(overlay, names) {
  return names.map((name, k) => {
    const element = document.createElement('div');
    element.className = 'label';
    element.style.setProperty('--color', kNamed.find(([begin]) => name.startsWith(begin))?.[1] ?? fingerColors[k] ?? '#d03a8c');
    element.dataset.name = name;
    element.hidden = true;
    overlay.append(element);
    return {element, at: new Vector3(), text: ''};
  });
}

/** `project(point)`: where in the overlay a place is, in pixels. */
export function placeLabels(labels, project) {
  const placed = []; // from the top downwards
  for (const {element, at, text} of labels) {
    element.hidden = text === '';
    if (text === '') continue;
    let [x, y] = project(at.toArray(place));
    // Below those that it would cover: each moves it once at most, and below the higher ones it stays.
    for (const [u, v] of placed) {
      if (Math.abs(u - x) < kWide && Math.abs(v - y) < kHigh) y = v + kHigh;
    }
    placed.push([x, y]);
    placed.sort(([, v], [, w]) => v - w);
    element.textContent = text;
    element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
  }
}
