// Who beats whom: each planner of a row against each of a column.

function beatMatrix(board, lines) {
  const head = el(
    "tr",
    {},
    el("th", { scope: "col" }, "row against column"),
    lines.map((line) => el("th", { scope: "col", class: "against" }, nameOf(line.planner, 18))),
  );
  const rows = lines.map((first) =>
    el(
      "tr",
      {},
      el("th", { scope: "row" }, nameOf(first.planner, 28)),
      lines.map((second) => matrixCell(board, first, second)),
    ),
  );
  const caption = el("caption", { class: "hidden-text" }, "Difference in driving score of each two planners");
  return el("table", { class: "matrix" }, caption, el("thead", {}, head), el("tbody", {}, rows));
}

function matrixCell(board, first, second) {
  if (first === second) return el("td", { class: "same" }, el("span", { class: "hidden-text" }, "the same planner"));
  const pair = differenceOf(board, first, second);
  if (!pair) return el("td", { class: "muted" }, "–");
  const side = !pair.told ? "even" : pair.mean > 0 ? "ahead" : "behind";
  const verdict = { even: "not told apart", ahead: "ahead", behind: "behind" }[side];
  const ends = known(pair.low) ? `${signed(pair.low, 0)} to ${signed(pair.high, 0)}` : "too few routes";
  return el(
    "td",
    { class: side, title: `95 % interval ${ends}; p ${pText(pair.corrected)} after correction; ${pair.pairs} pairs on ${pair.routes} routes` },
    el("span", { class: "mean" }, side === "even" ? "≈ " : "", signed(pair.mean, 1)),
    el("span", { class: "ends" }, ends),
    el("span", { class: "hidden-text" }, `, ${verdict}`),
  );
}
