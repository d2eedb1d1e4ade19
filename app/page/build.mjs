// SPDX-License-Identifier: Apache-2.0
// Bundles the page into one html file: node build.mjs SOURCE NODE_MODULES GUIDES OUT.html
// GUIDES is docs/guide, of which the page has its texts.

import {readdir, readFile, writeFile} from 'node:fs/promises';
import {createRequire} from 'node:module';
import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

import {checkParts, readGuide} from './guide.mjs';

const [source, modules, guides, out] = process.argv.slice(2).map((path) => resolve(path));
if (!out) {
  console.error('usage: node build.mjs SOURCE NODE_MODULES GUIDES OUT.html');
  process.exit(2);
}

const folder = join(source, 'src');
const sources = (await readdir(folder)).filter((name) => /\.(js|html)$/.test(name));
const guide = readGuide(await readFile(join(guides, 'window.md'), 'utf8'));
checkParts(guide, await Promise.all(sources.map((name) => readFile(join(folder, name), 'utf8'))));

// The packages may lie elsewhere than beside this file, where the build keeps them out of the source.
const esbuild = createRequire(join(modules, 'x.js'))('esbuild');
const bundle = async (file) => {
  const result = await esbuild.build({
    entryPoints: [join(folder, file)],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: 'es2022',
    charset: 'utf8',
    legalComments: 'eof',
    nodePaths: [modules],
    define: {GUIDE: JSON.stringify(guide)},
  });
  return result.outputFiles[0].text;
};

// The colours that mean something, as variables of the style sheet.
const {default: palette} = await import(pathToFileURL(join(folder, 'palette.js')));
const variables = (colors) => `:root{${Object.entries(colors).map(([name, color]) => `--${name}:${color};`).join('')}}`;
const colors = `${variables(palette.light)}@media (prefers-color-scheme:dark){${variables(palette.dark)}}\n`;

const template = await readFile(join(folder, 'page.html'), 'utf8');
const script = (await bundle('main.js')).replaceAll('</script', '<\\/script');
const style = colors + (await bundle('style.css'));
// Functions, so that a $ in the bundle is no pattern.
const page = template
  .replace('<!-- style -->', () => `<style>\n${style}</style>`)
  .replace('<!-- script -->', () => `<script>\n${script}</script>`);
// The server and the export replace these texts: each must stand there once.
for (const place of ['data-source="live"', '<!-- recording -->']) {
  if (page.split(place).length !== 2) throw new Error(`the page must contain ${place} once`);
}
await writeFile(out, page);
