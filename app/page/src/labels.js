// Labels over the picture, that follow places in it.

import {Vector3} from 'three';

import {fingerColors} from './colors.js';

const place = [0, 0, 0];

/** Labels in an element over the picture: {element, at [m, world], text} each; without text they are hidden. */
export function makeLabels(overlay, names) {
  overlay.replaceChildren();
  return names.map((name, k) => {
    const element = document.createElement('div');
    element.className = 'label';
    element.style.setProperty('--color', fingerColors[k] ?? '#d03a8c');
    element.dataset.name = name;
    element.hidden = true;
    overlay.append(element);
    return {element, at: new Vector3(), text: ''};
  });
}

/** `project(point)`: where in the overlay a place is, in pixels. */
export function placeLabels(labels, project) {
  for (const {element, at, text} of labels) {
    element.hidden = text === '';
    if (text === '') continue;
    const [x, y] = project(at.toArray(place));
    element.textContent = text;
    element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
  }
}
