// SPDX-License-Identifier: Apache-2.0
// Plays a recording: shows its newest frame at a time that runs, stands, or is set.

const kFrame_ms = 33;
const kLongest_ms = 250; // after a stall the recording goes on from where it stood

export class Replay {
  speed = 1;
  #recording;
  #show;
  #changed;
  #index = -1;
  #time_s = 0;
  #timer = 0;
  #then_ms = 0;

  /** `show(frames, index)` draws; `changed()` is called when time or playing have changed. */
  constructor(recording, show, changed) {
    this.#recording = recording;
    this.#show = show;
    this.#changed = changed;
    this.seek(0);
  }

  get time() {
    return this.#time_s;
  }
  get duration() {
    return this.#recording.duration_s;
  }
  get playing() {
    return this.#timer !== 0;
  }

  /** Goes to a time [s] of the recording. */
  seek(time_s) {
    this.#time_s = Math.min(Math.max(time_s, 0), this.duration);
    const index = lastUpTo(this.#recording.frames, this.#time_s);
    if (index !== this.#index) this.#show(this.#recording.frames, (this.#index = index));
    this.#changed();
  }

  /** Steps by whole frames, back if `count` is negative. */
  step(count) {
    this.pause();
    const frames = this.#recording.frames;
    this.seek(frames[Math.min(Math.max(this.#index + count, 0), frames.length - 1)].at_s);
  }

  play() {
    if (this.playing) return;
    if (this.#time_s >= this.duration) this.seek(0);
    this.#then_ms = performance.now();
    this.#timer = setInterval(() => this.#advance(), kFrame_ms);
    this.#changed();
  }

  pause() {
    clearInterval(this.#timer);
    this.#timer = 0;
    this.#changed();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  #advance() {
    const now_ms = performance.now();
    const next_s = this.#time_s + (this.speed * Math.min(now_ms - this.#then_ms, kLongest_ms)) / 1e3;
    this.#then_ms = now_ms;
    this.seek(next_s);
    if (next_s >= this.duration) this.pause();
  }
}

/** The last frame at or before a time; the first one if there is none. */
function lastUpTo(frames, time_s) {
  let low = 0;
  let high = frames.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (frames[middle].at_s <= time_s + 1e-9) low = middle;
    else high = middle - 1;
  }
  return low;
}
