// @ts-check
// Colours of what is drawn. Python puts them into the page, as pictures and films use them, too.

import { embeddedJson } from "../shared/dom.js";

/** @typedef {Record<string, string>} Colours by name, as #rrggbb */

const palette = /** @type {Record<"light" | "dark", Colours>} */ (embeddedJson("palette"));

/** Return the colours of the current theme. */
export const currentColours = () =>
  palette[document.documentElement.dataset.theme === "dark" ? "dark" : "light"];

/**
 * Mix two colours.
 * @param {string} from as #rrggbb
 * @param {string} to as #rrggbb
 * @param {number} share of the second
 */
export function mixed(from, to, share) {
  const channel = (/** @type {string} */ colour, /** @type {number} */ place) =>
    parseInt(colour.slice(place, place + 2), 16);
  const channels = [1, 3, 5].map((place) =>
    Math.round(channel(from, place) * (1 - share) + channel(to, place) * share),
  );
  return `rgb(${channels.join(",")})`;
}
