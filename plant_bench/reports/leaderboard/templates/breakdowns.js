// The parts below a score table that open on demand: where, why and how each planner fails.

/** A part that is drawn when it is first opened, and anew when the filters change. */
function drillDown(id, title, note, draw) {
  const body = el("div", { class: "body" });
  const part = el("details", { id, class: "drill" }, el("summary", {}, el("h3", {}, title)), el("p", { class: "muted small note" }, note), body);
  let fresh = false;
  const redraw = () => {
    fresh = false;
    if (!part.open) return;
    fresh = true;
    draw(body);
  };
  part.addEventListener("toggle", () => {
    if (part.open && !fresh) redraw();
  });
  return { part, redraw };
}

function infractionTable(lines) {
  const kinds = [...new Set(lines.flatMap((line) => Object.keys(line.rates).filter((kind) => line.rates[kind])))]
    .sort((a, b) => DATA.kinds.indexOf(a) - DATA.kinds.indexOf(b));
  const head = el("tr", {}, el("th", { scope: "col" }, "Planner"), el("th", { scope: "col", class: "number" }, "km"),
    kinds.map((kind) => el("th", { scope: "col", class: "kind" }, words(kind), kind === "outside_lanes" ? " (km)" : "")));
  const total = (line, kind) => (line.detail ? el("span", { class: "of" }, `${line.detail.counts[kind]} in all`) : null);
  const rows = lines.map((line) => el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 28)),
    el("td", { class: "number" }, fixed(line.km, 1)),
    kinds.map((kind) => el("td", { class: "number" }, fixed(line.rates[kind], 3), total(line, kind)))));
  return el("table", {}, el("caption", { class: "hidden-text" }, "Infractions per kilometre"), el("thead", {}, head), el("tbody", {}, rows));
}

function endingTable(lines) {
  const statuses = DATA.statuses.filter((status) => lines.some((line) => line.detail.statuses[status]));
  const head = el("tr", {}, el("th", { scope: "col" }, "Planner"), statuses.map((status) => el("th", { scope: "col", class: "kind" }, status.replace("Failed - ", ""))),
    el("th", { scope: "col", class: "kind" }, "collisions"), el("th", { scope: "col", class: "kind" }, "of these, ego into other"));
  const rows = lines.map((line) => {
    const [ego, other] = line.detail.causes;
    return el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 28)),
      statuses.map((status) => el("td", { class: "number" }, String(line.detail.statuses[status] ?? 0))),
      el("td", { class: "number" }, String(ego + other)),
      el("td", { class: "number" }, ego + other ? percent(ego / (ego + other)) : "–"));
  });
  return el("table", {}, el("caption", { class: "hidden-text" }, "How episodes ended, and who caused collisions"), el("thead", {}, head), el("tbody", {}, rows));
}

function comfortTable(lines) {
  const head = el("tr", {}, el("th", { scope: "col" }, "Planner"), DATA.measures.map(({ label, unit }) =>
    el("th", { scope: "col", class: "kind" }, label, unit ? el("span", { class: "of" }, unit) : null)));
  const rows = lines.map((line) => el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 28)),
    DATA.measures.map(({ name, digits }) => el("td", { class: "number" }, fixed(line.detail.measures[name], digits)))));
  return el("table", {}, el("caption", { class: "hidden-text" }, "Near misses and comfort"), el("thead", {}, head), el("tbody", {}, rows));
}

function rankingTable(board) {
  const head = el("tr", {}, ["Ranking", "of planner", "RFDS %", "episodes"].map((name, place) => el("th", { scope: "col", class: place > 1 ? "number" : null }, name)));
  const rows = board.rankings.map(([ranker, planner, mean, std, episodes]) => el("tr", {}, el("th", { scope: "row" }, nameOf(ranker)),
    el("td", {}, planner ? nameOf(planner) : "–"), el("td", { class: "number" }, spreadCell([mean, std], 1)), el("td", { class: "number" }, String(episodes))));
  return el("table", { class: "narrow" }, el("caption", { class: "hidden-text" }, "Relative filtered driving score by ranking"), el("thead", {}, head), el("tbody", {}, rows));
}
