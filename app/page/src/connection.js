// The way to the simulation: finds it again when it is lost, asks for states, sends what hands do.

import {RemoteClock} from './clock.js';

const kFirstWait_ms = 250;
const kLongestWait_ms = 4000;
const kPing_ms = 2000;
const kUnanswered = 3; // so many pings without an answer: the way is dead, though nobody says so

const local_s = () => performance.now() / 1e3;

export class Connection {
  connected = false;
  clock = new RemoteClock();
  #url;
  #on;
  #socket = null;
  #wait_ms = kFirstWait_ms;
  #unanswered = 0;

  /**
   * `on`: {text(object), binary(Uint8Array), state(connected)}; what they throw is no reason to stop.
   * The first connection is tried at once.
   */
  constructor(url, on) {
    this.#url = url;
    this.#on = on;
    setInterval(() => this.#ping(), kPing_ms);
    this.#open();
  }

  /** Sends an object as JSON; false if nobody is there. */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
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
      this.#set(true);
      this.#ping();
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
      this.#set(false);
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
