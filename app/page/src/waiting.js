// SPDX-License-Identifier: Apache-2.0
// What is waited for before the first picture, in words, where the picture will be.

export const kNoGraphics = 'This browser draws no 3-D pictures: WebGL 2 is missing or switched off. ' +
    'Allow graphics acceleration in its settings, or take another browser.';

/**
 * What the page waits for; nothing once something was drawn. `isLive`: a simulation, not a recording; `hasTried`: the program
 * did not answer the first time; `hasScene`, `hasState`: these have come; `isSoftware`: the processor draws.
 */
export function waitText({failure, drawn, isLive, isConnected, hasTried, hasScene, hasState, isSoftware}) {
  if (drawn > 0) return '';
  if (failure) return failure;
  if (hasState) {
    return isSoftware ? 'Drawing the first picture; without a graphics card this takes some seconds …' : 'Drawing the first picture …';
  }
  if (!isLive) return 'Reading the recording …';
  if (!isConnected && hasTried) {
    return 'The program does not answer; it is tried again. It may have ended: a new run prints a new address.';
  }
  if (!isConnected) return 'Connecting to the program …';
  return hasScene ? 'Waiting for the first state of the simulation …' : 'Connected; the program prepares the scene …';
}
