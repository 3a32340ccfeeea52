// @ts-check
// Entry of the leaderboard's script: puts the page together, and draws it again when the filters
// change.

/** @import { BoardSection } from "./board-section.js" */
/** @import { Board, Entry } from "./data.js" */
import { byId, element } from "../shared/dom.js";
import { boardSection } from "./board-section.js";
import { boards, filteredEntries, filters, scoreMetrics } from "./data.js";
import { truncated } from "./text.js";

const LEGEND = [
  ...scoreMetrics.map(({ label, about }) => [label, about]),
  [
    "IT",
    "Inference time: one forward pass of the planner's network, in milliseconds. " +
      "Hover over it to see the processor.",
  ],
  [
    "RFDS",
    "Relative filtered driving score: the driving score of the expert when it sees only the planner's top-ranked vehicle, " +
      "in percent of its score when it sees all.",
  ],
  [
    "Track",
    "Sensors: raw signals and the route. Objects: boxes and lights, as from a perfect perception " +
      "(what PlanT calls privileged). Privileged: what only the simulator knows.",
  ],
  [
    "Significant differences",
    "Two planners are compared on the routes and seeds that both drove. The interval is a " +
      "95 % bootstrap over routes; p comes from a sign-flip test over routes, corrected for all pairs " +
      "of the table (Holm). A difference is significant if p is at most 0.05 and the interval excludes zero.",
  ],
  [
    "Hazards",
    "Met: the hazard took place. Survived: no collision within 30 m of its place after it " +
      "began.",
  ],
];

/** @param {BoardSection[]} sections */
function connectFilters(sections) {
  const tracks = boards.flatMap(({ entries }) => entries.map(({ track }) => track));
  const towns = boards.flatMap((board) => board.towns);
  const controls = {
    text: byId("filter-text", HTMLInputElement),
    track: byId("filter-track", HTMLSelectElement),
    town: byId("filter-town", HTMLSelectElement),
    board: byId("filter-board", HTMLSelectElement),
  };
  const count = byId("filter-count", HTMLOutputElement);
  addOptions(
    controls.track,
    distinct(tracks).map((track) => [track, track]),
  );
  addOptions(
    controls.town,
    distinct(towns)
      .sort()
      .map((town) => [town, truncated(town, 40)]),
  );
  addOptions(
    controls.board,
    boards.map(({ id, title }) => [id, truncated(title, 60)]),
  );
  const redraw = () => {
    for (const section of sections) section.redraw();
    const shown = countEntries(filteredEntries);
    count.textContent = `${shown} of ${countEntries(({ entries }) => entries)} planners`;
  };
  for (const name of /** @type {(keyof typeof controls)[]} */ (Object.keys(controls))) {
    controls[name].addEventListener("input", () => {
      filters[name] = controls[name].value;
      redraw();
    });
  }
  byId("filters", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
  redraw();
}

/**
 * Options of a filter, after "all".
 * @param {HTMLSelectElement} select
 * @param {[value: string, text: string][]} options
 */
function addOptions(select, options) {
  for (const [value, text] of [["", "all"], ...options]) {
    select.append(element("option", { value }, text));
  }
}

/** @param {string[]} values */
const distinct = (values) => [...new Set(values)].filter(Boolean);

/**
 * Count rows of the boards that are not hidden.
 * @param {(board: Board) => Entry[]} entriesOf
 */
function countEntries(entriesOf) {
  return boards
    .filter(({ id }) => !filters.board || id === filters.board)
    .reduce((total, board) => total + entriesOf(board).length, 0);
}

const sections = boards.map(boardSection);
byId("boards", HTMLElement).append(...sections.map(({ section }) => section));
byId("legend", HTMLElement).append(
  ...LEGEND.flatMap(([term, text]) => [element("dt", {}, term), element("dd", {}, text)]),
);
connectFilters(sections);
// For measurements of load time: after two frames all of the above has been painted.
requestAnimationFrame(() => requestAnimationFrame(() => performance.mark("drawn")));
