// The score table of a board, and what it comes to in words.

function spreadCell([mean, std], digits) {
  if (!known(mean)) return "–";
  return [fixed(mean, digits), known(std) ? el("span", { class: "std" }, ` ± ${fixed(std, digits)}`) : null];
}

function drivingScoreCell(spread) {
  const bar = el("span", { class: "bar", "aria-hidden": "true" });
  bar.style.setProperty("--value", `${spread[0] ?? 0}%`);
  return el("span", { class: "scored" }, el("span", {}, spreadCell(spread, 1)), bar);
}

function scoreColumn({ name, label, digits, better, about }) {
  return {
    head: label,
    title: about,
    start: better === "lower" ? 1 : -1,
    numeric: true,
    value: (line) => scoreOf(line, name)[0],
    cell: (line) => (name === RANKED ? drivingScoreCell(scoreOf(line, name)) : spreadCell(scoreOf(line, name), digits)),
  };
}

function scoreColumns(board, openEpisodes) {
  return [
    {
      head: "Planner",
      title: "As it was asked for",
      value: (line) => line.planner.toLowerCase(),
      cell: (line) => plannerCell(board, line, openEpisodes),
    },
    ...DATA.scores.map(scoreColumn),
    {
      head: "IT ms",
      title: "Inference time: one forward pass of the network",
      numeric: true,
      value: (line) => line.it,
      cell: (line) => el("span", { title: timeNote(line) }, fixed(line.it, 2)),
    },
    {
      head: "RFDS",
      title: "Relative filtered driving score, percent",
      start: -1,
      numeric: true,
      value: (line) => line.rfds[0],
      cell: (line) => el("span", { title: line.ranker ? `ranked by ${line.ranker}` : null }, spreadCell(line.rfds, 1)),
    },
    { head: "Inputs", title: "What it is given", value: (line) => line.inputs.join(" "), cell: inputsCell },
    { head: "Track", title: "Sensors, objects (a perfect perception) or privileged (the simulator's knowledge)", value: (line) => line.track, cell: (line) => line.track || "–" },
    {
      head: "Parameters",
      title: "Of its network",
      numeric: true,
      value: (line) => line.parameters,
      cell: (line) => (known(line.parameters) ? millions(line.parameters) : "–"),
    },
    { head: "Date", title: "Day of its newest episode", value: (line) => line.date || null, cell: (line) => el("span", { class: "nowrap" }, line.date || "–") },
    {
      head: "Episodes",
      title: "Finished, of those that there should be",
      numeric: true,
      value: (line) => line.episodes,
      cell: episodesCell,
    },
  ];
}

const millions = (count) => (count >= 1e6 ? `${(count / 1e6).toFixed(2)} M` : String(count));

function timeNote(line) {
  if (!known(line.it)) return null;
  const tokens = known(line.tokens) ? ` at ${Math.round(line.tokens)} tokens` : "";
  return `one forward pass${tokens}, ${cut(line.processor || "processor not known", 120)}`;
}

function inputsCell(line) {
  return el("span", { class: "small inputs" }, line.inputs.map((name) => cut(name)).join(", ") || "–");
}

function episodesCell(line) {
  if (!line.episodes) return line.repetitions ? `${line.repetitions} ×` : "–";
  const whole = line.episodes === line.expected;
  return el(
    "span",
    { class: whole ? null : "partial", title: `${line.repetitions} repetitions; from ${cut(line.source, 200)}` },
    whole ? String(line.episodes) : `${line.episodes} of ${line.expected}`,
  );
}

function plannerCell(board, line, openEpisodes) {
  if (!line.detail) return el("span", { class: "planner" }, nameOf(line.planner));
  return el(
    "button",
    { type: "button", class: "planner link", title: "Its episodes, the worst first", onclick: () => openEpisodes({ planner: line }) },
    nameOf(line.planner),
  );
}

/** The verdict: who leads, by how much, and who cannot be told apart. */
function verdict(board) {
  const [first, second] = board.lines;
  if (!board.pairs.length) return null;
  const lead = differenceOf(board, first, second);
  const sentences = [
    el("p", { class: "lead" }, el("strong", {}, nameOf(first.planner)), ` leads with a driving score of ${fixed(first.scores[RANKED][0], 1)}.`),
  ];
  if (lead) {
    const told = lead.told ? "The difference is real" : "The two cannot be told apart";
    sentences.push(
      el("p", {}, `It is ${fixed(Math.abs(lead.mean), 1)} ${lead.mean < 0 ? "behind" : "ahead of"} `, nameOf(second.planner),
        ` on the routes and seeds that both drove, ${interval(lead)}. `, el("strong", {}, `${told}.`)),
    );
  }
  const close = board.pairs.filter((pair) => !pair.told && !(pair.better === first && pair.worse === second) && !(pair.better === second && pair.worse === first));
  if (close.length) sentences.push(closePairs(close));
  return el("div", { class: "verdict" }, sentences);
}

function closePairs(pairs) {
  const most = 4;
  const parts = pairs.slice(0, most).flatMap((pair, place) => [
    place ? "; " : "",
    nameOf(pair.better.planner, 24),
    " and ",
    nameOf(pair.worse.planner, 24),
    ` (${signed(pair.mean, 1)})`,
  ]);
  const more = pairs.length > most ? `; and ${pairs.length - most} more pairs` : "";
  return el("p", { class: "muted" }, "Not told apart: ", parts, `${more}.`);
}

/** The interval of a difference's size, and its p-value. */
function interval(pair) {
  if (!known(pair.low)) return "on too few routes for an interval";
  const [low, high] = pair.mean < 0 ? [-pair.high, -pair.low] : [pair.low, pair.high];
  return `95 % interval ${fixed(low, 1)} to ${fixed(high, 1)}, p ${pText(pair.corrected)} corrected for all pairs`.replaceAll("-", "−");
}

const pText = (p) => (!known(p) ? "not known" : p < 0.001 ? "< 0.001" : `= ${p.toFixed(3)}`);
