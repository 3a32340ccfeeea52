// @ts-check
// A town: areas, roads and paint on two levels.

/** @import { Columns } from "./columns.js" */
/** @import { TownPayload } from "./payload.js" */
/** @import { Colours } from "./palette.js" */
import { requiredColumn } from "./columns.js";

const CENTIMETRES = 100; // the unit of a town's columns
const LEVELS = [
  ["pavement", "junction", "road", "edge", "between", "middle", "zebra", "stop"],
  ["bridge", "road", "edge", "between", "middle"],
];
const AREAS = new Set(["pavement", "junction", "zebra"]);
/** @type {Record<string, number>} */
const PAINT_WIDTHS = { edge: 0.14, between: 0.13, middle: 0.17, stop: 0.4 }; // m
const LANE_DASHES = [3, 4]; // m of paint, m without
/** @type {Record<string, string>} kinds that have the colour of another */
const COLOUR_NAMES = { junction: "road", edge: "paint", between: "paint", stop: "paint" };

/** @typedef {[left: number, bottom: number, right: number, top: number]} Box m */
/** @typedef {{path: Path2D, box: Box, width: number}} Piece */

/**
 * @typedef {object} Town
 * @property {string} name
 * @property {string} checksum
 * @property {Map<string, Piece[]>[]} layers pieces by kind, the ground first, in drawing order
 */

/**
 * @param {Columns} columns
 * @param {TownPayload} payload
 * @returns {Town}
 */
export function makeTown(columns, { name, checksum, kinds }) {
  const column = (/** @type {string} */ key) => requiredColumn(columns, key);
  const [counts, widths, levels, x, y] = ["count", "width", "upper", "x", "y"].map(column);
  const layers = LEVELS.map(
    (names) => new Map(names.map((kind) => [kind, /** @type {Piece[]} */ ([])])),
  );
  let start = 0;
  column("kind").forEach((kind, place) => {
    const end = start + counts[place];
    const width = widths[place] / CENTIMETRES;
    const piece = makePiece(x.subarray(start, end), y.subarray(start, end), width);
    layers[levels[place]].get(kinds[kind])?.push(piece);
    start = end;
  });
  return { name, checksum, layers };
}

/**
 * @param {Int32Array} xs
 * @param {Int32Array} ys
 * @param {number} width m
 * @returns {Piece}
 */
function makePiece(xs, ys, width) {
  const path = new Path2D();
  /** @type {Box} */
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  xs.forEach((value, place) => {
    const x = value / CENTIMETRES;
    const y = ys[place] / CENTIMETRES;
    path.lineTo(x, y);
    box[0] = Math.min(box[0], x - width);
    box[1] = Math.min(box[1], y - width);
    box[2] = Math.max(box[2], x + width);
    box[3] = Math.max(box[3], y + width);
  });
  return { path, box, width };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Town} town
 * @param {Box} visible
 * @param {Colours} colours
 */
export function drawTown(context, town, visible, colours) {
  context.lineCap = "butt";
  context.lineJoin = "round";
  for (const layer of town.layers) {
    for (const [kind, pieces] of layer) drawPieces(context, kind, pieces, visible, colours);
  }
  context.setLineDash([]);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {string} kind
 * @param {Piece[]} pieces
 * @param {Box} visible
 * @param {Colours} colours
 */
function drawPieces(context, kind, pieces, visible, colours) {
  context.fillStyle = context.strokeStyle = colours[COLOUR_NAMES[kind] ?? kind];
  context.setLineDash(kind === "between" ? LANE_DASHES : []);
  for (const { path, box, width } of pieces) {
    const [left, bottom, right, top] = visible;
    if (box[0] > right || box[2] < left || box[1] > top || box[3] < bottom) continue;
    if (AREAS.has(kind)) {
      context.fill(path);
    } else {
      context.lineWidth = PAINT_WIDTHS[kind] ?? width;
      context.stroke(path);
    }
  }
}
