// @ts-check
// The list of episodes: each with its infractions and its replay; two can be selected to compare.

/** @import { Content } from "../shared/dom.js" */
/** @import { Board, Entry, Episode } from "./data.js" */
import { byId, element, replaceContent } from "../shared/dom.js";
import { asWords } from "../shared/text.js";
import { episodeMetrics, filters, rankedMetric } from "./data.js";
import { hiddenCaption, scrollable } from "./tables.js";
import {
  fixed,
  formatDuration,
  isKnown,
  nameElement,
  pluralized,
  shortStatus,
  truncated,
} from "./text.js";

/**
 * Which episodes are listed, and how many of them.
 * @typedef {object} EpisodeQuery
 * @property {Entry} [entry]
 * @property {string} [route]
 * @property {number} [limit]
 *
 * @typedef {(query: EpisodeQuery) => void} OpenEpisodes opens the list, scrolled into view
 */

const PAGE_SIZE = 40; // episodes before "Show more"
const LISTED_INFRACTIONS = 4; // of an episode, before "more"

/** @type {Episode[]} at most two, of one scenario */
const selected = [];

/**
 * @param {Board} board
 * @param {EpisodeQuery} query changed by the list's controls
 * @param {() => void} redraw
 * @returns {Content[]}
 */
export function episodeList(board, query, redraw) {
  const found = matchingEpisodes(board, query);
  const shown = found.slice(0, query.limit ?? PAGE_SIZE);
  const headers = [
    ...["Planner", "Route"].map((text) => element("th", { scope: "col" }, text)),
    ...[...episodeMetrics.map((metric) => metric.label), "Time"].map((text) =>
      element("th", { scope: "col", class: "number" }, text),
    ),
    ...["Ended", "What happened", "Replay"].map((text) => element("th", { scope: "col" }, text)),
  ];
  const table = element(
    "table",
    { class: "episodes" },
    hiddenCaption("Episodes, the lowest driving score first"),
    element("thead", {}, element("tr", {}, headers)),
    element(
      "tbody",
      {},
      shown.map((item) => episodeRow(board, item)),
    ),
  );
  const showMore = () => {
    query.limit = shown.length + 5 * PAGE_SIZE;
    redraw();
  };
  const left = found.length - shown.length;
  const more = left
    ? element("button", { type: "button", onclick: showMore }, `Show more (${left} left)`)
    : null;
  const count = `${pluralized(found.length, "episode")}, the lowest driving score first`;
  return [
    queryControls(board, query, redraw),
    element("p", { class: "muted small", "aria-live": "polite" }, count),
    scrollable("Episodes", table),
    more,
  ];
}

/**
 * @param {Board} board
 * @param {EpisodeQuery} query
 */
function matchingEpisodes(board, { entry, route }) {
  const score = (/** @type {Episode} */ item) => item.scores[rankedMetric] ?? 0;
  return board
    .episodes()
    .filter(
      (item) =>
        (!entry || item.entry === entry) &&
        (!route || item.route === route) &&
        (!filters.town || item.town === filters.town),
    )
    .sort(
      (a, b) =>
        score(a) - score(b) || a.route.localeCompare(b.route) || a.repetition - b.repetition,
    );
}

/**
 * @param {Board} board
 * @param {EpisodeQuery} query
 * @param {() => void} redraw
 */
function queryControls(board, query, redraw) {
  const update = (/** @type {EpisodeQuery} */ change) => {
    Object.assign(query, change, { limit: PAGE_SIZE });
    redraw();
  };
  const planners = board.entries.map((entry) => ({
    value: String(entry.place),
    text: truncated(entry.planner, 40),
  }));
  const routes = board.routes.map(({ name }) => ({ value: name, text: truncated(name, 40) }));
  return element(
    "div",
    { class: "filters" },
    labelledSelect("Planner", planners, query.entry ? String(query.entry.place) : "", (value) =>
      update({ entry: value ? board.entries[Number(value)] : undefined }),
    ),
    labelledSelect("Route", routes, query.route ?? "", (value) =>
      update({ route: value || undefined }),
    ),
  );
}

/**
 * @param {string} label
 * @param {{value: string, text: string}[]} options beside "all"
 * @param {string} value
 * @param {(value: string) => void} onChange
 */
function labelledSelect(label, options, value, onChange) {
  const select = element(
    "select",
    { onchange: () => onChange(select.value) },
    [{ value: "", text: "all" }, ...options].map((option) =>
      element("option", { value: option.value, selected: option.value === value }, option.text),
    ),
  );
  return element("label", {}, label, " ", select);
}

/**
 * @param {Board} board
 * @param {Episode} episode
 */
function episodeRow(board, episode) {
  const { entry, route, repetition, scores, duration, status, reason } = episode;
  const numbers = [
    ...episodeMetrics.map(({ name, digits }) => fixed(scores[name], digits)),
    formatDuration(duration),
  ];
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, nameElement(entry.planner, 28)),
    element(
      "td",
      {},
      nameElement(route, 28),
      element("span", { class: "of" }, `repetition ${repetition}`),
    ),
    numbers.map((text) => element("td", { class: "number" }, text)),
    element(
      "td",
      { class: status === "Completed" ? null : "failed" },
      shortStatus(status),
      reason ? element("span", { class: "of reason" }, nameElement(reason, 160)) : null,
    ),
    element("td", {}, eventsCell(episode)),
    element("td", { class: "replay" }, replayCell(board, episode)),
  );
}

/**
 * An episode's infractions, and the hazards that it did not survive.
 * @param {Episode} episode
 * @returns {Content}
 */
function eventsCell(episode) {
  const items = episode.infractions.map((infraction) => {
    const { kind, time, share } = infraction;
    const extent = isKnown(share) ? ` ${(100 * share).toFixed(1)} % of the route` : "";
    const when = isKnown(share) ? null : element("span", { class: "when" }, formatDuration(time));
    return element("li", {}, when, asWords(kind), extent, collisionPartner(infraction));
  });
  if (!items.length) return element("span", { class: "muted" }, "nothing");
  const rest = items.slice(LISTED_INFRACTIONS);
  return [
    element(
      "ul",
      { class: "happenings" },
      items.slice(0, LISTED_INFRACTIONS),
      failedHazards(episode),
    ),
    rest.length
      ? element(
          "details",
          { class: "rest" },
          element("summary", {}, `${rest.length} more`),
          element("ul", { class: "happenings" }, rest),
        )
      : null,
  ];
}

/** @param {Episode["infractions"][number]} infraction */
function collisionPartner({ kind, actor, cause }) {
  if (!actor || !kind.startsWith("collision")) return "";
  return ` (${actor}${cause === "other" ? ", hit the ego" : ""})`;
}

/** @param {Episode} episode */
function failedHazards({ hazards }) {
  const failed = hazards.filter(
    ({ phase, survived }) => ["done", "committed"].includes(phase) && !survived,
  );
  const kinds = [...new Set(failed.map(({ kind }) => asWords(kind)))];
  return kinds.length ? element("li", { class: "muted" }, `hazard: ${kinds.join(", ")}`) : null;
}

/** @param {...string} ids */
const replayAddress = (...ids) => `replay.html#${ids.map(encodeURI).join("&")}`;

/**
 * @param {Board} board
 * @param {Episode} episode
 * @returns {Content}
 */
function replayCell(board, episode) {
  if (!episode.hasReplay) return element("span", { class: "muted" }, "not recorded");
  const planner = truncated(episode.entry.planner, 40);
  const route = truncated(episode.route, 60);
  const name = `${planner}, ${route}, repetition ${episode.repetition}`;
  const isSelected = () => String(selected.includes(episode));
  const compare = element(
    "button",
    {
      type: "button",
      class: "small",
      "aria-pressed": isSelected(),
      "aria-label": `Compare ${name}`,
      onclick: () => {
        toggleSelected(board, episode);
        compare.setAttribute("aria-pressed", isSelected());
      },
    },
    "Compare",
  );
  const watch = element(
    "a",
    { href: replayAddress(episode.id), "aria-label": `Watch ${name}` },
    "Watch",
  );
  return [watch, " ", compare];
}

/**
 * Select or deselect an episode. A third one replaces the first, one of another scenario both.
 * @param {Board} board
 * @param {Episode} episode
 */
function toggleSelected(board, episode) {
  const place = selected.indexOf(episode);
  if (place >= 0) selected.splice(place, 1);
  else {
    const [first] = selected;
    if (first && (first.scenario !== episode.scenario || first.route !== episode.route)) {
      selected.length = 0;
    }
    if (selected.length === 2) selected.shift();
    selected.push(episode);
  }
  showSelected(board);
}

/** @param {Board} board */
function showSelected(board) {
  const panel = byId("picks", HTMLElement);
  panel.hidden = !selected.length;
  if (!selected.length) return;
  const [first, second] = selected;
  const planner = (/** @type {Episode} */ episode) =>
    element("strong", {}, nameElement(episode.entry.planner, 24));
  const title = element(
    "p",
    {},
    planner(first),
    second ? [" and ", planner(second)] : "",
    " on ",
    nameElement(first.route, 28),
    `, repetition ${first.repetition}`,
  );
  const action = second
    ? element(
        "a",
        { class: "action", href: replayAddress(first.id, second.id) },
        "Watch side by side",
      )
    : comparisonChoices(board, first);
  const clear = element("button", { type: "button", onclick: () => clearSelected(board) }, "Clear");
  replaceContent(panel, title, action, clear);
}

/**
 * Buttons for the episodes that can be compared with one.
 * @param {Board} board
 * @param {Episode} episode
 */
function comparisonChoices(board, episode) {
  const others = board
    .episodes()
    .filter(
      (item) => item.scenario === episode.scenario && item.hasReplay && !selected.includes(item),
    );
  return element(
    "span",
    { class: "choices" },
    others.length ? "compare with: " : "no other planner was recorded in this scenario",
    others.map((item) =>
      element(
        "button",
        { type: "button", onclick: () => toggleSelected(board, item) },
        nameElement(item.entry.planner, 20),
      ),
    ),
  );
}

/** @param {Board} board */
function clearSelected(board) {
  selected.length = 0;
  showSelected(board);
  for (const button of document.querySelectorAll("td.replay [aria-pressed]")) {
    button.setAttribute("aria-pressed", "false");
  }
}
