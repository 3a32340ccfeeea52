// Plots (Observable Plot). Each has a label and its numbers in a table elsewhere on the page.

const LABEL_WIDTH = () => (innerWidth < 560 ? 110 : 190);
const BARE = { background: "transparent", color: "var(--text)", fontFamily: "var(--font)", fontSize: "12.5px", overflow: "visible" };

/** Plots that are drawn anew when their place's width or the theme changes. */
function plotIn(place, label, make) {
  let width = 0;
  const draw = () => {
    width = place.clientWidth;
    if (!width) return;
    const plot = make(width);
    plot.querySelectorAll("[aria-label]").forEach((part) => part.removeAttribute("aria-label"));
    plot.setAttribute("role", "img"); // one picture to those who cannot see it, not many parts
    plot.setAttribute("aria-label", label);
    plot.removeAttribute("aria-roledescription");
    fill(place, plot);
  };
  new ResizeObserver(() => {
    if (Math.abs(place.clientWidth - width) > 2) draw();
  }).observe(place);
  return draw;
}

/** Names for an axis: text from outside, cut, and unlike each other. */
function axisNames(lines, letters) {
  const seen = new Map();
  return lines.map((line) => {
    const name = cut(line.planner.replace(/\p{C}/gu, "").replace(/\s+/g, " "), letters);
    const count = (seen.get(name) ?? 0) + 1;
    seen.set(name, count);
    return count > 1 ? `${name} #${count}` : name;
  });
}

/** Differences of all planners from one of them, with intervals. */
function forestPlot(board, lines, reference, width) {
  const names = axisNames(lines, width < 560 ? 14 : 24);
  const rows = lines.map((line, place) => {
    const pair = line === reference ? null : differenceOf(board, line, reference);
    return { name: names[place], line, pair, side: !pair?.told ? "even" : pair.mean > 0 ? "ahead" : "behind" };
  });
  const pairs = rows.filter((row) => row.pair);
  const colours = { ahead: "var(--good)", behind: "var(--bad)", even: "var(--muted)" };
  const tip = (row) =>
    `${row.name}: ${signed(row.pair.mean, 1)} DS\n` +
    (known(row.pair.low) ? `95 % interval ${signed(row.pair.low, 1)} to ${signed(row.pair.high, 1)}\n` : "too few routes\n") +
    `p ${pText(row.pair.corrected)} after correction`;
  return Plot.plot({
    width,
    height: 60 + 26 * rows.length,
    marginLeft: LABEL_WIDTH(),
    marginRight: 16,
    marginBottom: 46,
    style: BARE,
    x: { label: `DS against ${cut(reference.planner, 24)}`, grid: true, nice: true, labelAnchor: "center" },
    y: { label: null, domain: names },
    marks: [
      Plot.ruleX([0], { stroke: "var(--line-strong)" }),
      Plot.ruleY(pairs.filter((row) => known(row.pair.low)), {
        y: "name", x1: (row) => row.pair.low, x2: (row) => row.pair.high, stroke: (row) => colours[row.side], strokeWidth: 2.5,
      }),
      Plot.dot(pairs, {
        y: "name", x: (row) => row.pair.mean, r: 5, stroke: (row) => colours[row.side], strokeWidth: 2,
        fill: (row) => (row.side === "even" ? "var(--page)" : colours[row.side]),
      }),
      Plot.dot(rows.filter((row) => row.line === reference), { y: "name", x: 0, symbol: "diamond", r: 5, fill: "var(--text)" }),
      Plot.tip(pairs, Plot.pointerY({ y: "name", x: (row) => row.pair.mean, title: tip, fill: "var(--raised)", stroke: "var(--line-strong)" })),
    ],
  });
}

const BIN = 5; // DS of a bin of episodes

/** How the episodes of each planner scored: a dot a bin, its area the share of episodes in it. */
function episodePlot(board, lines, width) {
  const names = axisNames(lines, width < 560 ? 14 : 24);
  const rows = lines.flatMap((line, place) => episodeBins(board, line, names[place]));
  const means = lines.map((line, place) => ({ name: names[place], ds: scoreOf(line, RANKED)[0] })).filter((row) => known(row.ds));
  return Plot.plot({
    width,
    height: 56 + 34 * lines.length,
    marginLeft: LABEL_WIDTH(),
    marginRight: 24,
    marginBottom: 46,
    style: BARE,
    x: { label: "driving score of an episode", domain: [0, 100], grid: true, labelAnchor: "center" },
    y: { label: null, domain: names },
    r: { domain: [0, 1], range: [0, 22] },
    marks: [
      Plot.dot(rows, { x: "ds", y: "name", r: "share", fill: "var(--accent)", fillOpacity: 0.35, stroke: "var(--accent)" }),
      Plot.tickX(means, { x: "ds", y: "name", stroke: "var(--text)", strokeWidth: 2.5, insetTop: 5, insetBottom: 5 }),
      Plot.tip(rows, Plot.pointer({ x: "ds", y: "name", fill: "var(--raised)", stroke: "var(--line-strong)", title: "title" })),
    ],
  });
}

function episodeBins(board, line, name) {
  const scores = board.allEpisodes().filter((item) => item.line === line && (!FILTER.town || item.town === FILTER.town)).map((item) => item.scores[RANKED]);
  const bins = new Map();
  for (const score of scores) {
    const low = BIN * Math.min(Math.floor(score / BIN), 100 / BIN - 1);
    bins.set(low, (bins.get(low) ?? 0) + 1);
  }
  return [...bins].map(([low, count]) => ({
    name,
    ds: low + BIN / 2,
    share: count / scores.length,
    title: `${name}: ${count} of ${scores.length} episodes\nwith a driving score of ${low} to ${low + BIN}`,
  }));
}

const KIND_COLOURS = {
  collision_pedestrian: "#c2382e",
  collision_vehicle: "#e08214",
  collision_static: "#4d9a5b",
  red_light: "#7b3294",
  route_deviation: "#4393c3",
  blocked: "#737b87",
  timeout: "#a6aebb",
};

/** Infractions per kilometre, kind by kind. */
function infractionPlot(lines, width) {
  const names = axisNames(lines, width < 560 ? 14 : 24);
  const kinds = Object.keys(KIND_COLOURS);
  const rows = lines.flatMap((line, place) =>
    kinds.map((kind) => ({ name: names[place], kind: words(kind), rate: line.rates[kind] ?? 0 })).filter((row) => row.rate));
  const shown = kinds.filter((kind) => rows.some((row) => row.kind === words(kind)));
  return Plot.plot({
    width,
    height: 60 + 26 * lines.length,
    marginLeft: LABEL_WIDTH(),
    marginRight: 16,
    marginBottom: 46,
    style: BARE,
    x: { label: "infractions per km", grid: true, labelAnchor: "center" },
    y: { label: null, domain: names },
    color: { domain: shown.map(words), range: shown.map((kind) => KIND_COLOURS[kind]) },
    marks: [
      Plot.barX(rows, { x: "rate", y: "name", fill: "kind", insetTop: 2, insetBottom: 2 }),
      Plot.tip(rows, Plot.pointer(Plot.stackX({
        x: "rate", y: "name", fill: "var(--raised)", stroke: "var(--line-strong)", z: "kind", title: (row) => `${row.name}\n${row.kind}: ${row.rate.toFixed(2)} per km`,
      }))),
    ],
  });
}

function plotKey(lines) {
  const kinds = Object.keys(KIND_COLOURS).filter((kind) => lines.some((line) => line.rates[kind]));
  return el("ul", { class: "key small" }, kinds.map((kind) => {
    const swatch = el("span", { class: "swatch", "aria-hidden": "true" });
    swatch.style.background = KIND_COLOURS[kind];
    return el("li", {}, swatch, words(kind));
  }));
}
