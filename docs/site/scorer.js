// SPDX-License-Identifier: Apache-2.0
// How results of the search are ordered: Sphinx's own points, and more for pages that are read first.
const Scorer = {
  score: ([page, title, anchor, description, points]) => {
    if (page.startsWith('docs/guide/')) return points + 30;
    if (page.startsWith('docs/reference/') || page === 'docs/site/python') return points + 20;
    return points + (page.startsWith('docs/') ? 10 : 0);
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
