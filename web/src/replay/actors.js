// @ts-check
// Road users from above; each kind has its own shape. Drawn at the origin, heading along +x.

/** @import { ActorState, Pose } from "./episode.js" */
/** @import { Colours } from "./palette.js" */

/** @typedef {CanvasRenderingContext2D} Context */
/** @typedef {Pick<ActorState, "x" | "y" | "yaw" | "length" | "width">} Extended a pose with a size */

/**
 * Draws a shape; l and w are its length and width.
 * @typedef {(context: Context, l: number, w: number, colours: Colours) => void} DrawShape
 */

/** @type {Record<string, DrawShape>} */
const SHAPES = {
  car(context, l, w, colours) {
    body(context, l, w, Math.min(l, w) * 0.28);
    glass(context, colours, l * 0.1, l * 0.26, w * 0.76);
    glass(context, colours, -l * 0.36, -l * 0.26, w * 0.7);
  },
  van(context, l, w, colours) {
    body(context, l, w, w * 0.14);
    glass(context, colours, l * 0.3, l * 0.42, w * 0.84);
  },
  truck(context, l, w, colours) {
    context.beginPath();
    context.rect(-l / 2, -w / 2, l * 0.74, w);
    context.roundRect(l * 0.27, -w * 0.46, l * 0.23, w * 0.92, w * 0.12);
    context.fill();
    context.stroke();
    glass(context, colours, l * 0.42, l * 0.475, w * 0.78);
  },
  bus(context, l, w, colours) {
    body(context, l, w, w * 0.1);
    for (let place = -4; place < 4; place++) {
      for (const side of [-0.42, 0.3]) {
        context.fillStyle = colours.glass;
        context.fillRect((place + 0.2) * l * 0.11, side * w, l * 0.075, w * 0.12);
      }
    }
    glass(context, colours, l * 0.44, l * 0.485, w * 0.84);
  },
  motorcycle(context, l, w, colours) {
    body(context, l, w * 0.5, w * 0.25);
    disc(context, colours.glass, -l * 0.05, w * 0.36);
  },
  bicycle(context, l, w) {
    const width = context.lineWidth;
    context.beginPath();
    context.rect(-l / 2, -w * 0.09, l, w * 0.18);
    context.rect(l * 0.2, -w / 2, l * 0.09, w);
    context.fill();
    context.lineWidth = width * 0.7;
    context.stroke();
    context.lineWidth = width;
    disc(context, context.fillStyle, -l * 0.08, w * 0.34);
  },
  pedestrian(context, l, w) {
    const radius = Math.max(l, w) / 2;
    context.beginPath();
    context.moveTo(radius * 1.7, 0);
    context.arc(0, 0, radius, 0.75, -0.75 + 2 * Math.PI);
    context.closePath();
    context.fill();
    context.stroke();
  },
  static(context, l, w) {
    body(context, l, w, 0);
    context.beginPath();
    context.moveTo(-l / 2, -w / 2);
    context.lineTo(l / 2, w / 2);
    context.moveTo(-l / 2, w / 2);
    context.lineTo(l / 2, -w / 2);
    context.stroke();
  },
};

/** @type {Record<string, number>} */
const MIN_LENGTHS = { pedestrian: 9, bicycle: 9, motorcycle: 9 }; // px

/**
 * @param {Context} context
 * @param {number} l
 * @param {number} w
 * @param {number} radius of the corners
 */
function body(context, l, w, radius) {
  context.beginPath();
  context.roundRect(-l / 2, -w / 2, l, w, radius);
  context.fill();
  context.stroke();
}

/**
 * @param {Context} context
 * @param {Colours} colours
 * @param {number} from along the length
 * @param {number} to
 * @param {number} w
 */
function glass(context, colours, from, to, w) {
  context.fillStyle = colours.glass;
  context.fillRect(Math.min(from, to), -w / 2, Math.abs(to - from), w);
}

/**
 * @param {Context} context
 * @param {string | CanvasGradient | CanvasPattern} colour
 * @param {number} x
 * @param {number} radius
 */
function disc(context, colour, x, radius) {
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, 0, radius, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
}

/**
 * @param {Context} context
 * @param {string} kind
 * @param {Extended} actor
 * @param {string} fill
 * @param {number} scale px a metre
 * @param {Colours} colours
 */
export function drawActor(context, kind, actor, fill, scale, colours) {
  const enlarged = Math.max(1, (MIN_LENGTHS[kind] ?? 0) / (actor.length * scale));
  context.save();
  context.translate(actor.x, actor.y);
  context.rotate(actor.yaw);
  context.fillStyle = fill;
  context.strokeStyle = colours.outline;
  context.lineWidth = 1.1 / scale;
  (SHAPES[kind] ?? SHAPES.static)(
    context,
    actor.length * enlarged,
    actor.width * enlarged,
    colours,
  );
  context.restore();
}

/**
 * Boxes around actors, as in the paper's figure. Each meaning has a size of its own, so that no two
 * boxes cover each other.
 * @typedef {object} BoxStyle
 * @property {number} metres distance from the actor
 * @property {number} pixels least distance from the actor
 * @property {[colour: string, width: number, dashes: number[]][]} strokes
 */

/** @typedef {"relevance" | "expert" | "ownReason"} BoxMeaning */

/** @type {Record<BoxMeaning, BoxStyle>} */
const BOXES = {
  relevance: { metres: 0.5, pixels: 4, strokes: [["relevance", 3, []]] },
  expert: { metres: 0.9, pixels: 8, strokes: [["expert", 3, []]] },
  ownReason: {
    metres: 1.3,
    pixels: 12,
    strokes: [
      ["outline", 4, []],
      ["ownReason", 2, [7, 4]],
    ],
  },
};

/**
 * @param {Context} context
 * @param {Extended} actor
 * @param {BoxMeaning} meaning
 * @param {number} scale px a metre
 * @param {Colours} colours
 */
export function drawBox(context, actor, meaning, scale, colours) {
  const { metres, pixels, strokes } = BOXES[meaning];
  const margin = Math.max(metres, pixels / scale);
  context.save();
  context.translate(actor.x, actor.y);
  context.rotate(actor.yaw);
  for (const [colour, lineWidth, dashes] of strokes) {
    context.strokeStyle = colours[colour];
    context.lineWidth = lineWidth / scale;
    context.setLineDash(dashes.map((part) => part / scale));
    const length = actor.length + 2 * margin;
    const width = actor.width + 2 * margin;
    context.strokeRect(-length / 2, -width / 2, length, width);
  }
  context.restore();
}

/**
 * @param {Context} context
 * @param {Pose} ego
 * @param {[length: number, width: number]} extent
 * @param {number} scale px a metre
 * @param {Colours} colours
 */
export function drawEgo(context, ego, extent, scale, colours) {
  const [l, w] = extent;
  context.save();
  context.translate(ego.x, ego.y);
  context.rotate(ego.yaw);
  context.lineJoin = "round";
  context.strokeStyle = colours.ego;
  context.lineWidth = Math.max(0.12, 1.2 / scale);
  context.strokeRect(-l / 2, -w / 2, l, w);
  context.fillStyle = colours.ego;
  context.strokeStyle = colours.outline;
  context.lineWidth = 1.2 / scale;
  context.beginPath();
  context.moveTo(l / 2, 0);
  context.lineTo(-l / 2, w / 2);
  context.lineTo(-l / 2, -w / 2);
  context.closePath();
  context.fill();
  context.stroke();
  context.restore();
}
