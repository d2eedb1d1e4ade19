// SPDX-License-Identifier: Apache-2.0
// Does the contact loop notice who watches? Its compute time with a page that renders on the same cores over that
// without, in turns in one session.
//     node load.mjs THENAR-WINDOW CONFIGS [PAIRS] [SECONDS]

import {join} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';

import {openBrowser} from './browser.mjs';
import {crowd, look} from './client.mjs';
import {startProgram} from './program.mjs';

const [program, configs, pairs = '5', seconds = '8'] = process.argv.slice(2);
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** The median over some seconds of each second's p99 [us], of the contact loop's compute time. */
async function measure(url) {
  await sleep(2000);
  const p99 = [], p50 = [];
  let last = null;
  for (let i = 0; i < Number(seconds); ++i) {
    await sleep(1000);
    last = await look(url);
    p50.push(last.contact_compute_us[0]);
    p99.push(last.contact_compute_us[1]);
  }
  return {p50_us: median(p50), p99_us: median(p99), last};
}

const server = await startProgram(program, [join(configs, 'box_grasp.yaml'), '--port', '0', '--quiet']);
const ratios = [];
const crowdRatios = [];
console.log('contact compute, us: alone p50, p99; with a page; with it and eleven more; fps; ratios of p99 over alone');
for (let pair = 0; pair < Number(pairs); ++pair) {
  const without = await measure(server.url);
  const browser = await openBrowser();
  await browser.page.goto(server.url);
  await browser.page.waitForFunction(() => window.thenar?.drawn > 10, null, {timeout: 60_000});
  const watched = await measure(server.url);
  const leave = await crowd(server.url);
  const crowded = await measure(server.url);
  leave();
  const fps = await browser.page.evaluate(() => window.thenar.fps);
  await browser.close();
  ratios.push(watched.p99_us / without.p99_us);
  crowdRatios.push(crowded.p99_us / without.p99_us);
  const row = [without, watched, crowded].flatMap(({p50_us, p99_us}) => [p50_us, p99_us]).map((us) => us.toFixed(1).padStart(8));
  console.log(`${pair + 1}    ${row.join('')}   ${fps.toFixed(0).padStart(4)}   ${ratios.at(-1).toFixed(2)}   ${crowdRatios.at(-1).toFixed(2)}`);
}
// Frames are counted when the loops rest.
const end = await look(server.url, '{"type":"pause"}', 500);
console.log(`ratio of p99, median of ${pairs} pairs: ${median(ratios).toFixed(2)}, in a crowd ${median(crowdRatios).toFixed(2)}; frames unaccounted ${end.unaccounted[0]}, ` +
            `residual ${end.residual[0].toExponential(1)}, slipped ticks ${end.contact_slipped[0]} of ${end.tick[0]}`);
await server.stop();
if (!(median(ratios) <= 1.2 && end.unaccounted[0] === 0)) {
  console.log('the contact loop noticed: at most 1.2 and 0 were asked for');
  process.exitCode = 1;
}
