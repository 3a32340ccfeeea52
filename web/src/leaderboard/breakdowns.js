// @ts-check
// Tables below a board's score table: infractions, termination, near misses and comfort, rankings.

/** @import { Board, Entry, RunEntry } from "./data.js" */
import { element } from "../shared/dom.js";
import { asWords } from "../shared/text.js";
import { infractionKinds, measureMetrics, statuses } from "./data.js";
import { spreadCell } from "./score-table.js";
import { hiddenCaption } from "./tables.js";
import { fixed, nameElement, percent, shortStatus } from "./text.js";

/**
 * A collapsed section whose content is drawn when it is first opened, and again when the filters
 * change.
 * @typedef {{section: HTMLDetailsElement, redraw: () => void}} CollapsibleSection
 */

/**
 * @param {string} id
 * @param {string} title
 * @param {string} note
 * @param {(body: HTMLElement) => void} draw
 * @returns {CollapsibleSection}
 */
export function collapsibleSection(id, title, note, draw) {
  const body = element("div", { class: "body" });
  const section = element(
    "details",
    { id, class: "drill" },
    element("summary", {}, element("h3", {}, title)),
    element("p", { class: "muted small note" }, note),
    body,
  );
  let isCurrent = false;
  const redraw = () => {
    isCurrent = section.open;
    if (section.open) draw(body);
  };
  section.addEventListener("toggle", () => {
    if (section.open && !isCurrent) redraw();
  });
  return { section, redraw };
}

/** @param {Entry[]} entries */
export function infractionTable(entries) {
  const kinds = presentKinds(entries);
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    element("th", { scope: "col", class: "number" }, "km"),
    kinds.map((kind) => {
      const unit = kind === "outside_lanes" ? " (km)" : "";
      return element("th", { scope: "col", class: "kind" }, asWords(kind), unit);
    }),
  );
  const rows = entries.map(({ planner, km, rates, details }) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(planner, 28)),
      element("td", { class: "number" }, fixed(km, 1)),
      kinds.map((kind) => {
        const total = details
          ? element("span", { class: "of" }, `${details.counts[kind]} in all`)
          : null;
        return element("td", { class: "number" }, fixed(rates[kind], 3), total);
      }),
    ),
  );
  return element(
    "table",
    {},
    hiddenCaption("Infractions per kilometre"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/**
 * The kinds of infractions that any of the planners has; imported figures may have further kinds.
 * @param {Entry[]} entries
 */
function presentKinds(entries) {
  const kinds = entries.flatMap(({ rates }) => Object.keys(rates).filter((kind) => rates[kind]));
  return [...new Set(kinds)].sort(
    (a, b) => infractionKinds.indexOf(a) - infractionKinds.indexOf(b),
  );
}

/** @param {RunEntry[]} entries */
export function terminationTable(entries) {
  const shown = statuses.filter((status) =>
    entries.some(({ details }) => details.statuses[status]),
  );
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    shown.map((status) => element("th", { scope: "col", class: "kind" }, shortStatus(status))),
    element("th", { scope: "col", class: "kind" }, "collisions"),
    element("th", { scope: "col", class: "kind" }, "of these, hit by the ego"),
  );
  const rows = entries.map(({ planner, details }) => {
    const [ego, other] = details.causes;
    const collisions = ego + other;
    return element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(planner, 28)),
      shown.map((status) =>
        element("td", { class: "number" }, String(details.statuses[status] ?? 0)),
      ),
      element("td", { class: "number" }, String(collisions)),
      element("td", { class: "number" }, collisions ? percent(ego / collisions) : "–"),
    );
  });
  return element(
    "table",
    {},
    hiddenCaption("How episodes ended, and who caused collisions"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/** @param {RunEntry[]} entries */
export function comfortTable(entries) {
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    measureMetrics.map(({ label, unit }) =>
      element(
        "th",
        { scope: "col", class: "kind" },
        label,
        unit ? element("span", { class: "of" }, unit) : null,
      ),
    ),
  );
  const rows = entries.map(({ planner, details }) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(planner, 28)),
      measureMetrics.map(({ name, digits }) =>
        element("td", { class: "number" }, fixed(details.measures[name], digits)),
      ),
    ),
  );
  return element(
    "table",
    {},
    hiddenCaption("Near misses and comfort"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/** @param {Board} board */
export function rankingTable(board) {
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Ranking"),
    element("th", { scope: "col" }, "of planner"),
    element("th", { scope: "col", class: "number" }, "RFDS %"),
    element("th", { scope: "col", class: "number" }, "episodes"),
  );
  const rows = board.rankings.map(([ranker, planner, mean, std, episodes]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(ranker)),
      element("td", {}, planner ? nameElement(planner) : "–"),
      element("td", { class: "number" }, spreadCell([mean, std], 1)),
      element("td", { class: "number" }, String(episodes)),
    ),
  );
  return element(
    "table",
    { class: "narrow" },
    hiddenCaption("Relative filtered driving score by ranking"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}
