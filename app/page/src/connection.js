// SPDX-License-Identifier: Apache-2.0
// The way to the simulation: finds it again when it is lost, asks for states, sends what hands do.

import {RemoteClock} from './clock.js';

const kFirstWait_ms = 250;
const kLongestWait_ms = 4000;
const kPing_ms = 2000;
const kUnanswered = 3; // so many pings without an answer: the way is dead, though nobody says so
const kKept = 20; // messages, before the first connection: more than anyone presses meanwhile

const local_s = () => performance.now() / 1e3;

export class Connection {
  connected = false;
  clock = new RemoteClock();
  #url;
  #on;
  #socket = null;
  #wait_ms = kFirstWait_ms;
  #unanswered = 0;
  #kept = []; // what was said before the first connection; null from when that was made, or failed

  /**
   * `on`: {text(object), binary(Uint8Array), state(connected), unsaid()}; what they throw is no reason to stop.
   * The first connection is tried at once; `unsaid` is called if it fails and something was kept for it.
   */
  constructor(url, on) {
    this.#url = url;
    this.#on = on;
    setInterval(() => this.#ping(), kPing_ms);
    this.#open();
  }

  /**
   * Sends an object as JSON. A page can be used before it is connected, so what is said until the first connection is
   * kept for it. After a loss nothing is: nobody expects that what was pressed long ago is still done. False if nobody
   * will hear it.
   */
  send(message) {
    const text = JSON.stringify(message);
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(text);
    else if (this.#kept?.length < kKept) this.#kept.push(text);
    else return false;
    return true;
  }

  /** The server's time [s]; undefined before it has answered a ping. */
  now_s() {
    return this.clock.at(local_s());
  }

  #open() {
    const socket = (this.#socket = new WebSocket(this.#url));
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.#wait_ms = kFirstWait_ms;
      this.#unanswered = 0;
      this.clock = new RemoteClock(); // it may be another server
      const kept = this.#kept ?? [];
      this.#kept = null;
      this.#set(true);
      this.#ping();
      for (const text of kept) socket.send(text);
    };
    socket.onmessage = ({data}) => {
      this.#unanswered = 0;
      if (typeof data !== 'string') return this.#on.binary(new Uint8Array(data));
      const message = JSON.parse(data);
      if (message.type === 'pong') return this.clock.add(message.t, local_s(), message.now_s);
      this.#on.text(message);
    };
    socket.onclose = () => {
      if (socket !== this.#socket) return;
      const unsaid = this.#kept?.length > 0;
      this.#kept = null;
      this.#set(false);
      if (unsaid) this.#on.unsaid();
      setTimeout(() => this.#open(), this.#wait_ms * (0.75 + 0.5 * Math.random()));
      this.#wait_ms = Math.min(2 * this.#wait_ms, kLongestWait_ms);
    };
  }

  #ping() {
    if (!this.connected) return;
    if (this.#unanswered >= kUnanswered) {
      // A close that waits for the other side's would take its time: go on without.
      const socket = this.#socket;
      socket.onmessage = null;
      socket.close();
      socket.onclose();
      socket.onclose = null;
      return;
    }
    this.#unanswered += 1;
    this.send({type: 'ping', t: local_s()});
  }

  #set(connected) {
    this.connected = connected;
    this.#on.state(connected);
  }
}
