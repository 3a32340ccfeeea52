// @ts-check
// The result of a board in sentences: the best planner, its lead, and which differences are not
// significant.

/** @import { Board, Difference } from "./data.js" */
import { element } from "../shared/dom.js";
import { differenceBetween, rankedMetric } from "./data.js";
import { fixed, isKnown, nameElement, pValue, signed } from "./text.js";

const LISTED_PAIRS = 4;

/** @param {Board} board */
export function verdict(board) {
  const [first, second] = board.entries;
  if (!board.differences.length) return null;
  const score = fixed(first.scores[rankedMetric][0], 1);
  const sentences = [
    element(
      "p",
      { class: "lead" },
      element("strong", {}, nameElement(first.planner)),
      ` leads with a driving score of ${score}.`,
    ),
  ];
  const lead = differenceBetween(board, first, second);
  if (lead) {
    sentences.push(
      element(
        "p",
        {},
        `It is ${fixed(Math.abs(lead.mean), 1)} ${lead.mean < 0 ? "behind" : "ahead of"} `,
        nameElement(second.planner),
        ` on the routes and seeds that both drove, ${intervalText(lead)}. `,
        element(
          "strong",
          {},
          lead.significant
            ? "The difference is significant."
            : "The difference is not significant.",
        ),
      ),
    );
  }
  const others = board.differences.filter(
    (item) =>
      !item.significant &&
      !(item.better === first && item.worse === second) &&
      !(item.better === second && item.worse === first),
  );
  if (others.length) sentences.push(insignificantPairs(others));
  return element("div", { class: "verdict" }, sentences);
}

/** @param {Difference[]} pairs */
function insignificantPairs(pairs) {
  const listed = pairs
    .slice(0, LISTED_PAIRS)
    .flatMap((pair, place) => [
      place ? "; " : "",
      nameElement(pair.better.planner, 24),
      " and ",
      nameElement(pair.worse.planner, 24),
      ` (${signed(pair.mean, 1)})`,
    ]);
  const more = pairs.length > LISTED_PAIRS ? `; and ${pairs.length - LISTED_PAIRS} more pairs` : "";
  return element("p", { class: "muted" }, "No significant difference: ", listed, `${more}.`);
}

/**
 * The interval of a difference's size, and its p-value.
 * @param {Difference} difference
 */
function intervalText({ mean, low, high, corrected }) {
  if (!isKnown(low) || !isKnown(high)) return "on too few routes for an interval";
  const [from, to] = mean < 0 ? [-high, -low] : [low, high];
  return `95 % interval ${fixed(from, 1)} to ${fixed(to, 1)}, p ${pValue(corrected)} corrected for all pairs`.replaceAll(
    "-",
    "−",
  );
}
