// @ts-check
// One episode: what is where at any moment. Moments are frames, which may be fractions.

/** @import { Columns } from "./columns.js" */
/** @import { EpisodePayload, StopLine } from "./payload.js" */
/** @import { Mark } from "./marks.js" */
/** @import { Town } from "./town.js" */
import { asWords } from "../shared/text.js";
import { lastAtOrBefore, requiredColumn } from "./columns.js";
import { makeMarks } from "./marks.js";

const PLAN_SHOWN = 1.5; // s for which a plan is shown
const ATTENTION_SHOWN = 1.2; // s for which attention, and the expert's response, is shown
const WAYPOINTS = 4;

/** @typedef {{x: number, y: number, yaw: number}} Pose */
/** @typedef {Pose & {speed: number, acceleration: number}} EgoState */
/** @typedef {[x: number, y: number]} Point */

/**
 * An actor's poses are rows of the episode's `pose` columns, from `start` on.
 * @typedef {object} Trajectory
 * @property {number} id
 * @property {number} kind index into the payload's kinds
 * @property {number} length m
 * @property {number} width m
 * @property {number} first frame
 * @property {number} count of frames
 * @property {number} start
 *
 * @typedef {Trajectory & Pose} ActorState
 */

/**
 * @typedef {object} Episode
 * @property {EpisodePayload} facts
 * @property {Town} town
 * @property {number} frames
 * @property {number} duration s
 * @property {Record<"x" | "y" | "yaw" | "speed" | "acceleration", Float64Array>} ego by frame
 * @property {Float64Array} progress m along the route, by frame
 * @property {Float64Array} limits speed limit by frame, m/s
 * @property {Record<"x" | "y" | "yaw", Float64Array>} pose of actors
 * @property {Record<"x" | "y", Float64Array>} route
 * @property {Path2D} routePath
 * @property {Int32Array} lights state of each signal by frame, signal by signal
 * @property {Trajectory[]} trajectories
 * @property {{ticks: Int32Array, values: Float64Array[]}} plans a pair of values per waypoint
 * @property {{causes: Int32Array, actors: Int32Array} | null} reasons by frame; 0 where none is known
 * @property {{ticks: Int32Array, starts: number[], actors: Int32Array, shares: number[]}} attention
 * @property {{ticks: Int32Array, actors: Int32Array} | null} expert 0 where it brakes for no actor
 * @property {Mark[]} marks
 */

/**
 * @param {EpisodePayload} facts
 * @param {Columns} columns
 * @param {Town} town
 * @returns {Episode}
 */
export function makeEpisode(facts, columns, town) {
  const column = (/** @type {string} */ name) => requiredColumn(columns, name);
  const scaled = (/** @type {string} */ name, /** @type {number} */ scale) =>
    Float64Array.from(column(name), (value) => value / scale);
  const metres = (/** @type {string} */ name) => scaled(name, facts.scales.length);
  const radians = (/** @type {string} */ name) => scaled(name, facts.scales.angle);
  const frames = column("ego.x").length;
  const progress = metres("progress");
  const route = { x: metres("route.x"), y: metres("route.y") };
  return {
    facts,
    town,
    frames,
    duration: (frames - 1) * facts.step,
    ego: {
      x: metres("ego.x"),
      y: metres("ego.y"),
      yaw: radians("ego.yaw"),
      speed: metres("ego.speed"),
      acceleration: metres("ego.acceleration"),
    },
    progress,
    limits: limitsAlong(facts.limits, progress),
    pose: { x: metres("pose.x"), y: metres("pose.y"), yaw: radians("pose.yaw") },
    route,
    routePath: linePath(route.x, route.y),
    lights: column("lights"),
    trajectories: makeTrajectories(columns, facts.scales.length),
    plans: {
      ticks: column("plan.tick"),
      values: Array.from({ length: 2 * WAYPOINTS }, (_, place) => metres(`plan.${place}`)),
    },
    reasons: columns["reason.cause"]
      ? { causes: column("reason.cause"), actors: column("reason.actor") }
      : null,
    attention: makeAttention(columns, facts.scales.share),
    expert: columns["expert.tick"]
      ? { ticks: column("expert.tick"), actors: column("expert.actor") }
      : null,
    marks: makeMarks(facts),
  };
}

/**
 * @param {Columns} columns
 * @param {number} scale units per metre
 * @returns {Trajectory[]}
 */
function makeTrajectories(columns, scale) {
  const column = (/** @type {string} */ name) => requiredColumn(columns, `track.${name}`);
  const [kind, length, width, first, counts] = ["kind", "length", "width", "first", "count"].map(
    column,
  );
  let start = 0;
  return Array.from(column("id"), (id, place) => {
    const count = counts[place];
    const trajectory = {
      id,
      kind: kind[place],
      length: length[place] / scale,
      width: width[place] / scale,
      first: first[place],
      count,
      start,
    };
    start += count;
    return trajectory;
  });
}

/**
 * @param {Columns} columns
 * @param {number} scale of the shares
 */
function makeAttention(columns, scale) {
  const starts = [0];
  let total = 0;
  for (const count of requiredColumn(columns, "attention.count")) starts.push((total += count));
  return {
    ticks: requiredColumn(columns, "attention.tick"),
    starts,
    actors: requiredColumn(columns, "attention.actor"),
    shares: Array.from(requiredColumn(columns, "attention.share"), (share) => share / scale),
  };
}

/**
 * @param {Float64Array} x
 * @param {Float64Array} y
 */
function linePath(x, y) {
  const path = new Path2D();
  for (let place = 0; place < x.length; place++) path.lineTo(x[place], y[place]);
  return path;
}

/**
 * Return the speed limit at each frame, m/s.
 * @param {EpisodePayload["limits"]} limits
 * @param {Float64Array} progress
 */
function limitsAlong(limits, progress) {
  const places = limits.map(([along]) => along);
  const rowAt = (/** @type {number} */ along) => Math.max(lastAtOrBefore(places, along), 0);
  return Float64Array.from(progress, (along) => limits[rowAt(along)][1]);
}

/**
 * @param {Episode} episode
 * @param {number} seconds
 */
export const frameAt = (episode, seconds) =>
  Math.min(Math.max(seconds / episode.facts.step, 0), episode.frames - 1);

/**
 * @param {Episode} episode
 * @param {number} seconds
 */
const tickAt = (episode, seconds) => Math.floor(seconds / episode.facts.tick + 1e-6);

/** @param {number} frame */
const wholeFrame = (frame) => Math.floor(frame + 1e-6);

/**
 * Return the row of what is newest at a time; -1 if there is nothing, or it is too old.
 * @param {Episode} episode
 * @param {Int32Array} ticks
 * @param {number} seconds
 * @param {number} maxAge s
 */
function newestRow(episode, ticks, seconds, maxAge) {
  const tick = tickAt(episode, seconds);
  const row = lastAtOrBefore(ticks, tick);
  return row >= 0 && (tick - ticks[row]) * episode.facts.tick <= maxAge ? row : -1;
}

/**
 * Interpolate between rows.
 * @param {Float64Array} values
 * @param {number} start row of index 0
 * @param {number} last index
 * @param {number} at index, may be a fraction
 */
function interpolated(values, start, last, at) {
  const low = Math.min(Math.max(Math.floor(at), 0), last);
  const high = Math.min(low + 1, last);
  const share = Math.min(Math.max(at - low, 0), 1);
  return values[start + low] * (1 - share) + values[start + high] * share;
}

/**
 * @param {Episode} episode
 * @param {number} frame
 */
export const progressAt = (episode, frame) =>
  interpolated(episode.progress, 0, episode.frames - 1, frame);

/**
 * @param {Episode} episode
 * @param {number} frame
 * @returns {EgoState}
 */
export function egoAt(episode, frame) {
  const at = (/** @type {Float64Array} */ values) =>
    interpolated(values, 0, episode.frames - 1, frame);
  const { x, y, yaw, speed, acceleration } = episode.ego;
  return { x: at(x), y: at(y), yaw: at(yaw), speed: at(speed), acceleration: at(acceleration) };
}

/**
 * @param {Episode} episode
 * @param {number} frame
 * @returns {ActorState[]}
 */
export function actorsAt(episode, frame) {
  const { x, y, yaw } = episode.pose;
  return episode.trajectories.flatMap((trajectory) => {
    const at = frame - trajectory.first;
    if (at < 0 || at >= trajectory.count) return [];
    const value = (/** @type {Float64Array} */ values) =>
      interpolated(values, trajectory.start, trajectory.count - 1, at);
    return { ...trajectory, x: value(x), y: value(y), yaw: value(yaw) };
  });
}

/**
 * @param {Episode} episode
 * @param {number} frame
 * @returns {{place: StopLine, state: number}[]}
 */
export function lightsAt(episode, frame) {
  const row = wholeFrame(frame);
  return episode.facts.signals.map((place, signal) => ({
    place,
    state: episode.lights[signal * episode.frames + row],
  }));
}

/**
 * Return the waypoints in the world; they were planned in the ego frame of the plan's tick.
 * @param {Episode} episode
 * @param {number} seconds
 * @returns {Point[]}
 */
export function planAt(episode, seconds) {
  const { ticks, values } = episode.plans;
  const row = newestRow(episode, ticks, seconds, PLAN_SHOWN);
  if (row < 0) return [];
  const frame = (ticks[row] * episode.facts.tick) / episode.facts.step;
  const ego = egoAt(episode, frame);
  const cos = Math.cos(ego.yaw);
  const sin = Math.sin(ego.yaw);
  return Array.from({ length: WAYPOINTS }, (_, place) => {
    const ahead = values[2 * place][row];
    const left = values[2 * place + 1][row];
    return [ego.x + cos * ahead - sin * left, ego.y + sin * ahead + cos * left];
  });
}

/**
 * Return the planner's own reason, null where it gave none; the actor is -1 where there is none.
 * @param {Episode} episode
 * @param {number} frame
 */
export function reasonAt(episode, frame) {
  if (!episode.reasons) return null;
  const row = wholeFrame(frame);
  const cause = episode.reasons.causes[row] - 1;
  if (cause < 0) return null;
  return { cause: episode.facts.causes[cause], actor: episode.reasons.actors[row] - 1 };
}

/**
 * Return the actors that the planner attends to, the most relevant first.
 * @param {Episode} episode
 * @param {number} seconds
 * @returns {{actor: number, share: number}[]}
 */
export function attentionAt(episode, seconds) {
  const { ticks, starts, actors, shares } = episode.attention;
  const row = newestRow(episode, ticks, seconds, ATTENTION_SHOWN);
  if (row < 0) return [];
  return shares
    .slice(starts[row], starts[row + 1])
    .map((share, place) => ({ actor: actors[starts[row] + place], share }));
}

/**
 * Return the id of the actor that the expert would brake for, -1 for no actor, null where that is
 * not known.
 * @param {Episode} episode
 * @param {number} seconds
 */
export function expertActorAt(episode, seconds) {
  if (!episode.expert) return null;
  const row = newestRow(episode, episode.expert.ticks, seconds, ATTENTION_SHOWN);
  return row < 0 ? null : episode.expert.actors[row] - 1;
}

/**
 * @param {Episode} episode
 * @param {number} frame
 */
export const limitAt = (episode, frame) => episode.limits[wholeFrame(frame)];

/**
 * Return an actor's kind and id as text.
 * @param {Episode} episode
 * @param {number} id
 */
export function actorName(episode, id) {
  const found = episode.trajectories.find((item) => item.id === id);
  return `${found ? asWords(episode.facts.kinds[found.kind]) : "actor"} ${id}`;
}
