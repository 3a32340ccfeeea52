// @ts-check

/**
 * Return an identifier as words: "red_light" becomes "red light".
 * @param {string} identifier
 */
export const asWords = (identifier) => identifier.replaceAll("_", " ");
