// @ts-check
// Tables whose cells are coloured by what was lost: planner by town, by route and by hazard.

/** @import { Content } from "../shared/dom.js" */
/** @import { Board, RunEntry } from "./data.js" */
/** @import { OpenEpisodes } from "./episode-list.js" */
import { element } from "../shared/dom.js";
import { asWords } from "../shared/text.js";
import { filters, hazardKinds, rankedMetric } from "./data.js";
import { spreadCell } from "./score-table.js";
import { addArrowKeys, hiddenCaption } from "./tables.js";
import { fixed, isKnown, nameElement, percent, truncated } from "./text.js";

const MAX_TINT = 44; // percent

/**
 * A cell with a tint that grows with what was lost, 0 to 1.
 * @param {number} lost
 * @param {Content} content
 * @param {{class?: string}} [attributes]
 */
function heatCell(lost, content, attributes = {}) {
  const cell = element("td", { class: "heat", ...attributes }, content);
  const tint = Math.round(MAX_TINT * Math.min(Math.max(lost, 0), 1));
  cell.style.setProperty("--lost", `${tint}%`);
  return cell;
}

/**
 * Driving score of each planner in each town.
 * @param {Board} board
 * @param {RunEntry[]} entries
 */
export function townHeatmap(board, entries) {
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    board.towns.map((town) =>
      element("th", { scope: "col", class: "number" }, nameElement(town, 20)),
    ),
  );
  const rows = entries.map((entry) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(entry.planner, 28)),
      board.towns.map((town) => {
        const score = entry.details.towns[town]?.[rankedMetric];
        const mean = score?.[0];
        return isKnown(mean)
          ? heatCell(1 - mean / 100, spreadCell(score, 1), { class: "heat number" })
          : element("td", { class: "number" }, "–");
      }),
    ),
  );
  return element(
    "table",
    { class: "towns" },
    hiddenCaption("Driving score by town"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/**
 * Mean driving score of each planner on each route; a cell opens its episodes.
 * @param {Board} board
 * @param {RunEntry[]} entries
 * @param {OpenEpisodes} openEpisodes
 */
export function routeHeatmap(board, entries, openEpisodes) {
  const means = routeMeans(board);
  const routes = board.routes.filter((route) => !filters.town || route.town === filters.town);
  const rows = entries.map((entry) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(entry.planner, 24)),
      routes.map(({ name }) => {
        const found = means.get(routeKey(entry, name));
        if (!found) return element("td", { class: "heat" }, "–");
        const mean = found.sum / found.episodes;
        const score = `driving score ${fixed(mean, 0)} in ${found.episodes} episodes`;
        const label = `${truncated(entry.planner)} on ${truncated(name, 80)}: ${score}`;
        const button = element(
          "button",
          {
            type: "button",
            "aria-label": label,
            title: label,
            onclick: () => openEpisodes({ entry, route: name }),
          },
          fixed(mean, 0),
        );
        return heatCell(1 - mean / 100, button);
      }),
    ),
  );
  return addArrowKeys(
    element(
      "table",
      { class: "routes" },
      hiddenCaption("Mean driving score by route"),
      element("thead", {}, routeHeaders(routes)),
      element("tbody", {}, rows),
    ),
  );
}

/**
 * @param {{place: number}} entry
 * @param {string} route
 */
const routeKey = (entry, route) => `${entry.place} ${route}`;

/** @param {Board} board */
function routeMeans(board) {
  /** @type {Map<string, {sum: number, episodes: number}>} */
  const means = new Map();
  for (const item of board.episodes()) {
    const key = routeKey(item.entry, item.route);
    const found = means.get(key) ?? { sum: 0, episodes: 0 };
    found.sum += item.scores[rankedMetric] ?? 0;
    found.episodes += 1;
    means.set(key, found);
  }
  return means;
}

/** @param {Board["routes"]} routes */
function routeHeaders(routes) {
  const towns = [...new Set(routes.map((route) => route.town))];
  const townRow = element(
    "tr",
    {},
    element("td", {}),
    towns.map((town) =>
      element(
        "th",
        {
          scope: "colgroup",
          colspan: routes.filter((route) => route.town === town).length,
          class: "group",
        },
        nameElement(town, 20),
      ),
    ),
  );
  const routeRow = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    routes.map(({ name, town }) =>
      element(
        "th",
        { scope: "col", class: "route", title: truncated(name, 200) },
        element("span", { "aria-hidden": "true" }, truncated(name.replace(`${town}-`, ""), 6)),
        element("span", { class: "hidden-text" }, truncated(name, 80)),
      ),
    ),
  );
  return [townRow, routeRow];
}

/**
 * Share of the hazards met that passed without a collision, by kind.
 * @param {RunEntry[]} entries
 */
export function hazardHeatmap(entries) {
  const kinds = hazardKinds.filter((kind) => entries.some(({ details }) => details.hazards[kind]));
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Planner"),
    element("th", { scope: "col", class: "number" }, "met"),
    kinds.map((kind) => element("th", { scope: "col", class: "kind" }, asWords(kind))),
  );
  const rows = entries.map(({ planner, details }) => {
    const counts = Object.values(details.hazards);
    const placed = counts.reduce((total, item) => total + item[0], 0);
    const met = counts.reduce((total, item) => total + item[1], 0);
    const notPlayed = counts.reduce((total, item) => total + item[3], 0);
    return element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(planner, 24)),
      element("td", { class: "number", title: `${notPlayed} were void` }, `${met} of ${placed}`),
      kinds.map((kind) => hazardCell(details.hazards[kind])),
    );
  });
  return element(
    "table",
    { class: "hazards" },
    hiddenCaption("Hazards survived, of those met"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/** @param {RunEntry["details"]["hazards"][string] | undefined} counts */
function hazardCell(counts) {
  const [, met, survived] = counts ?? [0, 0, 0, 0];
  if (!met) return element("td", { class: "number" }, "–");
  const share = survived / met;
  const content = [percent(share), element("span", { class: "of" }, `${survived} of ${met}`)];
  return heatCell(1 - share, content, { class: "heat number" });
}
