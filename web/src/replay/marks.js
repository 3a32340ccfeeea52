// @ts-check
// Marks on the timeline: infractions and hazards at a time.

/** @import { EpisodePayload, HazardFacts } from "./payload.js" */
import { hazardDetail, hazardName, infractionDetail, infractionName } from "./labels.js";

/**
 * @typedef {object} Mark
 * @property {number} time s
 * @property {boolean} infraction otherwise a hazard
 * @property {string} name
 * @property {string} detail
 * @property {string} [title] tooltip
 */

/**
 * Return an episode's infractions, and the hazards that began, in order of time.
 * @param {EpisodePayload} facts
 * @returns {Mark[]}
 */
export function makeMarks({ infractions, hazards }) {
  return inOrderOfTime([
    ...infractions.map((item) => ({
      time: item.time,
      infraction: true,
      name: infractionName(item),
      detail: infractionDetail(item),
    })),
    ...hazards.filter(({ phase }) => phase !== "void" && phase !== "dormant").map(hazardMark),
  ]);
}

/**
 * @param {HazardFacts} hazard
 * @returns {Mark}
 */
export const hazardMark = (hazard) => ({
  time: hazard.time,
  infraction: false,
  name: hazardName(hazard),
  detail: hazardDetail(hazard),
  title: hazard.sentence,
});

/** @param {Mark[]} marks */
export const inOrderOfTime = (marks) => marks.sort((one, other) => one.time - other.time);
