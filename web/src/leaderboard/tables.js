// @ts-check
// Tables that are sorted by a click on a column's header; tables that scroll; keyboard navigation.

/** @import { Content } from "../shared/dom.js" */
import { element } from "../shared/dom.js";
import { isKnown } from "./text.js";

/**
 * @template Row
 * @typedef {object} Column
 * @property {string} header
 * @property {string} title tooltip of the header
 * @property {1 | -1} [firstDirection] of the first click; 1, ascending, by default
 * @property {boolean} [numeric]
 * @property {(row: Row) => string | number | null | undefined} value by which it is sorted
 * @property {(row: Row) => Content} cell
 */

/** @typedef {{column: number, direction: number}} SortOrder a direction above 0 is ascending */

/**
 * Make a table that is sorted by a click on a column's header.
 * @template Row
 * @param {object} table
 * @param {string} table.caption
 * @param {Column<Row>[]} table.columns
 * @param {Row[]} table.rows
 * @param {SortOrder} table.order kept by the caller, so that a new table is sorted as the last one
 * @param {(column: number) => void} table.redraw called when the user sorts by a column
 * @param {(row: Row) => boolean} table.isLast whether a row follows all others in every order
 */
export function sortableTable({ caption, columns, rows, order, redraw, isLast }) {
  const headers = columns.map((column, place) => {
    const sorted = order.column === place;
    const button = element(
      "button",
      {
        type: "button",
        class: "sort",
        title: column.title,
        onclick: () => {
          order.direction = sorted ? -order.direction : (column.firstDirection ?? 1);
          order.column = place;
          redraw(place);
        },
      },
      column.header,
      element(
        "span",
        { class: "arrow", "aria-hidden": "true" },
        sorted ? (order.direction > 0 ? "↑" : "↓") : "",
      ),
    );
    return element(
      "th",
      {
        scope: "col",
        class: column.numeric ? "number" : null,
        "aria-sort": sorted ? (order.direction > 0 ? "ascending" : "descending") : null,
      },
      button,
    );
  });
  const body = sortedRows(rows, columns[order.column], order.direction, isLast).map((row) =>
    element(
      "tr",
      {},
      columns.map((column, place) =>
        place === 0
          ? element("th", { scope: "row" }, column.cell(row))
          : element("td", { class: column.numeric ? "number" : null }, column.cell(row)),
      ),
    ),
  );
  return element(
    "table",
    {},
    hiddenCaption(caption),
    element("thead", {}, element("tr", {}, headers)),
    element("tbody", {}, body),
  );
}

/**
 * @template Row
 * @param {Row[]} rows
 * @param {Column<Row> | undefined} column
 * @param {number} direction
 * @param {(row: Row) => boolean} isLast
 */
export function sortedRows(rows, column, direction, isLast) {
  if (!column) return rows;
  return rows
    .map((row) => ({ row, value: column.value(row), last: Number(isLast(row)) }))
    .sort((a, b) => a.last - b.last || direction * compareValues(a.value, b.value, direction))
    .map(({ row }) => row);
}

/**
 * Compare two values; values that are not known come last in both directions.
 * @param {string | number | null | undefined} a
 * @param {string | number | null | undefined} b
 * @param {number} direction
 */
function compareValues(a, b, direction) {
  if (!isKnown(a) || !isKnown(b)) return isKnown(a) ? -direction : isKnown(b) ? direction : 0;
  return typeof a === "string" || typeof b === "string"
    ? String(a).localeCompare(String(b))
    : a - b;
}

/**
 * A table's caption, for screen readers only.
 * @param {string} text
 */
export const hiddenCaption = (text) => element("caption", { class: "hidden-text" }, text);

/**
 * A region for a table that may be wider than the page; it is scrolled with the keyboard, too.
 * @param {string} label
 * @param {HTMLTableElement} table
 */
export function scrollable(label, table) {
  return element(
    "div",
    { class: "scrolling", role: "region", "aria-label": label, tabindex: "0" },
    table,
  );
}

/** @type {Record<string, [rows: number, columns: number]>} */
const ARROW_KEYS = {
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
  ArrowUp: [-1, 0],
  ArrowDown: [1, 0],
};

/**
 * Make a table of buttons a single tab stop in which arrow keys move the focus.
 * @param {HTMLTableElement} table
 */
export function addArrowKeys(table) {
  const buttonRows = () =>
    [...table.tBodies[0].rows]
      .map((row) => [...row.querySelectorAll("button")])
      .filter((row) => row.length);
  buttonRows()
    .flat()
    .forEach((button, place) => (button.tabIndex = place ? -1 : 0));
  table.addEventListener("keydown", (event) => {
    const step = ARROW_KEYS[event.key];
    const button = event.target instanceof Element ? event.target.closest("button") : null;
    if (!step || !button) return;
    const rows = buttonRows();
    const row = rows.findIndex((buttons) => buttons.includes(button));
    const next = rows[row + step[0]]?.[rows[row].indexOf(button) + step[1]];
    if (!next) return;
    event.preventDefault();
    button.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
  return table;
}
