// SPDX-License-Identifier: Apache-2.0
// What docs/guide says of the parts of the page, and of keys and mouse: {parts, inputs}.

/** The rows of the table below a heading of Markdown, without header and marks. */
function rowsBelow(markdown, heading) {
  const section = markdown.split(/^###? /m).find((text) => text.startsWith(`${heading}\n`));
  if (!section) throw new Error(`the guide has no section '${heading}'`);
  const rows = section.split('\n').filter((line) => line.startsWith('|'));
  if (rows.length < 3) throw new Error(`the guide has no table in '${heading}'`);
  const cell = (text) => text.trim().replaceAll(/[`*]/g, '');
  return rows.slice(2).map((row) => row.split('|').slice(1, -1).map(cell));
}

/** `window`: the text of docs/guide/window.md. */
export function readGuide(window) {
  const parts = {};
  const add = (name, text) => {
    if (name in parts) throw new Error(`the guide has the part '${name}' twice`);
    parts[name] = text;
  };
  for (const [name, text] of rowsBelow(window, 'What the page shows')) add(name, text);
  const inputs = rowsBelow(window, 'What you can do').map(([input, does, where]) => {
    if (!['', 'live', 'recording'].includes(where)) throw new Error(`the guide has '${input}' with '${where}'`);
    return {input, does, where};
  });
  return {parts, inputs};
}

/** Throws if the sources name a part that the guide has not, or if it has one that they do not name. */
export function checkParts({parts}, sources) {
  const named = new Set(sources.flatMap((text) => [...text.matchAll(/data-tip="([^"]*)"|\btip: '([^']*)'|\btip\('([^']*)'\)/g)]
      .map(([, ...names]) => names.find((name) => name !== undefined))));
  for (const name of named) if (!(name in parts)) throw new Error(`docs/guide does not say what '${name}' is`);
  for (const name of Object.keys(parts)) {
    if (!named.has(name)) throw new Error(`the page has no '${name}', of which docs/guide/window.md tells`);
  }
}
