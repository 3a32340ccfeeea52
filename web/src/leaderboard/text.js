// @ts-check
// Numbers and names as text.

import { element } from "../shared/dom.js";

const NAME_LENGTH = 48; // characters of an external name that are shown
const TOOLTIP_LENGTH = 500; // characters of a truncated name that its tooltip shows

/**
 * An external name: kept apart from the writing direction around it, truncated where very long.
 * @param {string} text
 * @param {number} [length]
 */
export function nameElement(text, length = NAME_LENGTH) {
  const letters = Array.from(text);
  if (letters.length <= length) return element("bdi", {}, text);
  return element(
    "bdi",
    { title: letters.slice(0, TOOLTIP_LENGTH).join("") },
    truncated(text, length),
  );
}

/**
 * @param {string} text
 * @param {number} [length]
 */
export function truncated(text, length = NAME_LENGTH) {
  const letters = Array.from(text);
  return letters.length <= length ? text : letters.slice(0, length - 1).join("") + "…";
}

/**
 * @param {number} count
 * @param {string} noun
 */
export const pluralized = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

/**
 * Tell whether a value is known.
 * @template T
 * @param {T | null | undefined} value
 * @returns {value is T}
 */
export const isKnown = (value) => value !== null && value !== undefined;

/**
 * @param {number | null | undefined} value
 * @param {number} digits
 */
export const fixed = (value, digits) => (isKnown(value) ? value.toFixed(digits) : "–");

/**
 * @param {number} value
 * @param {number} digits
 */
export const signed = (value, digits) => (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits);

/**
 * Minutes and seconds.
 * @param {number} seconds
 */
export const formatDuration = (seconds) =>
  `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;

/** @param {number | null | undefined} share */
export const percent = (share) => (isKnown(share) ? `${Math.round(100 * share)} %` : "–");

/** @param {number | null | undefined} p */
export const pValue = (p) =>
  !isKnown(p) ? "not known" : p < 0.001 ? "< 0.001" : `= ${p.toFixed(3)}`;

/**
 * How an episode ended, in short.
 * @param {string} status
 */
export const shortStatus = (status) => status.replace("Failed - ", "");
