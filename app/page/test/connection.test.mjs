// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import test from 'node:test';

import {Connection} from '../src/connection.js';

/** A connection whose sockets do what a test says: {connection, sockets, heard, retry}. `retry` has the next one made. */
function connect(t) {
  const sockets = [];
  class Socket {
    static OPEN = 1;
    readyState = 0;
    sent = [];
    constructor() {
      sockets.push(this);
    }
    send(text) {
      this.sent.push(JSON.parse(text));
    }
    open() {
      this.readyState = Socket.OPEN;
      this.onopen();
    }
    lose() {
      this.readyState = 3;
      this.onclose();
    }
    /** What was sent but for pings. */
    get said() {
      return this.sent.filter(({type}) => type !== 'ping').map(({type}) => type);
    }
  }
  globalThis.WebSocket = Socket;
  let again = null;
  t.mock.method(globalThis, 'setInterval', () => 0);
  t.mock.method(globalThis, 'setTimeout', (act) => (again = act));
  const heard = [];
  const connection = new Connection('ws://here', {state: (connected) => heard.push(connected), unsaid: () => heard.push('unsaid')});
  return {connection, sockets, heard, retry: () => again()};
}

test('what is said before the first connection is kept, and sent in its order', (t) => {
  const {connection, sockets: [first], heard} = connect(t);
  assert.ok(connection.send({type: 'pause'}));
  assert.ok(connection.send({type: 'step'}));
  assert.deepEqual(first.sent, []);
  first.open();
  assert.ok(connection.send({type: 'reset'}));
  assert.deepEqual(first.said, ['pause', 'step', 'reset']);
  assert.deepEqual(heard, [true]);
});

test('where the first connection fails, what was kept is not done, and that is said', (t) => {
  const {connection, sockets, heard, retry} = connect(t);
  connection.send({type: 'reset'});
  sockets[0].lose();
  assert.deepEqual(heard, [false, 'unsaid']);
  assert.equal(connection.send({type: 'pause'}), false);
  retry();
  assert.equal(connection.send({type: 'pause'}), false);
  sockets[1].open();
  assert.deepEqual(sockets[1].said, []);
});

test('after a loss nothing is kept', (t) => {
  const {connection, sockets, heard, retry} = connect(t);
  sockets[0].open();
  sockets[0].lose();
  assert.equal(connection.send({type: 'reset'}), false);
  retry();
  sockets[1].open();
  assert.ok(connection.send({type: 'step'}));
  assert.deepEqual([sockets[0].said, sockets[1].said], [[], ['step']]);
  assert.deepEqual(heard, [true, false, true]);
});

test('a key that is held down before the first connection fills no memory', (t) => {
  const {connection, sockets: [first]} = connect(t);
  let kept = 0;
  for (let i = 0; i < 1000; ++i) kept += connection.send({type: 'step'});
  assert.ok(kept >= 10 && kept < 200, 'the server takes bursts of 200 messages');
  first.open();
  assert.equal(first.said.length, kept);
});
