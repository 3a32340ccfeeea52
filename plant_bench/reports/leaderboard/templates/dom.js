"use strict";
// Elements are made here and nowhere else; text from outside becomes text nodes only.

/** Make an element: properties that start with "on" are listeners, the rest attributes. */
function el(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

/** Replace all that an element holds. */
function fill(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null));
  return element;
}

const NAME_LENGTH = 48; // characters of a name from outside that are shown

/** A name from outside: kept apart from the direction of what is around it, cut where very long. */
function nameOf(text, length = NAME_LENGTH) {
  const letters = Array.from(text);
  if (letters.length <= length) return el("bdi", {}, text);
  return el("bdi", { title: letters.slice(0, 500).join("") }, cut(text, length));
}

function cut(text, length = NAME_LENGTH) {
  const letters = Array.from(text);
  return letters.length <= length ? text : letters.slice(0, length - 1).join("") + "…";
}

/** A table wider than the page scrolls by itself, with the keyboard too. */
function scrolling(label, table) {
  return el("div", { class: "scrolling", role: "region", "aria-label": label, tabindex: "0" }, table);
}

/** One tab stop for a table of buttons: arrow keys go on from there. */
function roving(table) {
  const rows = () =>
    [...table.tBodies[0].rows].map((row) => [...row.querySelectorAll("button")]).filter((row) => row.length);
  const all = rows().flat();
  all.forEach((button, place) => (button.tabIndex = place ? -1 : 0));
  table.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
    const button = event.target.closest("button");
    if (!step || !button) return;
    const grid = rows();
    const row = grid.findIndex((buttons) => buttons.includes(button));
    const next = grid[row + step[0]]?.[grid[row].indexOf(button) + step[1]];
    if (!next) return;
    event.preventDefault();
    button.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
  return table;
}

const counted = (count, name) => `${count} ${name}${count === 1 ? "" : "s"}`;
const words = (name) => name.replaceAll("_", " ");
const known = (number) => number !== null && number !== undefined;
const fixed = (number, digits) => (known(number) ? number.toFixed(digits) : "–");
const signed = (number, digits) => (number < 0 ? "−" : "+") + Math.abs(number).toFixed(digits);
const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
const percent = (share) => (known(share) ? `${Math.round(100 * share)} %` : "–");
