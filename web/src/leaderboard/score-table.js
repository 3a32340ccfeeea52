// @ts-check
// The columns of a board's score table.

/** @import { Content } from "../shared/dom.js" */
/** @import { Entry } from "./data.js" */
/** @import { OpenEpisodes } from "./episode-list.js" */
/** @import { Metric, Spread } from "./payload.js" */
/** @import { Column } from "./tables.js" */
import { element } from "../shared/dom.js";
import { rankedMetric, scoreMetrics, scoreOf } from "./data.js";
import { fixed, isKnown, nameElement, truncated } from "./text.js";

/**
 * @param {OpenEpisodes} openEpisodes
 * @returns {Column<Entry>[]}
 */
export function scoreColumns(openEpisodes) {
  return [
    {
      header: "Planner",
      title: "The value of --agent",
      value: (entry) => entry.planner.toLowerCase(),
      cell: (entry) => plannerCell(entry, openEpisodes),
    },
    ...scoreMetrics.map(metricColumn),
    {
      header: "IT ms",
      title: "Inference time: one forward pass of the network",
      numeric: true,
      value: (entry) => entry.it,
      cell: (entry) => element("span", { title: inferenceTimeNote(entry) }, fixed(entry.it, 2)),
    },
    {
      header: "RFDS",
      title: "Relative filtered driving score, percent",
      firstDirection: -1,
      numeric: true,
      value: (entry) => entry.rfds[0],
      cell: (entry) =>
        element(
          "span",
          { title: entry.ranker ? `ranked by ${entry.ranker}` : null },
          spreadCell(entry.rfds, 1),
        ),
    },
    {
      header: "Inputs",
      title: "The planner's kind of input",
      value: (entry) => entry.inputs.join(" "),
      cell: inputsCell,
    },
    {
      header: "Track",
      title: "Sensors, objects (perfect perception) or privileged (the simulator's state)",
      value: (entry) => entry.track,
      cell: (entry) => entry.track || "–",
    },
    {
      header: "Parameters",
      title: "Parameters of the planner's network",
      numeric: true,
      value: (entry) => entry.parameters,
      cell: (entry) => (isKnown(entry.parameters) ? parameterCount(entry.parameters) : "–"),
    },
    {
      header: "Date",
      title: "Day of the newest episode",
      value: (entry) => entry.date || null,
      cell: (entry) => element("span", { class: "nowrap" }, entry.date || "–"),
    },
    {
      header: "Episodes",
      title: "Finished episodes, and episodes of a complete run",
      numeric: true,
      value: (entry) => entry.episodes,
      cell: episodesCell,
    },
  ];
}

/**
 * @param {Metric} metric
 * @returns {Column<Entry>}
 */
function metricColumn({ name, label, digits, better, about }) {
  return {
    header: label,
    title: about,
    firstDirection: better === "lower" ? 1 : -1,
    numeric: true,
    value: (entry) => scoreOf(entry, name)[0],
    cell: (entry) => {
      const spread = scoreOf(entry, name);
      return name === rankedMetric ? drivingScoreCell(spread) : spreadCell(spread, digits);
    },
  };
}

/**
 * A mean with its standard deviation.
 * @param {Spread} spread
 * @param {number} digits
 * @returns {Content}
 */
export function spreadCell([mean, std], digits) {
  if (!isKnown(mean)) return "–";
  return [
    fixed(mean, digits),
    isKnown(std) ? element("span", { class: "std" }, ` ± ${fixed(std, digits)}`) : null,
  ];
}

/** @param {Spread} spread */
function drivingScoreCell(spread) {
  const bar = element("span", { class: "bar", "aria-hidden": "true" });
  bar.style.setProperty("--value", `${spread[0] ?? 0}%`);
  return element("span", { class: "scored" }, element("span", {}, spreadCell(spread, 1)), bar);
}

/** @param {number} count */
const parameterCount = (count) => (count >= 1e6 ? `${(count / 1e6).toFixed(2)} M` : String(count));

/** @param {Entry} entry */
function inferenceTimeNote(entry) {
  if (!isKnown(entry.it)) return null;
  const tokens = isKnown(entry.tokens) ? ` at ${Math.round(entry.tokens)} tokens` : "";
  return `one forward pass${tokens}, ${truncated(entry.processor || "processor not known", 120)}`;
}

/** @param {Entry} entry */
function inputsCell(entry) {
  const names = entry.inputs.map((name) => truncated(name)).join(", ");
  return element("span", { class: "small inputs" }, names || "–");
}

/** @param {Entry} entry */
function episodesCell(entry) {
  if (!entry.episodes) return entry.repetitions ? `${entry.repetitions} ×` : "–";
  const complete = entry.episodes === entry.expected;
  return element(
    "span",
    {
      class: complete ? null : "partial",
      title: `${entry.repetitions} repetitions; from ${truncated(entry.source, 200)}`,
    },
    complete ? String(entry.episodes) : `${entry.episodes} of ${entry.expected}`,
  );
}

/**
 * @param {Entry} entry
 * @param {OpenEpisodes} openEpisodes
 */
function plannerCell(entry, openEpisodes) {
  const name = nameElement(entry.planner);
  if (!entry.details) return element("span", { class: "planner" }, name);
  return element(
    "button",
    {
      type: "button",
      class: "planner link",
      title: "Its episodes, the lowest driving score first",
      onclick: () => openEpisodes({ entry }),
    },
    name,
  );
}
