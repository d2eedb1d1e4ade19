// SPDX-License-Identifier: Apache-2.0
// Colours that mean something, the same in the picture and in the panels.

import {Color} from 'three';

import palette from './palette.js';

// `stuck` and `slipping`: of contacts that hold, and of those that slide. Eyes without one kind of cones tell them apart as
// well as others do, and so do those that see no colours, by lightness and by a second head of the arrow. `atLimit`: of a
// cell that holds, and has nothing to spare.
export const {fingers: fingerColors, stuck, slipping, at_limit: atLimit} = palette;

const stops = (colors) => colors.map((color) => new Color(color));
// From an untouched pulp to a hard pressed one: lightness falls all the way, so that it reads without hues.
const kPressure = stops(['#e8b8a0', '#f0a65e', '#e2622f', '#b5213c', '#6a0d3f']);
const kActivation = stops(['#8f9bab', '#d98a5c', '#d8372b', '#a00d1d']);

/** Writes a colour of a scale, 0 .. 1, to out[at ..], linear red, green, blue. */
function mix(scale, share, out, at) {
  const x = Math.min(Math.max(share, 0), 1) * (scale.length - 1) || 0;
  const i = Math.min(Math.floor(x), scale.length - 2);
  const a = scale[i];
  const b = scale[i + 1];
  out[at] = a.r + (x - i) * (b.r - a.r);
  out[at + 1] = a.g + (x - i) * (b.g - a.g);
  out[at + 2] = a.b + (x - i) * (b.b - a.b);
}

export const pressureColor = (share, out, at) => mix(kPressure, share, out, at);
export const activationColor = (share, out, at) => mix(kActivation, share, out, at);
export const pressureGradient = `linear-gradient(to top, ${kPressure.map((c) => c.getStyle()).join(', ')})`;
export const activationGradient = `linear-gradient(to right, ${kActivation.map((c) => c.getStyle()).join(', ')})`;

/** The least of 1, 2, 5, 10, ... that is no less than x. */
export function niceAbove(x) {
  const decade = 10 ** Math.floor(Math.log10(x));
  return decade * [1, 2, 5, 10].find((m) => m * decade >= x * (1 - 1e-9));
}

/** A style sheet's variable, as the theme has it now. */
export const themed = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
