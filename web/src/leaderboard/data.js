// @ts-check
// The page's data: the payload, unpacked.

/** @import {
 *   BoardPayload, Details, LeaderboardPayload, Line, PackedDifference, PackedEpisode, Ranking, Spread
 * } from "./payload.js" */
import { embeddedJson } from "../shared/dom.js";
import { isKnown } from "./text.js";

/**
 * A planner's row on a board.
 * @typedef {Line & {place: number, details: Details | null}} Entry
 *
 * A row with breakdowns: a run of plant-bench, not imported figures.
 * @typedef {Line & {place: number, details: Details}} RunEntry
 */

/**
 * @typedef {object} Episode
 * @property {string} id of its replay
 * @property {Entry} entry that it belongs to
 * @property {string} route
 * @property {string} town
 * @property {number} repetition
 * @property {number} scenario
 * @property {string} status
 * @property {Record<string, number | null>} scores by name of metric
 * @property {number} duration s
 * @property {Infraction[]} infractions
 * @property {Hazard[]} hazards
 * @property {boolean} hasReplay
 * @property {string} reason
 *
 * @typedef {object} Infraction
 * @property {string} kind
 * @property {number} time s
 * @property {string} actor kind of the other, if there is one
 * @property {string} cause
 * @property {number | null | undefined} share of the way, for infractions that last
 *
 * @typedef {object} Hazard
 * @property {string} kind
 * @property {string} phase
 * @property {number} time s
 * @property {boolean} survived
 */

/**
 * The difference in driving score of two planners on the scenarios that both drove.
 * @typedef {object} Difference
 * @property {Entry} better
 * @property {Entry} worse
 * @property {number} mean
 * @property {number | null} low
 * @property {number | null} high
 * @property {number | null} corrected p-value, corrected for all pairs of the board
 * @property {number} pairs
 * @property {number} routes
 * @property {boolean} significant
 */

/**
 * @typedef {object} Board
 * @property {string} id
 * @property {string} title
 * @property {string} penalties name of the penalty scheme
 * @property {string} source
 * @property {string[]} towns
 * @property {{name: string, town: string}[]} routes
 * @property {Entry[]} entries
 * @property {Difference[]} differences
 * @property {Ranking[]} rankings
 * @property {boolean} isImported whether its figures are not from runs of plant-bench
 * @property {() => Episode[]} episodes all of them; unpacked when first called
 */

/** What the filters are set to; changed by main.js only. */
export const filters = { text: "", track: "", town: "", board: "" };

const payload = /** @type {LeaderboardPayload} */ (embeddedJson("data"));
export const scoreMetrics = payload.scores;
export const measureMetrics = payload.measures;
export const episodeMetrics = payload.scores.filter((metric) => metric.ofEpisode);
export const rankedMetric = payload.ranked;
export const infractionKinds = payload.kinds;
export const hazardKinds = payload.hazards;
export const statuses = payload.statuses;
export const boards = payload.boards.map(unpackBoard);

/**
 * @param {BoardPayload} packed
 * @param {number} place
 * @returns {Board}
 */
function unpackBoard(packed, place) {
  const entries = packed.lines.map((line, index) => ({
    ...line,
    place: index,
    details: packed.details[index] ?? null,
  }));
  const routes = packed.routes.map(([name, town]) => ({ name, town: packed.towns[town] }));
  /** @type {Episode[] | null} */
  let episodes = null;
  return {
    id: `board-${place}`,
    title: packed.title,
    penalties: packed.penalties,
    source: packed.source,
    towns: packed.towns,
    routes,
    entries,
    differences: packed.differences.map((item) => unpackDifference(item, entries)),
    rankings: packed.rankings,
    isImported: !packed.details.length,
    episodes: () => {
      episodes ??= packed.episodes.flatMap((list, index) =>
        list.map((item) => unpackEpisode(item, entries[index], routes)),
      );
      return episodes;
    },
  };
}

/**
 * @param {PackedDifference} packed
 * @param {Entry[]} entries
 * @returns {Difference}
 */
function unpackDifference(packed, entries) {
  const [better, worse, mean, low, high, , corrected, pairs, routes, significant] = packed;
  return {
    better: entries[better],
    worse: entries[worse],
    mean,
    low,
    high,
    corrected,
    pairs,
    routes,
    significant: significant === 1,
  };
}

/**
 * @param {PackedEpisode} packed
 * @param {Entry} entry
 * @param {Board["routes"]} routes
 * @returns {Episode}
 */
function unpackEpisode(packed, entry, routes) {
  const [name, routeIndex, repetition, scenario, status, scores, duration, ...rest] = packed;
  const [infractions, hazards, replay, reason] = rest;
  const route = routes[routeIndex];
  return {
    id: `${entry.id}/${name}`,
    entry,
    route: route.name,
    town: route.town,
    repetition,
    scenario,
    status: payload.statuses[status],
    scores: Object.fromEntries(episodeMetrics.map(({ name }, place) => [name, scores[place]])),
    duration,
    infractions: infractions.map(([kind, time, actor, cause, share]) => ({
      kind: payload.kinds[kind],
      time,
      actor: payload.actors[actor] ?? "",
      cause,
      share,
    })),
    hazards: hazards.map(([kind, phase, time, survived = 1]) => ({
      kind: payload.hazards[kind],
      phase: payload.phases[phase],
      time,
      survived: Boolean(survived),
    })),
    hasReplay: Boolean(replay),
    reason,
  };
}

/**
 * One of a planner's scores, in the selected town if there is one.
 * @param {Entry} entry
 * @param {string} name of the metric
 * @returns {Spread}
 */
export function scoreOf(entry, name) {
  const scores = filters.town ? entry.details?.towns[filters.town] : entry.scores;
  return scores?.[name] ?? [null, null];
}

/**
 * The difference of the first planner minus the second; null where none is known.
 * @param {Board} board
 * @param {Entry} first
 * @param {Entry} second
 * @returns {Difference | null}
 */
export function differenceBetween(board, first, second) {
  const found = board.differences.find(
    ({ better, worse }) =>
      (better === first && worse === second) || (better === second && worse === first),
  );
  if (!found || found.better === first) return found ?? null;
  return {
    ...found,
    mean: -found.mean,
    low: isKnown(found.high) ? -found.high : null,
    high: isKnown(found.low) ? -found.low : null,
  };
}

/**
 * The rows of a board that pass the filters.
 * @param {Board} board
 */
export function filteredEntries(board) {
  const text = filters.text.trim().toLowerCase();
  return board.entries.filter(({ planner, inputs, track, source }) => {
    const searched = [planner, inputs.join(" "), track, source].join(" ").toLowerCase();
    return searched.includes(text) && (!filters.track || track === filters.track);
  });
}

/**
 * The same without imported figures, which have no breakdowns.
 * @param {Board} board
 * @returns {RunEntry[]}
 */
export function filteredRuns(board) {
  return /** @type {RunEntry[]} */ (
    filteredEntries(board).filter((entry) => entry.details !== null)
  );
}
