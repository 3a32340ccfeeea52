// @ts-check
// Plots (Observable Plot). Each has a label, and its numbers are in a table elsewhere on the page.

/** @import { Board, Entry } from "./data.js" */
import {
  barX,
  dot,
  plot,
  pointer,
  pointerY,
  ruleX,
  ruleY,
  stackX,
  tickX,
  tip,
} from "@observablehq/plot";
import { element, replaceContent } from "../shared/dom.js";
import { asWords } from "../shared/text.js";
import { differenceBetween, filters, rankedMetric, scoreOf } from "./data.js";
import { sideOf } from "./difference-matrix.js";
import { isKnown, pValue, signed, truncated } from "./text.js";

const NARROW = 560; // px: below this width labels are shorter
const STYLE = {
  background: "transparent",
  color: "var(--text)",
  fontFamily: "var(--font)",
  fontSize: "12.5px",
  overflow: "visible",
};
const TOOLTIP = { fill: "var(--raised)", stroke: "var(--line-strong)" };
const SIDE_COLOURS = { ahead: "var(--good)", behind: "var(--bad)", even: "var(--muted)" };

const LABEL_OFFSET = 38; // px below the plot, so that the margin also holds the descenders
const LETTER_WIDTH = 7.2; // px: the widest mean width of a letter in names, in this font size

/**
 * Width of the margin for the names at an axis.
 * @param {string[]} names
 */
const labelWidth = (names) =>
  Math.ceil(16 + LETTER_WIDTH * Math.max(8, ...names.map((name) => Array.from(name).length)));

/**
 * Draw a plot into an element, and again when the element's width changes.
 * @param {HTMLElement} parent
 * @param {string} label
 * @param {(width: number) => Element} makePlot
 * @returns {() => void} draws it
 */
export function plotInto(parent, label, makePlot) {
  let width = 0;
  const draw = () => {
    width = parent.clientWidth;
    if (!width) return;
    const drawn = makePlot(width);
    for (const part of drawn.querySelectorAll("[aria-label]")) part.removeAttribute("aria-label");
    drawn.setAttribute("role", "img"); // a single picture for screen readers, not many parts
    drawn.setAttribute("aria-label", label);
    drawn.removeAttribute("aria-roledescription");
    replaceContent(parent, drawn);
  };
  new ResizeObserver(() => {
    if (Math.abs(parent.clientWidth - width) > 2) draw();
  }).observe(parent);
  return draw;
}

/**
 * Names for an axis: external text, truncated, each different from the others.
 * @param {Entry[]} entries
 * @param {number} width of the plot
 */
function axisNames(entries, width) {
  const letters = width < NARROW ? 14 : 24;
  /** @type {Map<string, number>} */
  const counts = new Map();
  return entries.map(({ planner }) => {
    const name = truncated(planner.replace(/\p{C}/gu, "").replace(/\s+/g, " "), letters);
    const count = (counts.get(name) ?? 0) + 1;
    counts.set(name, count);
    return count > 1 ? `${name} #${count}` : name;
  });
}

/**
 * Differences of all planners from one of them, with intervals.
 * @param {Board} board
 * @param {Entry[]} entries
 * @param {Entry} reference
 * @param {number} width
 */
export function differencePlot(board, entries, reference, width) {
  const names = axisNames(entries, width);
  const rows = entries.flatMap((entry, place) => {
    const difference = entry === reference ? null : differenceBetween(board, entry, reference);
    if (!difference) return [];
    const { mean, low, high, corrected } = difference;
    const name = names[place];
    const colour = SIDE_COLOURS[sideOf(difference)];
    const interval =
      isKnown(low) && isKnown(high)
        ? `95 % interval ${signed(low, 1)} to ${signed(high, 1)}`
        : "too few routes";
    return {
      name,
      mean,
      low,
      high,
      colour,
      fill: difference.significant ? colour : "var(--page)",
      title: `${name}: ${signed(mean, 1)} DS\n${interval}\np ${pValue(corrected)} after correction`,
    };
  });
  const place = entries.indexOf(reference);
  return plot({
    width,
    height: 60 + 26 * entries.length,
    marginLeft: labelWidth(names),
    marginRight: 16,
    marginBottom: 46,
    style: STYLE,
    x: {
      label: `DS against ${truncated(reference.planner, 24)}`,
      grid: true,
      nice: true,
      labelAnchor: "center",
      labelOffset: LABEL_OFFSET,
    },
    y: { label: null, domain: names },
    marks: [
      ruleX([0], { stroke: "var(--line-strong)" }),
      ruleY(
        rows.filter((row) => isKnown(row.low)),
        { y: "name", x1: "low", x2: "high", stroke: (row) => row.colour, strokeWidth: 2.5 },
      ),
      dot(rows, {
        y: "name",
        x: "mean",
        r: 5,
        stroke: (row) => row.colour,
        strokeWidth: 2,
        fill: (row) => row.fill,
      }),
      dot(place < 0 ? [] : [names[place]], {
        y: (name) => name,
        x: 0,
        symbol: "diamond",
        r: 5,
        fill: "var(--text)",
      }),
      tip(rows, pointerY({ y: "name", x: "mean", title: "title", ...TOOLTIP })),
    ],
  });
}

const STEP = 1; // DS: scores are rounded to it, so that equal ones share a dot

/**
 * The episodes' driving scores: a dot for each value, its area the share of episodes with it.
 * @param {Board} board
 * @param {Entry[]} entries
 * @param {number} width
 */
export function episodePlot(board, entries, width) {
  const names = axisNames(entries, width);
  const values = entries.flatMap((entry, place) => episodeValues(board, entry, names[place]));
  const means = entries
    .map((entry, place) => ({ name: names[place], ds: scoreOf(entry, rankedMetric)[0] }))
    .filter((row) => isKnown(row.ds));
  return plot({
    width,
    height: 56 + 34 * entries.length,
    marginLeft: labelWidth(names),
    marginRight: 24,
    marginBottom: 46,
    style: STYLE,
    x: {
      label: "driving score of an episode",
      domain: [0, 100],
      grid: true,
      labelAnchor: "center",
      labelOffset: LABEL_OFFSET,
    },
    y: { label: null, domain: names },
    r: { domain: [0, 1], range: [0, 22] },
    marks: [
      dot(values, {
        x: "ds",
        y: "name",
        r: "share",
        fill: "var(--accent)",
        fillOpacity: 0.35,
        stroke: "var(--accent)",
      }),
      tickX(means, {
        x: "ds",
        y: "name",
        stroke: "var(--text)",
        strokeWidth: 2.5,
        insetTop: 5,
        insetBottom: 5,
      }),
      tip(values, pointer({ x: "ds", y: "name", title: "title", ...TOOLTIP })),
    ],
  });
}

/**
 * @param {Board} board
 * @param {Entry} entry
 * @param {string} name
 */
function episodeValues(board, entry, name) {
  const scores = board
    .episodes()
    .filter((item) => item.entry === entry && (!filters.town || item.town === filters.town))
    .map((item) => item.scores[rankedMetric] ?? 0);
  /** @type {Map<number, number>} */
  const counts = new Map();
  for (const score of scores) {
    const value = STEP * Math.round(score / STEP);
    counts.set(value, (counts.get(value) ?? 0) + 1);
  }
  return [...counts].map(([ds, count]) => ({
    name,
    ds,
    share: count / scores.length,
    title: `${name}: ${count} of ${scores.length} episodes\nwith a driving score of ${ds}`,
  }));
}

/** @type {Record<string, string>} */
const INFRACTION_COLOURS = {
  collision_pedestrian: "#c2382e",
  collision_vehicle: "#e08214",
  collision_static: "#4d9a5b",
  red_light: "#7b3294",
  route_deviation: "#4393c3",
  blocked: "#737b87",
  timeout: "#a6aebb",
};

/**
 * The plotted kinds of infractions that any of the planners has.
 * @param {Entry[]} entries
 */
const plottedKinds = (entries) =>
  Object.keys(INFRACTION_COLOURS).filter((kind) => entries.some(({ rates }) => rates[kind]));

/**
 * Infractions per kilometre by kind.
 * @param {Entry[]} entries
 * @param {number} width
 */
export function infractionPlot(entries, width) {
  const names = axisNames(entries, width);
  const kinds = plottedKinds(entries);
  const rows = entries.flatMap((entry, place) =>
    kinds
      .filter((kind) => entry.rates[kind])
      .map((kind) => ({ name: names[place], kind: asWords(kind), rate: entry.rates[kind] })),
  );
  return plot({
    width,
    height: 60 + 26 * entries.length,
    marginLeft: labelWidth(names),
    marginRight: 16,
    marginBottom: 46,
    style: STYLE,
    x: {
      label: "infractions per km",
      grid: true,
      labelAnchor: "center",
      labelOffset: LABEL_OFFSET,
    },
    y: { label: null, domain: names },
    color: { domain: kinds.map(asWords), range: kinds.map((kind) => INFRACTION_COLOURS[kind]) },
    marks: [
      barX(rows, { x: "rate", y: "name", fill: "kind", insetTop: 2, insetBottom: 2 }),
      tip(
        rows,
        pointer(
          stackX({
            x: "rate",
            y: "name",
            z: "kind",
            title: (row) => `${row.name}\n${row.kind}: ${row.rate.toFixed(2)} per km`,
            ...TOOLTIP,
          }),
        ),
      ),
    ],
  });
}

/**
 * What the colours of `infractionPlot` mean.
 * @param {Entry[]} entries
 */
export function infractionPlotKey(entries) {
  return element(
    "ul",
    { class: "key small" },
    plottedKinds(entries).map((kind) => {
      const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.background = INFRACTION_COLOURS[kind];
      return element("li", {}, swatch, asWords(kind));
    }),
  );
}
