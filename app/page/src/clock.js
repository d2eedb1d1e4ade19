// SPDX-License-Identifier: Apache-2.0
// Estimates another clock from round trips: an answer says what it read somewhere between question and answer, so the
// shortest of them is off by half its length at most.

const kKept = 30; // the clocks drift apart: a short trip of long ago says nothing

export class RemoteClock {
  #trips = [];

  /** One round trip [s]: sent and received by the local clock, `remote_s` what the other one read. */
  add(sent_s, received_s, remote_s) {
    if (!(received_s >= sent_s) || !Number.isFinite(remote_s)) return;
    this.#trips.push({length_s: received_s - sent_s, offset_s: remote_s - (sent_s + received_s) / 2});
    if (this.#trips.length > kKept) this.#trips.shift();
  }

  get best() {
    return this.#trips.reduce((a, b) => (b.length_s < a.length_s ? b : a), this.#trips[0]);
  }

  /** What the other clock reads at `local_s`; undefined before the first round trip. */
  at(local_s) {
    const best = this.best;
    return best && local_s + best.offset_s;
  }
}
