// SPDX-License-Identifier: Apache-2.0
// A recording, ready to be shown: every state with the scene, geometry and status that hold then.

import {readMcap} from './mcap.js';

const kShown = ['/scene', '/geometry', '/state', '/status']; // All else is for others.
const kNeeded = ['object', 'target', 'segments', 'contacts']; // Of a state, for a picture of it.

/**
 * Reads an MCAP file of thenar: {frames, duration_s, whole}. A frame is {at_s, bytes, scene, geometry, status}; at_s counts
 * from the first one and never falls, also where the simulation was set back.
 */
export function openRecording(buffer) {
  const {messages, whole} = readMcap(buffer, (topic) => kShown.includes(topic));
  const frames = [];
  let scene = null;
  let geometry = null;
  let status = null;
  let last_s = 0;
  let at_s = 0;
  for (const {topic, time_s, bytes} of messages) {
    if (topic === '/scene') scene = checked(json(bytes));
    if (topic === '/geometry') geometry = bytes;
    if (topic === '/status') status = json(bytes);
    if (topic !== '/state' || !scene || !geometry) continue;
    if (frames.length > 0) at_s += Math.max(0, time_s - last_s);
    last_s = time_s;
    frames.push({at_s, bytes, scene, geometry, status});
  }
  // What is said at the end, that the object was lost for one, is said of the last state.
  if (frames.length > 0) frames.at(-1).status = status;
  if (frames.length === 0) throw new Error('the recording holds no states');
  return {frames, duration_s: at_s, whole};
}

/** A scene, or an Error where its states cannot be drawn. */
function checked(scene) {
  const missing = kNeeded.find((needed) => !scene.fields.some(({name}) => name === needed));
  if (missing) throw new Error(`the recording has some fields of its states alone, without ${missing}: there is no picture of it`);
  return scene;
}

function json(bytes) {
  return JSON.parse(new TextDecoder().decode(bytes));
}

/** The bytes of base64 text, blanks and line ends in it allowed. */
export function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text).buffer;
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}
