// Runs the leaderboard page's own modules without a browser, on the page's data from standard input.
// Writes what they draw as JSON, for each board: marks of the episode plot, cells of the score table.

import { readFileSync } from "node:fs";
import { registerHooks } from "node:module";

const MARKS = ["barX", "dot", "pointer", "pointerY", "ruleX", "ruleY", "stackX", "tickX", "tip"];
const PLOT = [
  ...MARKS.map((name) => `export const ${name} = (data, options) => ({ ${name}: data, options });`),
  "export const plot = (options) => options;",
].join("\n");

registerHooks({
  resolve(specifier, context, next) {
    if (specifier !== "@observablehq/plot") return next(specifier, context);
    return { url: `data:text/javascript,${encodeURIComponent(PLOT)}`, shortCircuit: true };
  },
});

class Element {
  children = [];
  style = { setProperty() {} };
  append(...children) {
    this.children.push(...children);
  }
  setAttribute() {}
  addEventListener() {}
  get textContent() {
    return this.children.map((child) => child.textContent ?? String(child)).join("");
  }
}

const text = readFileSync(0, "utf8");
globalThis.HTMLScriptElement = class {
  text = text;
};
globalThis.document = {
  createElement: () => new Element(),
  getElementById: () => new HTMLScriptElement(),
};

const folder = new URL("../../../../web/src/leaderboard/", import.meta.url);
const { boards } = await import(new URL("data.js", folder).href);
const { episodePlot } = await import(new URL("plots.js", folder).href);
const { scoreColumns } = await import(new URL("score-table.js", folder).href);
const { sortedRows } = await import(new URL("tables.js", folder).href);
const { element } = await import(new URL("../shared/dom.js", folder).href);

const shown = boards.map((board) => {
  const plot = episodePlot(board, board.entries, 800);
  const columns = scoreColumns(() => {});
  return {
    domain: plot.x.domain,
    dots: plot.marks.find((mark) => mark.dot).dot,
    means: plot.marks.find((mark) => mark.tickX).tickX,
    order: columns
      .filter((column) => column.numeric)
      .flatMap((column) =>
        [1, -1].map((direction) =>
          sortedRows(board.entries, column, direction, (entry) => !entry.complete).map(
            (entry) => entry.planner,
          ),
        ),
      ),
    rows: board.entries.map((entry) =>
      Object.fromEntries(
        columns.map((column) => [
          column.header,
          element("td", {}, column.cell(entry)).textContent.trim(),
        ]),
      ),
    ),
  };
});
process.stdout.write(JSON.stringify(shown));
