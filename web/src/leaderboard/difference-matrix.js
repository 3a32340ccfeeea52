// @ts-check
// Pairwise differences: each planner of a row minus each of a column.

/** @import { Board, Difference, Entry } from "./data.js" */
import { element } from "../shared/dom.js";
import { differenceBetween } from "./data.js";
import { hiddenCaption } from "./tables.js";
import { isKnown, nameElement, pValue, signed } from "./text.js";

/** @typedef {"ahead" | "behind" | "even"} Side even where the difference is not significant */

/**
 * @param {Difference | null} difference
 * @returns {Side}
 */
export function sideOf(difference) {
  if (!difference?.significant) return "even";
  return difference.mean > 0 ? "ahead" : "behind";
}

/**
 * @param {Board} board
 * @param {Entry[]} entries
 */
export function differenceMatrix(board, entries) {
  const header = element(
    "tr",
    {},
    element("th", { scope: "col" }, "row against column"),
    entries.map(({ planner }) =>
      element("th", { scope: "col", class: "against" }, nameElement(planner, 18)),
    ),
  );
  const rows = entries.map((first) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, nameElement(first.planner, 28)),
      entries.map((second) => matrixCell(board, first, second)),
    ),
  );
  return element(
    "table",
    { class: "matrix" },
    hiddenCaption("Difference in driving score for each pair of planners"),
    element("thead", {}, header),
    element("tbody", {}, rows),
  );
}

/**
 * @param {Board} board
 * @param {Entry} first
 * @param {Entry} second
 */
function matrixCell(board, first, second) {
  if (first === second) {
    const label = element("span", { class: "hidden-text" }, "the same planner");
    return element("td", { class: "same" }, label);
  }
  const difference = differenceBetween(board, first, second);
  if (!difference) return element("td", { class: "muted" }, "–");
  const { mean, low, high, corrected, pairs, routes } = difference;
  const side = sideOf(difference);
  const interval =
    isKnown(low) && isKnown(high) ? `${signed(low, 0)} to ${signed(high, 0)}` : "too few routes";
  const p = `p ${pValue(corrected)} after correction`;
  return element(
    "td",
    {
      class: side,
      title: `95 % interval ${interval}; ${p}; ${pairs} pairs on ${routes} routes`,
    },
    element("span", { class: "mean" }, side === "even" ? "≈ " : "", signed(mean, 1)),
    element("span", { class: "ends" }, interval),
    element("span", { class: "hidden-text" }, side === "even" ? ", not significant" : `, ${side}`),
  );
}
