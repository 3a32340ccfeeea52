// Tables that sort by a click on a column's head.

/**
 * Make a table whose columns sort.
 * @param columns {head, title, value(row), cell(row), numeric, start}: what a column is; `start` is
 *     the direction of the first click, 1 for ascending.
 * @param state {column, direction}: kept by the caller, so that a table drawn anew is sorted as before.
 */
function sortedTable({ caption, columns, rows, state, draw }) {
  const heads = columns.map((column, place) => {
    const sorted = state.column === place;
    const button = el(
      "button",
      {
        type: "button",
        class: "sort",
        title: column.title,
        onclick: () => {
          state.direction = sorted ? -state.direction : column.start ?? 1;
          state.column = place;
          draw(place);
        },
      },
      column.head,
      el("span", { class: "arrow", "aria-hidden": "true" }, sorted ? (state.direction > 0 ? "↑" : "↓") : ""),
    );
    return el(
      "th",
      {
        scope: "col",
        class: column.numeric ? "number" : null,
        "aria-sort": sorted ? (state.direction > 0 ? "ascending" : "descending") : null,
      },
      button,
    );
  });
  const chosen = columns[state.column];
  const ordered = chosen
    ? [...rows].sort((a, b) => state.direction * compared(chosen.value(a), chosen.value(b), state.direction))
    : rows;
  const body = ordered.map((row) =>
    el(
      "tr",
      {},
      columns.map((column, place) => {
        const attributes = { class: column.numeric ? "number" : null };
        if (place === 0) return el("th", { scope: "row" }, column.cell(row));
        return el("td", attributes, column.cell(row));
      }),
    ),
  );
  return el(
    "table",
    {},
    el("caption", { class: "hidden-text" }, caption),
    el("thead", {}, el("tr", {}, heads)),
    el("tbody", {}, body),
  );
}

/** Order of two values; what is not known comes last, whichever way it is sorted. */
function compared(a, b, direction) {
  if (!known(a) || !known(b)) return known(a) ? -direction : known(b) ? direction : 0;
  return typeof a === "string" ? a.localeCompare(b) : a - b;
}
