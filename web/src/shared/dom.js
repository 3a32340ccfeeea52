// @ts-check
// The pages make their elements here and nowhere else; text from outside becomes text nodes only.

/**
 * @typedef {Node | string | null | undefined} Child null and undefined are left out
 * @typedef {Child | Child[]} Content
 * @typedef {string | number | boolean | null | undefined | ((event: Event) => void)} Property
 */

/**
 * Make an element.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, Property>} [properties] names that start with "on" are listeners, all
 *     others attributes; null, undefined and false are left out
 * @param {...Content} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...present(children));
  return made;
}

/**
 * Replace all that an element holds.
 * @param {Element} parent
 * @param {...Content} children
 */
export function replaceContent(parent, ...children) {
  parent.replaceChildren(...present(children));
}

/**
 * @param {Content[]} children
 * @returns {(Node | string)[]}
 */
function present(children) {
  return children.flat().filter((child) => child !== null && child !== undefined);
}

/**
 * Return an element of the page by its id.
 * @template {HTMLElement} T
 * @param {string} id
 * @param {new () => T} type
 * @returns {T}
 */
export function byId(id, type) {
  const found = document.getElementById(id);
  if (found instanceof type) return found;
  throw new Error(`Expected an element #${id} of type ${type.name} in the page, got ${found}.`);
}

/**
 * Return the JSON that Python put into the page, in a script element of this id.
 * @param {string} id
 * @returns {unknown}
 */
export function embeddedJson(id) {
  return JSON.parse(byId(id, HTMLScriptElement).text);
}
