// @ts-check
// A board's section of the page: its score table, and the breakdowns below.

/** @import { CollapsibleSection } from "./breakdowns.js" */
/** @import { Board } from "./data.js" */
/** @import { EpisodeQuery } from "./episode-list.js" */
import { element, replaceContent } from "../shared/dom.js";
import {
  collapsibleSection,
  comfortTable,
  infractionTable,
  rankingTable,
  terminationTable,
} from "./breakdowns.js";
import { filteredEntries, filteredRuns, filters } from "./data.js";
import { differenceMatrix } from "./difference-matrix.js";
import { episodeList } from "./episode-list.js";
import { hazardHeatmap, routeHeatmap, townHeatmap } from "./heatmaps.js";
import {
  differencePlot,
  episodePlot,
  infractionPlot,
  infractionPlotKey,
  plotInto,
} from "./plots.js";
import { scoreColumns } from "./score-table.js";
import { scrollable, sortableTable } from "./tables.js";
import { nameElement, pluralized, truncated } from "./text.js";
import { verdict } from "./verdict.js";

/** @typedef {{section: HTMLElement, redraw: () => void}} BoardSection */

/**
 * @param {Board} board
 * @returns {BoardSection}
 */
export function boardSection(board) {
  const breakdowns = breakdownSections(board);
  const order = { column: 1, direction: -1 }; // the driving score, the highest first
  const table = element("div");
  const drawTable = (/** @type {number} */ focusedColumn = -1) => {
    const sorted = sortableTable({
      caption: `Scores: ${board.title}`,
      columns: scoreColumns(breakdowns.openEpisodes),
      rows: filteredEntries(board),
      order,
      redraw: drawTable,
      isLast: (entry) => !entry.complete, // its means are of fewer routes
    });
    replaceContent(table, scrollable("Scores", sorted));
    if (focusedColumn >= 0) sorted.querySelectorAll("button")[focusedColumn].focus();
  };
  const differences = board.differences.length ? differencesSection(board) : null;
  const titleId = `${board.id}-title`;
  const section = element(
    "section",
    { class: board.isImported ? "board elsewhere" : "board", "aria-labelledby": titleId },
    element("h2", { id: titleId }, nameElement(board.title, 90)),
    element("p", { class: "muted small facts" }, nameElement(factsLine(board), 260)),
    board.isImported ? importedNotice() : verdict(board),
    table,
    differences?.section,
    breakdowns.sections.length ? element("h3", { class: "more-title" }, "Look closer") : null,
    breakdowns.sections.map((item) => item.section),
  );
  const redraw = () => {
    section.hidden = filters.board !== "" && filters.board !== board.id;
    if (section.hidden) return;
    drawTable();
    differences?.redraw();
    for (const item of breakdowns.sections) item.redraw();
  };
  return { section, redraw };
}

/** @param {Board} board */
function factsLine(board) {
  const facts = [
    board.isImported ? "" : pluralized(board.entries.length, "planner"),
    board.routes.length ? pluralized(board.routes.length, "route") : "",
    board.penalties ? `penalties ${board.penalties}` : "",
    board.source,
  ];
  return facts.filter(Boolean).join(" · ");
}

const importedNotice = () =>
  element(
    "p",
    { class: "notice" },
    "These figures come from another simulator, with other towns and other traffic. " +
      "They cannot be compared with those of plant-bench.",
  );

/**
 * Differences of all planners from a selected one.
 * @param {Board} board
 */
function differencesSection(board) {
  let reference = board.entries[0];
  const place = element("div", { class: "plot" });
  const redraw = plotInto(
    place,
    "Differences in driving score with 95 % intervals; the matrix below has the numbers",
    (width) => differencePlot(board, filteredEntries(board), reference, width),
  );
  const select = element(
    "select",
    {
      onchange: () => {
        reference = board.entries[Number(select.value)];
        redraw();
      },
    },
    board.entries.map((entry) =>
      element("option", { value: String(entry.place) }, truncated(entry.planner, 40)),
    ),
  );
  const section = element(
    "div",
    { class: "forest" },
    element(
      "div",
      { class: "forest-head" },
      element("h3", {}, "Is the difference significant?"),
      element("label", { class: "small" }, "against ", select),
    ),
    place,
    element(
      "p",
      { class: "muted small" },
      "Filled: significantly different. Hollow: not significant. Bars are 95 % intervals.",
    ),
  );
  return { section, redraw };
}

/**
 * The sections that a board has data for.
 * @param {Board} board
 */
function breakdownSections(board) {
  /** @type {CollapsibleSection[]} */
  const sections = [];
  /**
   * @param {string} name
   * @param {string} title
   * @param {string} note
   * @param {(body: HTMLElement) => void} draw
   */
  const add = (name, title, note, draw) => {
    sections.push(collapsibleSection(`${board.id}-${name}`, title, note, draw));
  };
  /**
   * @param {string} name
   * @param {string} title
   * @param {string} note
   * @param {() => HTMLTableElement} makeTable
   */
  const addTable = (name, title, note, makeTable) =>
    add(name, title, note, (body) => replaceContent(body, scrollable(title, makeTable())));
  const addInfractions = () =>
    add("infractions", "Infractions", "Total count divided by total distance.", (body) => {
      const entries = filteredEntries(board);
      const place = element("div", { class: "plot" });
      const table = scrollable("Infractions", infractionTable(entries));
      replaceContent(body, infractionPlotKey(entries), place, table);
      plotInto(
        place,
        "Infractions per kilometre by kind, one bar per planner; the table below has the numbers",
        (width) => infractionPlot(entries, width),
      )();
    });
  /** @type {EpisodeQuery} */
  const query = {};
  const episodes = collapsibleSection(
    `${board.id}-episodes`,
    "Episodes",
    "What happened in each, with its replay. " +
      "Select two of one scenario to watch them side by side.",
    (body) => replaceContent(body, ...episodeList(board, query, () => episodes.redraw())),
  );
  const openEpisodes = (/** @type {EpisodeQuery} */ wanted) => {
    Object.assign(query, { entry: undefined, route: undefined, limit: undefined }, wanted);
    episodes.section.open = true;
    episodes.redraw();
    episodes.section.querySelector("summary")?.focus({ preventScroll: true });
    episodes.section.scrollIntoView();
  };

  if (board.isImported) {
    if (board.entries.some(({ rates }) => Object.keys(rates).length)) addInfractions();
    return { sections, openEpisodes };
  }
  if (board.differences.length) {
    addTable(
      "matrix",
      "Pairwise differences",
      "Difference in driving score, row minus column, with its 95 % interval. " +
        "Coloured if the difference is significant; ≈ otherwise.",
      () => differenceMatrix(board, filteredEntries(board)),
    );
  }
  addTable("towns", "Towns", "Driving score by town. Red is low.", () =>
    townHeatmap(board, filteredRuns(board)),
  );
  addTable(
    "routes",
    "Routes",
    "Mean driving score on each route. Red is low. " +
      "A cell opens its episodes; arrow keys move between cells.",
    () => routeHeatmap(board, filteredRuns(board), openEpisodes),
  );
  add(
    "spread",
    "Scores of episodes",
    "The size of a dot is the number of episodes with that score; the tick is the mean.",
    (body) => {
      const place = element("div", { class: "plot" });
      replaceContent(body, place);
      plotInto(place, "Driving scores of all episodes, one row per planner", (width) =>
        episodePlot(board, filteredEntries(board), width),
      )();
    },
  );
  addInfractions();
  addTable(
    "hazards",
    "Hazards",
    "Share of hazards met that were survived: no collision near the hazard after it began. Red is low.",
    () => hazardHeatmap(filteredRuns(board)),
  );
  addTable(
    "termination",
    "Termination and causes",
    "How episodes ended, and in how many collisions the ego hit the other vehicle, " +
      "rather than being hit.",
    () => terminationTable(filteredRuns(board)),
  );
  addTable(
    "comfort",
    "Near misses and comfort",
    "Not part of any score. Times are medians over episodes of the minimum in each; " +
      "– if the median episode had no near miss.",
    () => comfortTable(filteredRuns(board)),
  );
  if (board.rankings.length) {
    addTable(
      "rankings",
      "Rankings (RFDS)",
      "Driving score of the expert when it sees only the top-ranked vehicle.",
      () => rankingTable(board),
    );
  }
  sections.push(episodes);
  return { sections, openEpisodes };
}
