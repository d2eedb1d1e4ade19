// SPDX-License-Identifier: Apache-2.0
// How results of the search are ordered: Sphinx's own points, more for a page whose title and headings have the words of the
// question, and for guides and references. A name of C++ or Python leads to its declaration. Sphinx declares Scorer, too.
var Scorer = {
  question: () => (new URLSearchParams(window.location.search).get('q') || '').toLowerCase(),

  /** Headings of each page, in small letters. */
  headings: new Map(),

  readHeadings() {
    for (const [heading, places] of Object.entries(Search._index.alltitles)) {
      for (const [file] of places) {
        const page = Search._index.docnames[file];
        Scorer.headings.set(page, `${Scorer.headings.get(page) || ''} ${heading.toLowerCase()}`);
      }
    }
  },

  /** Share of the question's words that a text has, without the endings of plurals and verbs. */
  share(text) {
    const words = Scorer.question().split(/[^a-z0-9_]+/).filter((word) => word && !stopwords.includes(word));
    return words.filter((word) => text.includes(word.replace(/(ing|ed|s)$/, ''))).length / Math.max(words.length, 1);
  },

  score: ([page, title, anchor, description, points]) => {
    if (Scorer.headings.size === 0) Scorer.readHeadings();
    const kinds = [[/^docs\/guide\//, 40], [/^docs\/(reference|site)\//, 35], [/^docs\//, 10], [/^/, 0]];
    let more = kinds.find(([kind]) => kind.test(page))[1];
    if (description !== null && /[._]/.test(Scorer.question())) more += 60;  // A declaration, and a name that is asked for.
    return points + more + 20 * Scorer.share(title.toLowerCase()) + 20 * Scorer.share(Scorer.headings.get(page) || '');
  },

  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: {0: 15, 1: 5, 2: -5},
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
