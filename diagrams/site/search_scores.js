/* Pages of the guide come before pages that are made from code, their gallery and the changelog. */
var Scorer = {
  score: ([docname, title, anchor, description, score]) =>
    /^(api\/|graphs\/|README$|changelog$)/.test(docname) ? score : score + 30,
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
