// The list of episodes: each with its infractions and its replay; two can be picked to compare.

const AT_ONCE = 40; // episodes shown before "more"
const PICKED = [];

function episodeList(board, chosen, redraw) {
  const { planner, route, scenario } = chosen;
  const found = board.allEpisodes()
    .filter((item) => (!planner || item.line === planner) && (!route || item.route === route) &&
      (!known(scenario) || item.scenario === scenario) && (!FILTER.town || item.town === FILTER.town))
    .sort((a, b) => a.scores[RANKED] - b.scores[RANKED] || a.route.localeCompare(b.route) || a.repetition - b.repetition);
  const shown = found.slice(0, chosen.most ?? AT_ONCE);
  const numbers = [...EPISODE_SCORES.map((score) => score.label), "Time"];
  const head = el("tr", {}, ["Planner", "Route", ...numbers, "Ended", "What happened", "Replay"].map((name) =>
    el("th", { scope: "col", class: numbers.includes(name) ? "number" : null }, name)));
  const table = el("table", { class: "episodes" }, el("caption", { class: "hidden-text" }, "Episodes, the lowest driving score first"),
    el("thead", {}, head), el("tbody", {}, shown.map((item) => episodeRow(board, item))));
  const more = shown.length < found.length
    ? el("button", { type: "button", onclick: () => { chosen.most = shown.length + 5 * AT_ONCE; redraw(); } }, `Show more (${found.length - shown.length} left)`)
    : null;
  const count = `${counted(found.length, "episode")}, the lowest driving score first`;
  return [episodeChoice(board, chosen, redraw), el("p", { class: "muted small", "aria-live": "polite" }, count), scrolling("Episodes", table), more];
}

function episodeChoice(board, chosen, redraw) {
  const select = (label, options, value, choose) => el("label", {}, label, " ", el("select", { onchange: (event) => { choose(event.target.value); redraw(); } },
    options.map(([key, text]) => el("option", { value: key, selected: key === value }, text))));
  const planners = [["", "all"], ...board.lines.map((line) => [String(line.place), cut(line.planner, 40)])];
  const routes = [["", "all"], ...board.routes.map(([name]) => [name, cut(name, 40)])];
  const drop = () => { chosen.scenario = undefined; chosen.most = AT_ONCE; };
  return el("div", { class: "filters" },
    select("Planner", planners, chosen.planner ? String(chosen.planner.place) : "", (value) => { drop(); chosen.planner = value ? board.lines[Number(value)] : undefined; }),
    select("Route", routes, chosen.route ?? "", (value) => { drop(); chosen.route = value || undefined; }),
    known(chosen.scenario) ? el("button", { type: "button", onclick: () => { drop(); redraw(); } }, "All scenarios") : null);
}

function episodeRow(board, item) {
  const failed = item.status !== "Completed";
  const cells = [...EPISODE_SCORES.map((score) => fixed(item.scores[score.name], score.digits)), clock(item.duration)];
  return el("tr", {},
    el("th", { scope: "row" }, nameOf(item.line.planner, 28)),
    el("td", {}, nameOf(item.route, 28), el("span", { class: "of" }, `repetition ${item.repetition + 1}`)),
    cells.map((text) => el("td", { class: "number" }, text)),
    el("td", { class: failed ? "failed" : null }, item.status.replace("Failed - ", ""), item.reason ? el("span", { class: "of reason" }, nameOf(item.reason, 160)) : null),
    el("td", {}, happenings(item)),
    el("td", { class: "replay" }, replayCell(board, item)));
}

const HAPPENINGS = 4; // infractions told before "more"

function happenings(item) {
  const parts = item.infractions.map((part) => {
    const share = known(part.share) ? ` ${(100 * part.share).toFixed(1)} % of the way` : "";
    const who = part.actor && part.kind.startsWith("collision") ? ` (${part.actor}${part.cause === "other" ? ", ran into the ego" : ""})` : "";
    return el("li", {}, known(part.share) ? null : el("span", { class: "when" }, clock(part.time)), words(part.kind), share, who);
  });
  const hurt = [...new Set(item.hazards.filter((hazard) => ["done", "committed"].includes(hazard.phase) && !hazard.survived).map((hazard) => words(hazard.kind)))];
  const blamed = hurt.length ? el("li", { class: "muted" }, `hazard: ${hurt.join(", ")}`) : null;
  if (!parts.length) return el("span", { class: "muted" }, "nothing");
  const rest = parts.slice(HAPPENINGS);
  return [
    el("ul", { class: "happenings" }, parts.slice(0, HAPPENINGS), blamed),
    rest.length ? el("details", { class: "rest" }, el("summary", {}, `${rest.length} more`), el("ul", { class: "happenings" }, rest)) : null,
  ];
}

const replayAddress = (...ids) => `replay.html#${ids.map(encodeURI).join("&")}`;

function replayCell(board, item) {
  if (!item.replay) return el("span", { class: "muted" }, "not recorded");
  const name = `${cut(item.line.planner, 40)}, ${cut(item.route, 60)}, repetition ${item.repetition + 1}`;
  const pick = el("button", {
    type: "button", class: "small", "aria-pressed": String(PICKED.includes(item)), "aria-label": `Compare ${name}`,
    onclick: () => { togglePick(board, item); pick.setAttribute("aria-pressed", String(PICKED.includes(item))); },
  }, "Compare");
  return [el("a", { href: replayAddress(item.id), "aria-label": `Watch ${name}` }, "Watch"), " ", pick];
}

/** Pick an episode, or drop it; of three the one picked first is dropped, of another scenario all are. */
function togglePick(board, item) {
  const place = PICKED.indexOf(item);
  if (place >= 0) PICKED.splice(place, 1);
  else {
    if (PICKED.length && (PICKED[0].scenario !== item.scenario || PICKED[0].route !== item.route)) PICKED.length = 0;
    if (PICKED.length === 2) PICKED.shift();
    PICKED.push(item);
  }
  showPicks(board);
}

function showPicks(board) {
  const place = document.getElementById("picks");
  place.hidden = !PICKED.length;
  if (!PICKED.length) return;
  const [first, second] = PICKED;
  const others = board.allEpisodes().filter((item) => item.scenario === first.scenario && item.replay && !PICKED.includes(item));
  const title = el("p", {}, el("strong", {}, nameOf(first.line.planner, 24)), second ? [" and ", el("strong", {}, nameOf(second.line.planner, 24))] : "",
    " on ", nameOf(first.route, 28), `, repetition ${first.repetition + 1}`);
  const action = second
    ? el("a", { class: "action", href: replayAddress(first.id, second.id) }, "Watch side by side")
    : el("span", { class: "choices" }, others.length ? "beside: " : "nobody else was recorded in this scenario",
      others.map((item) => el("button", { type: "button", onclick: () => togglePick(board, item) }, nameOf(item.line.planner, 20))));
  const close = el("button", { type: "button", onclick: () => { PICKED.length = 0; showPicks(board); document.querySelectorAll("td.replay [aria-pressed]").forEach((button) => button.setAttribute("aria-pressed", "false")); } }, "Clear");
  fill(place, title, action, close);
}
