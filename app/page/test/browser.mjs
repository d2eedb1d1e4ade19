// SPDX-License-Identifier: Apache-2.0
// A headless Chromium for tests of the page.

import {spawnSync} from 'node:child_process';
import {mkdtemp, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {chromium} from 'playwright-core';

const kSkipped = 77; // what ctest takes for a test that was skipped

/** How long what must happen may take: machines may be slow, or busy. */
export const kPatience_ms = 120_000;

/** Where Chromium is; ends the process with a message if it is nowhere. */
export function findChromium() {
  const places = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/google-chrome', '/usr/bin/chromium-browser'];
  // Ubuntu's chromium-browser may only say that there is a snap.
  const found = places.find((place) => place && spawnSync(place, ['--version'], {stdio: 'ignore'}).status === 0);
  if (found) return found;
  console.log('skipped: no Chromium here; CHROMIUM=/path/to/it names one');
  process.exit(kSkipped);
}

/**
 * Opens a window with a profile of its own: {page, problems, requests, close}. `problems` collects errors of the console and
 * of the page, `requests` the addresses that the page asked for.
 */
export async function openBrowser({width = 1280, height = 800, colorScheme = 'light'} = {}) {
  const profile = await mkdtemp(join(tmpdir(), 'thenar-browser-'));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: findChromium(),
    headless: true,
    viewport: {width, height},
    colorScheme,
    args: [
      '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
      '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    ],
  });
  context.setDefaultTimeout(kPatience_ms);
  const page = context.pages()[0] ?? (await context.newPage());
  const problems = [];
  const requests = [];
  page.on('console', (message) => message.type() === 'error' && problems.push(message.text()));
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('request', (request) => requests.push(request.url()));
  return {
    page,
    problems,
    requests,
    async close() {
      await context.close();
      await rm(profile, {recursive: true, force: true});
    },
  };
}
