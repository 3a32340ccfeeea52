// @ts-check
// Beside a scene, as text: the state of the moment, and the list of events.

/** @import { Episode } from "./episode.js" */
/** @import { Mark } from "./marks.js" */
import { element } from "../shared/dom.js";
import {
  actorName,
  attentionAt,
  egoAt,
  expertActorAt,
  frameAt,
  limitAt,
  progressAt,
  reasonAt,
} from "./episode.js";
import { causeName, formatTime, truncatedTitle } from "./labels.js";
import { hazardMark, inOrderOfTime } from "./marks.js";

/** @typedef {Mark & {button: HTMLButtonElement}} LogEntry */
/** @typedef {{node: HTMLElement, update: (seconds: number) => void}} Panel */

/**
 * @param {Episode} episode
 * @param {(mark: Mark) => void} onSelect called when the user selects an event
 * @returns {Panel}
 */
export function makePanel(episode, onSelect) {
  const state = element("dl", { class: "now" });
  /** @type {Map<string, HTMLElement>} */
  const values = new Map();
  for (const name of stateNames(episode)) {
    const value = element("dd");
    values.set(name, value);
    state.append(element("dt", {}, name), value);
  }
  const log = logMarks(episode).map((mark) => logEntry(mark, onSelect));
  const node = element(
    "section",
    { class: "panel" },
    element("h2", {}, truncatedTitle(episode.facts.title)),
    state,
    notesOf(episode).map((note) => element("p", { class: "note small" }, note)),
    element("h3", {}, eventCounts(episode)),
    element(
      "ol",
      { class: "log" },
      log.map(({ button }) => element("li", {}, button)),
    ),
  );
  const update = (/** @type {number} */ seconds) => {
    updateState(episode, values, seconds);
    updateLog(log, seconds);
  };
  return { node, update };
}

/** @param {Episode} episode */
function stateNames(episode) {
  const names = ["Speed", "Acceleration", "Progress"];
  if (episode.reasons) names.push("Reason");
  if (episode.attention.ticks.length) names.push("Attends to");
  if (episode.expert) names.push("Expert");
  return names;
}

/** @param {Episode} episode */
function eventCounts({ facts }) {
  const count = facts.infractions.length;
  const reached = facts.hazards.filter((item) => item.phase !== "dormant").length;
  const left = facts.hazards.length - reached;
  const infractions = `${count} ${count === 1 ? "infraction" : "infractions"}`;
  return `${infractions}, ${reached} hazards${left ? `, ${left} more not reached` : ""}`;
}

/**
 * The timeline's marks, and the hazards that did not happen.
 * @param {Episode} episode
 */
function logMarks({ facts, marks }) {
  const notPlayed = facts.hazards.filter(({ phase }) => phase === "void");
  return inOrderOfTime([...marks, ...notPlayed.map(hazardMark)]);
}

/**
 * @param {Mark} mark
 * @param {(mark: Mark) => void} onSelect
 * @returns {LogEntry}
 */
function logEntry(mark, onSelect) {
  const button = element(
    "button",
    {
      type: "button",
      class: mark.infraction ? "event infraction" : "event",
      title: mark.title || null,
      onclick: () => onSelect(mark),
    },
    element("span", { class: "sign", "aria-hidden": "true" }, mark.infraction ? "✕" : "◆"),
    element("span", { class: "when" }, formatTime(mark.time)),
    element(
      "span",
      { class: "what" },
      element("b", {}, mark.name),
      element("span", { class: "small" }, mark.detail),
    ),
  );
  return { ...mark, button };
}

/** @param {Episode} episode */
function notesOf({ facts, town }) {
  const notes = [];
  if (facts.result.reason) notes.push(`Message: ${facts.result.reason}`);
  if (facts.attentionNote) notes.push(`No attention is shown. ${facts.attentionNote}`);
  if (facts.expertNote) notes.push(`The expert is not always shown. ${facts.expertNote}`);
  if (town.checksum !== facts.townChecksum) {
    notes.push("The town has changed since: the map under the scene may be wrong.");
  }
  return notes;
}

/**
 * @param {Episode} episode
 * @param {Map<string, HTMLElement>} values
 * @param {number} seconds
 */
function updateState(episode, values, seconds) {
  const frame = frameAt(episode, seconds);
  const ego = egoAt(episode, frame);
  const limit = limitAt(episode, frame);
  const [top] = attentionAt(episode, seconds);
  const texts = {
    Speed: `${(3.6 * ego.speed).toFixed(0)} of ${(3.6 * limit).toFixed(0)} km/h`,
    Acceleration: `${ego.acceleration.toFixed(1).replace("-", "−")} m/s²`,
    Progress:
      `${progressAt(episode, frame).toFixed(0)} of ` +
      `${episode.facts.result.length.toFixed(0)} m`,
    Reason: reasonText(episode, frame),
    "Attends to": top ? actorName(episode, top.actor) : "no actor",
    Expert: expertText(episode, seconds),
  };
  for (const [name, text] of Object.entries(texts)) {
    const value = values.get(name);
    if (value && value.textContent !== text) value.textContent = text;
  }
}

/**
 * @param {Episode} episode
 * @param {number} frame
 */
function reasonText(episode, frame) {
  const reason = reasonAt(episode, frame);
  if (!reason) return "none given";
  const actor = reason.actor >= 0 ? `: ${actorName(episode, reason.actor)}` : "";
  return `${causeName(reason.cause)}${actor}`;
}

/**
 * @param {Episode} episode
 * @param {number} seconds
 */
function expertText(episode, seconds) {
  const actor = expertActorAt(episode, seconds);
  if (actor === null) return "not known";
  return actor < 0
    ? "would not brake for any actor"
    : `would brake for ${actorName(episode, actor)}`;
}

/**
 * Mark the newest event as the current one.
 * @param {LogEntry[]} log
 * @param {number} seconds
 */
function updateLog(log, seconds) {
  const current = log.findLast((entry) => entry.time <= seconds + 0.05);
  if (current && !current.button.hasAttribute("aria-current")) scrollLogTo(current.button);
  for (const entry of log) {
    if (entry === current) entry.button.setAttribute("aria-current", "true");
    else entry.button.removeAttribute("aria-current");
  }
}

/**
 * Scroll the log, but never the page.
 * @param {HTMLButtonElement} button
 */
function scrollLogTo(button) {
  const log = button.closest(".log");
  const item = button.parentElement;
  if (!log || !item) return;
  const top = item.offsetTop;
  if (top < log.scrollTop || top + button.offsetHeight > log.scrollTop + log.clientHeight) {
    log.scrollTop = top - log.clientHeight / 2;
  }
}
