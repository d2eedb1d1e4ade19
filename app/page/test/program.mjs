// SPDX-License-Identifier: Apache-2.0
// The program behind the page, started and ended by tests.

import {spawn} from 'node:child_process';
import {createInterface} from 'node:readline';

/** Runs `thenar-window demo …`: {url, log, signal, stop}. Throws what it said if it ends before it has told its address. */
export async function startProgram(program, args) {
  const child = spawn(program, ['demo', '--no-browser', ...args], {stdio: ['ignore', 'pipe', 'pipe']});
  process.once('exit', () => child.kill('SIGKILL')); // a test that failed leaves nothing behind
  const ended = new Promise((resolve) => child.once('exit', (code) => resolve(code)));
  let log = '';
  child.stderr.on('data', (text) => (log += text));
  const lines = createInterface({input: child.stdout});
  const url = await Promise.race([
    new Promise((resolve) => lines.on('line', (line) => line.startsWith('http') && resolve(line.trim()))),
    ended.then((code) => Promise.reject(new Error(`the program ended with ${code}: ${log}`))),
  ]);
  return {
    url,
    pid: child.pid,
    get log() {
      return log;
    },
    /** Stops it where it is, or has it go on. */
    signal(name) {
      child.kill(name);
    },
    /** Ends it as Ctrl-C does; its exit code. */
    async stop(signal = 'SIGINT') {
      child.kill(signal);
      return ended;
    },
  };
}
