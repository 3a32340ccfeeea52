// @ts-check
// Display texts for infractions, hazards, causes and times.

/** @import { HazardFacts, InfractionFacts } from "./payload.js" */
import { asWords } from "../shared/text.js";

const TITLE_LENGTH = 40; // characters of a title that are shown

/** @type {Record<string, string>} */
const INFRACTION_NAMES = {
  collision_pedestrian: "Collision with a pedestrian",
  collision_vehicle: "Collision with a vehicle",
  collision_static: "Collision with an object",
  red_light: "Red light",
  outside_lanes: "Outside the lanes",
  route_deviation: "Left the route",
  blocked: "Blocked",
  timeout: "Timed out",
};

/** @type {Record<string, string>} */
const CAUSE_NAMES = {
  free: "nothing limits its speed",
  limit: "speed limit or curve",
  light: "traffic light",
  leader: "vehicle ahead",
  conflict: "crossing path",
  junction: "junction exit blocked",
};

/** @type {Record<string, string>} */
const PHASE_NAMES = {
  done: "met",
  void: "did not happen",
  committed: "under way",
  armed: "about to begin",
  dormant: "not reached",
};

/** @param {string} cause */
export const causeName = (cause) => CAUSE_NAMES[cause] ?? cause;

/** @param {InfractionFacts} infraction */
export function infractionName({ kind, actorKind }) {
  if (actorKind && kind === "collision_vehicle") return `Collision with a ${asWords(actorKind)}`;
  return INFRACTION_NAMES[kind] ?? asWords(kind);
}

/** @param {InfractionFacts} infraction */
export function infractionDetail({ cause, share, actor, speed, factor }) {
  const parts = [];
  if (cause === "ego") parts.push("the ego hit the other vehicle");
  if (cause === "other") parts.push("the other vehicle hit the ego");
  if (share !== null) parts.push(`${(100 * share).toFixed(1)} % of the route`);
  if (actor !== null) parts.push(`actor ${actor}`);
  parts.push(`at ${(3.6 * speed).toFixed(0)} km/h`);
  if (factor < 1) parts.push(`score × ${factor.toFixed(2)}`);
  return parts.join(", ");
}

/** @param {HazardFacts} hazard */
export const hazardName = ({ kind }) => `Hazard: ${asWords(kind)}`;

/** @param {HazardFacts} hazard */
export function hazardDetail({ phase, reason }) {
  const name = PHASE_NAMES[phase] ?? phase;
  return reason ? `${name}: ${reason}` : name;
}

/**
 * Minutes, seconds and tenths.
 * @param {number} seconds
 */
export function formatTime(seconds) {
  const tenths = Math.round(seconds * 10);
  const rest = (tenths % 600) / 10;
  return `${Math.floor(tenths / 600)}:${rest.toFixed(1).padStart(4, "0")}`;
}

/**
 * A time for screen readers.
 * @param {number} seconds
 */
export function formatSpokenTime(seconds) {
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  return minutes ? `${minutes} min ${whole % 60} s` : `${whole} s`;
}

/** @param {string} title */
export const truncatedTitle = (title) =>
  title.length > TITLE_LENGTH ? `${title.slice(0, TITLE_LENGTH - 1)}…` : title;
