// SPDX-License-Identifier: Apache-2.0
// The page of thenar's live window; docs/reference/window.md says what it talks.

import {Capture} from './capture.js';
import {Connection} from './connection.js';
import {cellStates} from './cells.js';
import {fingerColors, pressureGradient} from './colors.js';
import {fixed} from './format.js';
import {Grasps} from './grasps.js';
import {Hands, kHardPoke_N, kPoke_N} from './hands.js';
import {State, isRead, kGeometry, kState, kVersion, kindOf, readGeometry} from './messages.js';
import {Notices, noticesOf, restOf} from './notices.js';
import {Panels, spans_s} from './panels.js';
import {Picture} from './picture.js';
import {fromBase64, openRecording} from './recording.js';
import {Replay} from './replay.js';
import {Settings} from './settings.js';
import {showHelp, showTips} from './tips.js';
import {feels} from './touch.js';
import {Views} from './views.js';
import {kNoGraphics, waitText} from './waiting.js';

const kSpeeds = [1, 0.5, 0.2, 0.1, 0.01];
const kRecent = 250, kMemory = 1000; // states before the one that is sought, for the plots: the last ones, and some of the rest

const byId = (id) => document.getElementById(id);
const root = document.documentElement;
const source = root.dataset.source;
const isLive = source === 'live';

const insets = fingerColors.map((color) => {
  const inset = document.createElement('div');
  inset.className = 'inset';
  inset.style.setProperty('--color', color);
  inset.append(document.createElement('span'));
  byId('cells').before(inset);
  return inset;
});
for (const {name, color, dot} of cellStates) {
  const one = byId('cells').appendChild(document.createElement('span'));
  one.textContent = name;
  one.style.setProperty('--color', color);
  one.style.setProperty('--dot', dot ?? 'transparent');
}
const picture = makePicture();
const panels = new Panels();
const notices = new Notices(byId('notices'));
const views = new Views(byId('views'), picture);

let scene = null;
let state = null;
let status = null;
let failure = null; // why nothing more can be shown
let connection = null;
let replay = null;
let waiting = false; // a state is asked for
let isLost = false; // the connection is
let hasTried = false; // to connect
let states = 0; // drawn

const hands = new Hands(picture, (message) => send(message.type === 'release' ? message : {...message, ...stamp()}));
const grasps = new Grasps(byId('grasps'), send);
const settings = new Settings(byId('settings').querySelector('form'), (change) => send({type: 'set', ...change}));

panels.stiffness.change = (change) => send({type: 'set', ...change});

const capture = new Capture(picture, () => document.querySelectorAll('#labels .label, #insets .inset:not([hidden]) span, #cells:not([hidden]) span'), () => {
  const time_s = state?.values.time_s[0] ?? 0;
  return `${scene?.name ?? 'thenar'} ${time_s.toFixed(3)} s`.replaceAll(/[^\w.-]+/g, '_');
});
picture.onPixels = () => capture.drawn();

function makePicture() {
  try {
    return new Picture(byId('canvas'), byId('labels'), insets);
  } catch (error) {
    byId('wait').textContent = kNoGraphics;
    byId('link').textContent = 'no picture';
    throw error;
  }
}

// Messages out.

function send(message) {
  if (!connection?.send(message) && isLive) sayUnsaid();
}

const sayUnsaid = () => say('not connected: nothing was done');

/** Says what has happened. */
function say(text, kind = 'warn') {
  notices.say(text, {kind, at: state?.values.time_s[0]});
}

function stamp() {
  const stamp_s = connection?.now_s();
  return stamp_s === undefined ? {} : {stamp_s};
}

/** Asks for the newest state: only after the last one was drawn, so that a slow page falls behind nothing. */
function askNext() {
  if (waiting || !connection?.connected) return;
  waiting = connection.send({type: 'next'});
}

function setSpeed(value) {
  if (replay) {
    replay.speed = value;
    byId('replay-speed').value = value;
  } else {
    send({type: 'speed', value});
  }
}

function pause() {
  if (replay) replay.toggle();
  else send({type: status?.paused ? 'resume' : 'pause'});
}

function reset() {
  hands.release();
  send({type: 'reset'});
  if (hands.shift_m.lengthSq() + hands.turn_rad.lengthSq() > 0) hands.home();
}

// Messages in.

function setScene(message, geometry) {
  scene = message;
  state = new State(scene);
  byId('cells').hidden = !feels(scene);
  byId('insets').classList.toggle('large', feels(scene)); // cells are small
  picture.load(scene, readGeometry(geometry, scene));
  panels.load(scene);
  hands.load(scene);
  grasps.load(scene, picture.geometry);
  settings.load(scene.settings?.filter(({type}) => type !== 'numbers')); // which have a panel of their own
  views.load(scene);
  showSettings();
  byId('scene-name').textContent = scene.name;
  document.title = `${scene.name} · Thenar`;
  scene.fingers.forEach(({name}, k) => (insets[k].firstChild.textContent = name));
  failure = null;
  showWords();
}

function setStatus(message) {
  const before = status?.recording;
  status = message;
  showSettings();
  showRecording(before);
  byId('pause').textContent = status?.paused ? 'Go on' : 'Pause';
  byId('pause').setAttribute('aria-pressed', String(Boolean(status?.paused)));
  if (status?.speed) setSelect(byId('speed'), status.speed);
  byId('panel-loops').title = status?.scheduling ?? '';
  showWords();
}

/** Whether the program records, and what came of it if it did `before`. */
function showRecording(before) {
  const now = status?.recording;
  const runs = Boolean(now?.running);
  press('record', runs);
  byId('record').textContent = runs ? 'Recording' : 'Record';
  if (!now || (now.file === before?.file && runs === before.running)) return;
  if (runs) say(`recording into ${now.file}`, 'note');
  else if (now.note) say(`${now.file}: ${now.note}`);
  else if (before?.running) say(`recorded into ${now.file}`, 'note');
}

/** Settings as the status has them; friction, which a task may change, as the last state. */
function showSettings() {
  const friction = state?.values.friction?.[0] || status?.settings?.friction;
  settings.show(status?.settings && {...status.settings, friction});
}

/** Shows a state; `quiet`: only for the plots' memory. */
function showState(bytes, quiet = false) {
  const before_s = state.values.time_s[0];
  const friction = state.values.friction?.[0];
  state.take(bytes);
  const time_s = state.values.time_s[0];
  if (time_s < before_s) picture.clearTrail();
  if (quiet) picture.remember(state.values);
  else picture.show(state);
  panels.show(state, picture.fullActivation, quiet, quiet ? '' : status?.outcome);
  if (quiet) return;
  if (state.values.friction?.[0] !== friction) showSettings();
  byId('time').textContent = fixed(time_s, 3);
  byId('factor').textContent = fixed(state.values.realtime_factor[0], 2);
  byId('full-pressure').textContent = `${fixed(picture.fullPressure_Pa / 1e3, 0)} kPa`;
  showWords();
}

picture.onDrawn = () => {
  states += 1;
  if (states === 1) begin();
  askNext();
};

/** The first picture is there. */
function begin() {
  showWords();
  if (isLive) showLink('live', 'good');
  else replay?.play(); // not while the picture is still being made
}

/** What there is to say of the grasp, and of what is waited for. */
function showWords() {
  const values = picture.state ? state.values : null;
  notices.show(noticesOf({failure, isLost, status, values}), restOf({status, values, phases: scene?.phases}));
  const text = waitText({failure, drawn: states, isLive, isConnected: connection?.connected, hasTried, hasScene: scene !== null,
    hasState: values !== null, isSoftware: picture.software});
  if (byId('wait').textContent !== text) byId('wait').textContent = text;
}

function fail(error) {
  console.error(error);
  failure = error.message;
  showWords();
}

// Live.

let pendingScene = null;

function receiveText(message) {
  if (message.type === 'scene') {
    if (!isRead(message.version)) return fail(new Error(`the program talks version ${message.version}, this page ${kVersion}: reload it`));
    pendingScene = message;
  } else if (message.type === 'status') {
    setStatus(message);
  } else if (message.type === 'grasps') {
    grasps.show(message);
  } else if (message.type === 'refused') {
    say(`Refused: ${message.reason}`);
    showSettings();
  }
}

function receiveBinary(bytes) {
  try {
    if (kindOf(bytes) === kGeometry) {
      setScene(pendingScene, bytes);
      askNext();
    } else if (kindOf(bytes) === kState) {
      waiting = false;
      showState(bytes);
    }
  } catch (error) {
    fail(error);
    askNext();
  }
}

function setConnected(connected) {
  waiting = false;
  hands.enabled = connected;
  if (!connected) {
    hands.release();
    grasps.forget();
  }
  hasTried = true;
  isLost = !connected && states > 0;
  if (connected) showLink(states > 0 ? 'live' : 'connected', 'good');
  else showLink(states > 0 ? 'connection lost' : 'not connected', 'bad');
  showWords();
}

function showLink(text, kind) {
  byId('link').textContent = text;
  byId('link').className = `badge ${kind}`;
}

function goLive() {
  const url = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live${location.search}`;
  connection = new Connection(url, {text: receiveText, binary: receiveBinary, state: setConnected, unsaid: sayUnsaid});
}

// A recording.

async function recordedBytes() {
  if (source === 'embedded') return fromBase64(byId('recording').textContent);
  const response = await fetch(`recording${location.search}`);
  if (!response.ok) throw new Error(`the recording cannot be fetched: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

function showFrame(frames, index) {
  const frame = frames[index];
  if (frame.scene !== scene) setScene(frame.scene, frame.geometry);
  if (frame.status !== status) setStatus(frame.status);
  const onward = index > shownFrame && index - shownFrame < kRecent && frames[shownFrame]?.scene === scene;
  if (!onward) recall(frames, index);
  for (let i = shownFrame + 1; onward && i < index; ++i) showState(frames[i].bytes, true);
  shownFrame = index;
  showState(frame.bytes);
}
let shownFrame = -1;

/** After a jump the plots need what went before. */
function recall(frames, index) {
  panels.clear();
  picture.clearTrail();
  const recent = Math.max(0, index - kRecent);
  const stride = Math.max(1, Math.ceil(recent / kMemory));
  for (let i = 0; i < index; i += i < recent ? stride : 1) {
    if (frames[i].scene === scene) showState(frames[i].bytes, true);
  }
}

async function openReplay() {
  showLink('opening the recording', '');
  const recording = openRecording(await recordedBytes());
  showLink(recording.whole ? 'recording' : 'recording, cut off', '');
  const seek = byId('seek');
  seek.max = recording.duration_s;
  replay = new Replay(recording, showFrame, () => {
    if (!replay) return;
    seek.value = replay.time;
    seek.setAttribute('aria-valuetext', `${fixed(replay.time, 2)} s`);
    byId('seek-time').textContent = `${fixed(replay.time, 2)} of ${fixed(replay.duration, 2)} s`;
    byId('play').textContent = replay.playing ? 'Pause' : 'Play';
  });
  seek.addEventListener('input', () => replay.seek(Number(seek.value)));
  byId('play').addEventListener('click', () => replay.toggle());
  setSelect(byId('replay-speed'), 1);
  const end = new State(scene);
  end.take(recording.frames.at(-1).bytes);
  if (!Number.isFinite(end.values.contact_Hz?.[0])) toggleLoops(); // of one loop there are no figures of two
}

// Buttons and keys.

function setSelect(select, value) {
  if (![...select.options].some((option) => Number(option.value) === value)) select.add(new Option(`${value}×`, value));
  select.value = value;
}

for (const id of ['speed', 'replay-speed']) {
  for (const value of kSpeeds) byId(id).add(new Option(`${value}×`, value));
  byId(id).addEventListener('change', (event) => setSpeed(Number(event.target.value)));
}

for (const span_s of spans_s) byId('span').add(new Option(Number.isFinite(span_s) ? `${span_s} s` : 'all', span_s));
byId('span').addEventListener('change', (event) => panels.look(Number(event.target.value)));

function toggleSettings() {
  const hidden = !byId('settings').hidden;
  byId('settings').hidden = hidden;
  byId('show-settings').setAttribute('aria-pressed', String(!hidden));
}

showTips(document);
showHelp(byId('help'));
byId('tools').addEventListener('click', () => byId('tools').hidePopover()); // where it is a menu, one of it was chosen
// A menu of a narrow window stands in the bar of a wide one.
matchMedia('(max-width: 560px)').addEventListener('change', () => document.querySelectorAll(':popover-open').forEach((menu) => menu.hidePopover()));

const {classList: shownParts} = document.querySelector('main');
const press = (id, pressed) => byId(id).setAttribute('aria-pressed', String(pressed));

/** The plots, or the grasps in their place, or neither. */
function showColumn(part) {
  shownParts.toggle('no-grasp', part === null);
  shownParts.toggle('finds', part === 'grasps');
  press('show-grasp', part === 'plots');
  press('show-grasps', part === 'grasps');
}
const togglePlots = () => showColumn(shownParts.contains('finds') || shownParts.contains('no-grasp') ? 'plots' : null);
const toggleGrasps = () => showColumn(shownParts.contains('finds') ? 'plots' : 'grasps');
const toggleLoops = () => press('show-loops', !shownParts.toggle('no-loops'));
const toggleHelp = () => {
  const help = byId('help');
  if (help.open) return help.close();
  help.showModal();
  help.querySelector('.inside').scrollTop = 0;
};

function film() {
  const {filming} = capture;
  try {
    capture.toggleFilm();
    press('film', !filming);
  } catch (error) {
    say(error.message);
  }
}

const clicks = {
  shoot: () => capture.shoot(), film, record: () => send({type: status?.recording?.running ? 'stop_recording' : 'record'}), pause, reset, step: () => send({type: 'step'}), 'show-settings': toggleSettings, 'close-settings': toggleSettings, 'show-grasps': toggleGrasps,
  'show-grasp': togglePlots, 'show-loops': toggleLoops, 'show-help': toggleHelp,
};
for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener('click', act);
byId('scales').querySelector('.bar').style.background = pressureGradient;

function poke(direction, hard) {
  hands.poke(direction.multiplyScalar(hard ? kHardPoke_N : kPoke_N));
}

const keys = {
  ' ': pause,
  h: toggleHelp,
  '?': toggleHelp,
  v: () => picture.aim(),
  Escape: () => hands.release(),
};
const liveKeys = {
  '.': () => send({type: 'step'}),
  r: reset,
  s: toggleSettings,
  g: toggleGrasps,
  b: () => hands.home(),
  p: () => poke(picture.axes().away, false),
  P: () => poke(picture.axes().away, true),
  ArrowLeft: (event) => poke(picture.axes().right.negate(), event.shiftKey),
  ArrowRight: (event) => poke(picture.axes().right, event.shiftKey),
  ArrowUp: (event) => poke(picture.axes().up, event.shiftKey),
  ArrowDown: (event) => poke(picture.axes().up.negate(), event.shiftKey),
};
const replayKeys = {
  ',': () => replay.step(-1),
  '.': () => replay.step(1),
  ArrowLeft: () => replay.seek(replay.time - 0.5),
  ArrowRight: () => replay.seek(replay.time + 0.5),
};

addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (byId('help').open && !'h?'.includes(event.key)) return; // Escape closes it, and nothing else happens behind it
  if (event.key === 'Escape' && document.querySelector(':popover-open')) return; // closes that
  if (event.repeat && !/^[.,]$/.test(event.key) && !(replay && event.key.startsWith('Arrow'))) return;
  // An input with the focus, a slider or a choice, keeps the keys that it takes itself.
  const {tagName} = event.target;
  if (tagName === 'INPUT' && /^(Arrow|Page|Home|End)/.test(event.key)) return;
  if (tagName === 'SELECT' && event.key !== 'Escape') return;
  if (event.key === 'Escape' && (tagName === 'INPUT' || tagName === 'SELECT')) event.target.blur();
  if ((tagName === 'BUTTON' || tagName === 'SUMMARY') && (event.key === ' ' || event.key === 'Enter')) return;
  const more = isLive ? liveKeys : replay ? replayKeys : {};
  const act = keys[event.key] ?? more[event.key];
  const speed = kSpeeds[Number(event.key) - 1];
  if (act) act(event);
  else if (speed !== undefined) setSpeed(speed);
  else if (!views.press(event.key)) return;
  event.preventDefault();
});

// For tests, and for who looks at it in the console.
window.thenar = {
  /** Shows a time of a recording at once, for who takes pictures of the page; `alone`: the picture without what is around it. */
  async showAt(time_s, alone = false) {
    if (root.classList.toggle('alone', alone) !== picture.alone) {
      picture.alone = alone;
      picture.resize();
      picture.aim();
    }
    replay.pause();
    replay.seek(time_s);
    picture.draw();
    panels.flush();
    for (let i = 0; i < 2; ++i) await new Promise(requestAnimationFrame); // until it is on the screen
  },
  get connected() { return connection?.connected ?? false; },
  get scene() { return scene; },
  get status() { return status; },
  get grasps() { return grasps.message; },
  get state() { return state?.values; },
  get contacts() { return state?.contacts ?? 0; },
  get drawn() { return states; },
  get plots() { return panels.advanced; },
  get fps() { return picture.fps; },
  get events() { return notices.events; },
  plotted: () => panels.forces.columns(panels.span_s)[0],
  get replay() { return replay; },
  options: picture.options,
  picture,
  project: (point) => picture.project(point),
  metresPerPixel: (point) => picture.metresPerPixel(point),
  hitObject: (x, y) => picture.hitObject(x, y)?.world.toArray() ?? null,
};

showWords();
if (isLive) goLive();
else openReplay().catch(fail);
