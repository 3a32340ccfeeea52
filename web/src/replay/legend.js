// @ts-check
// The legend in the help: samples of all that scenes show.

/** @import { BoxMeaning } from "./actors.js" */
/** @import { Colours } from "./palette.js" */
import { element } from "../shared/dom.js";
import { drawActor, drawBox, drawEgo } from "./actors.js";
import { mixed } from "./palette.js";
import { drawPlan } from "./scene.js";
import { contextOf } from "./timeline.js";

const SCALE = 5; // px a metre
const WIDTH = 108; // px of a sample
const HEIGHT = 40;

/** @typedef {(context: CanvasRenderingContext2D, colours: Colours) => void} DrawSample */

/** @type {[kind: string, name: string, length: number, width: number][]} sizes in m */
const ACTORS = [
  ["car", "car", 4.6, 1.9],
  ["van", "van", 5.4, 2.1],
  ["truck", "truck", 9, 2.5],
  ["bus", "bus", 12, 2.5],
  ["motorcycle", "motorcycle", 2.2, 0.9],
  ["bicycle", "bicycle", 1.8, 0.7],
  ["pedestrian", "pedestrian", 0.9, 0.9],
  ["static", "object", 1.5, 1.5],
];

/** @type {[name: string, draw: DrawSample][]} */
const SAMPLES = [
  ["Ego, with its plan", drawEgoSample],
  ...ACTORS.map(([kind, name, length, width]) => actorSample(kind, name, length, width)),
  ["Red: relevant to the planner; red box: most relevant", boxSample("relevance", 1)],
  [
    "Blue box: the actor that the expert would brake for (in replays made with --expert)",
    boxSample("expert", 0),
  ],
  [
    "White dashes: the actor that the planner brakes for (its own reason)",
    boxSample("ownReason", 0),
  ],
  ["Route", drawRouteSample],
];

const SIGNS = [
  { sign: "◆", name: "Hazard; the letter is its kind", kind: "hazard" },
  { sign: "✕", name: "Infraction", kind: "infraction" },
];

/**
 * @param {HTMLElement} list
 * @param {Colours} colours
 */
export function showLegend(list, colours) {
  const ratio = window.devicePixelRatio || 1;
  const samples = SAMPLES.map(([name, draw]) => {
    const canvas = element("canvas", {
      width: WIDTH * ratio,
      height: HEIGHT * ratio,
      "aria-hidden": "true",
    });
    const context = contextOf(canvas);
    const scale = SCALE * ratio;
    context.fillStyle = colours.road;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.setTransform(scale, 0, 0, -scale, (WIDTH / 2) * ratio, (HEIGHT / 2) * ratio);
    draw(context, colours);
    return element("li", {}, canvas, element("span", {}, name));
  });
  const signs = SIGNS.map(({ sign, name, kind }) =>
    element(
      "li",
      {},
      element("span", { class: `legend-sign ${kind}`, "aria-hidden": "true" }, sign),
      element("span", {}, name),
    ),
  );
  list.replaceChildren(...samples, ...signs);
}

/** @type {DrawSample} */
function drawEgoSample(context, colours) {
  /** @type {[number, number][]} */
  const waypoints = [
    [2, 0],
    [5, 0],
    [8, 0],
  ];
  drawPlan(context, waypoints, { x: -4, y: 0 }, SCALE, colours);
  drawEgo(context, { x: -5, y: 0, yaw: 0 }, [4.9, 2.13], SCALE, colours);
}

/**
 * @param {string} kind
 * @param {string} name
 * @param {number} length
 * @param {number} width
 * @returns {[name: string, draw: DrawSample]}
 */
function actorSample(kind, name, length, width) {
  const enlarged = length < 3 ? 3 : 1;
  return [
    name,
    (context, colours) => {
      context.scale(enlarged, enlarged);
      const actor = { x: 0, y: 0, yaw: 0, length, width };
      drawActor(context, kind, actor, colours.actor, SCALE * enlarged, colours);
    },
  ];
}

/**
 * @param {BoxMeaning} meaning
 * @param {number} relevance
 * @returns {DrawSample}
 */
function boxSample(meaning, relevance) {
  return (context, colours) => {
    const actor = { x: 0, y: 0, yaw: 0, length: 4.6, width: 1.9 };
    const fill = mixed(colours.actor, colours.relevance, relevance);
    drawActor(context, "car", actor, fill, SCALE, colours);
    drawBox(context, actor, meaning, SCALE, colours);
  };
}

/** @type {DrawSample} */
function drawRouteSample(context, colours) {
  context.strokeStyle = colours.route;
  context.lineWidth = 0.9;
  context.beginPath();
  context.moveTo(-9, 0);
  context.lineTo(9, 0);
  context.stroke();
}
