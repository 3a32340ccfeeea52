// @ts-check
// An episode's scene from above: north up, metres, the town below, marks on top.

/** @import { ActorState, Episode, EgoState, Point, Pose } from "./episode.js" */
/** @import { Colours } from "./palette.js" */
/** @import { Box } from "./town.js" */
import { drawActor, drawBox, drawEgo } from "./actors.js";
import {
  actorsAt,
  attentionAt,
  egoAt,
  expertActorAt,
  frameAt,
  lightsAt,
  planAt,
  reasonAt,
} from "./episode.js";
import { mixed } from "./palette.js";
import { drawTown } from "./town.js";

const LAMPS = ["red", "yellow", "green"]; // from the top
const LIGHT_COLOURS = [null, "green", "yellow", "red"]; // by the state of a light
const RECENT = 2.5; // s for which an infraction stands out

/** @typedef {CanvasRenderingContext2D} Context */

/**
 * What of the world a canvas shows.
 * @typedef {object} View
 * @property {number} x of the centre, m
 * @property {number} y
 * @property {number} scale px a metre
 * @property {number} width px
 * @property {number} height px
 * @property {number} ratio device pixels a px
 */

/**
 * What is drawn of one moment.
 * @typedef {object} Moment
 * @property {EgoState} ego
 * @property {ActorState[]} actors
 * @property {{actor: number, share: number}[]} attention
 * @property {number | undefined} ownActor that the planner brakes for, by its own reason
 * @property {number | null} expertActor that the expert would brake for
 */

/**
 * @param {View} view
 * @returns {Box}
 */
function visibleBox({ x, y, width, height, scale }) {
  const across = width / 2 / scale;
  const up = height / 2 / scale;
  return [x - across, y - up, x + across, y + up];
}

/**
 * @param {View} view
 * @param {number} x m
 * @param {number} y m
 * @returns {Point} px
 */
const onScreen = (view, x, y) => [
  view.width / 2 + (x - view.x) * view.scale,
  view.height / 2 - (y - view.y) * view.scale,
];

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {number} seconds
 * @param {View} view
 * @param {Colours} colours
 */
export function drawScene(context, episode, seconds, view, colours) {
  const frame = frameAt(episode, seconds);
  /** @type {Moment} */
  const moment = {
    ego: egoAt(episode, frame),
    actors: actorsAt(episode, frame),
    attention: attentionAt(episode, seconds),
    ownActor: episode.facts.expertDrove ? undefined : reasonAt(episode, frame)?.actor,
    expertActor: expertActorAt(episode, seconds),
  };
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, view.width * view.ratio, view.height * view.ratio);
  useMetres(context, view);
  drawTown(context, episode.town, visibleBox(view), colours);
  drawRoute(context, episode, view, colours);
  usePixels(context, view);
  drawHazards(context, episode, view, colours);
  useMetres(context, view);
  drawAttentionLines(context, moment, view, colours);
  drawActors(context, episode, moment, view, colours);
  drawEgo(context, moment.ego, episode.facts.egoExtent, view.scale, colours);
  drawPlan(context, planAt(episode, seconds), moment.ego, view.scale, colours);
  drawBoxes(context, moment, view, colours);
  usePixels(context, view);
  drawLights(context, lightsAt(episode, frame), view, colours);
  drawInfractions(context, episode, seconds, view, colours);
  drawScale(context, view, colours);
}

/**
 * @param {Context} context
 * @param {View} view
 */
function usePixels(context, { ratio }) {
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
}

/**
 * @param {Context} context
 * @param {View} view
 */
function useMetres(context, view) {
  const k = view.scale * view.ratio;
  const [x, y] = onScreen(view, 0, 0);
  context.setTransform(k, 0, 0, -k, x * view.ratio, y * view.ratio);
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {View} view
 * @param {Colours} colours
 */
function drawRoute(context, episode, view, colours) {
  context.save();
  context.globalAlpha = 0.55;
  context.strokeStyle = colours.route;
  context.lineWidth = Math.max(0.9, 2 / view.scale);
  context.lineCap = context.lineJoin = "round";
  context.stroke(episode.routePath);
  const last = episode.route.x.length - 1;
  context.globalAlpha = 1;
  context.beginPath();
  context.arc(
    episode.route.x[last],
    episode.route.y[last],
    Math.max(1.6, 5 / view.scale),
    0,
    2 * Math.PI,
  );
  context.lineWidth = Math.max(0.5, 2 / view.scale);
  context.stroke();
  context.restore();
}

/**
 * @param {Context} context
 * @param {Moment} moment
 * @param {View} view
 * @param {Colours} colours
 */
function drawAttentionLines(context, moment, view, colours) {
  const { ego } = moment;
  context.save();
  context.strokeStyle = colours.relevance;
  context.lineCap = "round";
  for (const { actor, share } of moment.attention) {
    const other = moment.actors.find((item) => item.id === actor);
    if (!other) continue;
    context.globalAlpha = 0.25 + 0.65 * share;
    context.lineWidth = (0.8 + 3.2 * share) / view.scale;
    context.beginPath();
    context.moveTo(ego.x, ego.y);
    context.lineTo(other.x, other.y);
    context.stroke();
  }
  context.restore();
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {Moment} moment
 * @param {View} view
 * @param {Colours} colours
 */
function drawActors(context, episode, moment, view, colours) {
  const shares = new Map(moment.attention.map(({ actor, share }) => [actor, share]));
  for (const actor of moment.actors) {
    const fill = mixed(colours.actor, colours.relevance, shares.get(actor.id) ?? 0);
    drawActor(context, episode.facts.kinds[actor.kind], actor, fill, view.scale, colours);
  }
}

/**
 * @param {Context} context
 * @param {Point[]} points
 * @param {Pick<Pose, "x" | "y">} ego
 * @param {number} scale px a metre
 * @param {Colours} colours
 */
export function drawPlan(context, points, ego, scale, colours) {
  if (!points.length) return;
  context.save();
  context.strokeStyle = colours.plan;
  context.lineWidth = 2.2 / scale;
  context.beginPath();
  context.moveTo(ego.x, ego.y);
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
  context.fillStyle = colours.plan;
  context.strokeStyle = colours.outline;
  context.lineWidth = 1 / scale;
  for (const [x, y] of points) {
    context.beginPath();
    context.arc(x, y, 4 / scale, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }
  context.restore();
}

/**
 * @param {Context} context
 * @param {Moment} moment
 * @param {View} view
 * @param {Colours} colours
 */
function drawBoxes(context, moment, view, colours) {
  const top = moment.attention[0];
  for (const actor of moment.actors) {
    if (top && actor.id === top.actor) drawBox(context, actor, "relevance", view.scale, colours);
    if (actor.id === moment.expertActor) drawBox(context, actor, "expert", view.scale, colours);
    if (actor.id === moment.ownActor) drawBox(context, actor, "ownReason", view.scale, colours);
  }
}

/**
 * Stop lines, and beside each a signal head with three lamps: the lit one's place shows the state,
 * too.
 * @param {Context} context
 * @param {ReturnType<typeof lightsAt>} lights
 * @param {View} view
 * @param {Colours} colours
 */
function drawLights(context, lights, view, colours) {
  for (const { place, state } of lights) {
    const lit = LIGHT_COLOURS[state];
    if (!lit) continue;
    const [x, y, heading, half] = place;
    const left = onScreen(view, x - Math.sin(heading) * half, y + Math.cos(heading) * half);
    const right = onScreen(view, x + Math.sin(heading) * half, y - Math.cos(heading) * half);
    context.strokeStyle = colours[lit];
    context.lineWidth = 4;
    context.beginPath();
    context.moveTo(...left);
    context.lineTo(...right);
    context.stroke();
    const head = onScreen(
      view,
      x + Math.sin(heading) * (half + 2),
      y - Math.cos(heading) * (half + 2),
    );
    context.fillStyle = colours.outline;
    context.beginPath();
    context.roundRect(head[0] - 7, head[1] - 18, 14, 36, 4);
    context.fill();
    context.strokeStyle = colours.paint;
    context.lineWidth = 1;
    context.stroke();
    LAMPS.forEach((lamp, row) => {
      context.fillStyle = lamp === lit ? colours[lamp] : colours.lampOff;
      context.beginPath();
      context.arc(head[0], head[1] - 11 + 11 * row, 4.4, 0, 2 * Math.PI);
      context.fill();
    });
  }
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {View} view
 * @param {Colours} colours
 */
function drawHazards(context, episode, view, colours) {
  context.font = "bold 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const item of episode.facts.hazards) {
    if (item.phase === "void") continue;
    const [x, y] = onScreen(view, item.place[0], item.place[1]);
    drawDiamond(context, x, y, item.letter, colours);
  }
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {number} seconds
 * @param {View} view
 * @param {Colours} colours
 */
function drawInfractions(context, episode, seconds, view, colours) {
  for (const item of episode.facts.infractions) {
    if (item.kind === "outside_lanes" || item.time > seconds + 1e-6) continue;
    const [x, y] = onScreen(view, item.x, item.y);
    drawCross(context, x, y, seconds - item.time < RECENT, colours);
  }
}

/**
 * @param {Context} context
 * @param {number} x px
 * @param {number} y px
 * @param {string} letter
 * @param {Colours} colours
 */
function drawDiamond(context, x, y, letter, colours) {
  context.save();
  context.globalAlpha = 0.9;
  context.translate(x, y);
  context.rotate(Math.PI / 4);
  context.fillStyle = colours.hazard;
  context.strokeStyle = colours.outline;
  context.lineWidth = 1.2;
  context.beginPath();
  context.rect(-8, -8, 16, 16);
  context.fill();
  context.stroke();
  context.rotate(-Math.PI / 4);
  context.fillStyle = colours.outline;
  context.fillText(letter, 0, 0.5);
  context.restore();
}

/**
 * A cross in a disc. While the infraction is recent, the disc is beside a ring around its place, so
 * that it covers nothing.
 * @param {Context} context
 * @param {number} x px
 * @param {number} y px
 * @param {boolean} recent
 * @param {Colours} colours
 */
function drawCross(context, x, y, recent, colours) {
  context.save();
  context.strokeStyle = colours.infraction;
  if (recent) {
    context.lineWidth = 4;
    context.beginPath();
    context.arc(x, y, 34, 0, 2 * Math.PI);
    context.stroke();
  }
  const [left, up] = recent ? [x + 25, y - 25] : [x, y];
  const radius = recent ? 12 : 8;
  context.lineWidth = 2;
  context.strokeStyle = "#ffffff";
  context.fillStyle = colours.infraction;
  context.beginPath();
  context.arc(left, up, radius, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
  const arm = radius / 2.2;
  context.lineWidth = 2.5;
  context.beginPath();
  for (const side of [-1, 1]) {
    context.moveTo(left - arm, up - arm * side);
    context.lineTo(left + arm, up + arm * side);
  }
  context.stroke();
  context.restore();
}

/**
 * @param {Context} context
 * @param {View} view
 * @param {Colours} colours
 */
function drawScale(context, view, colours) {
  const metres = [5, 10, 20, 50, 100, 200].find((length) => length * view.scale > 60) ?? 500;
  const length = metres * view.scale;
  const y = view.height - 14;
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  const strokes = [
    { colour: colours.labelBack, lineWidth: 5 },
    { colour: colours.label, lineWidth: 2 },
  ];
  for (const { colour, lineWidth } of strokes) {
    context.strokeStyle = colour;
    context.lineWidth = lineWidth;
    context.beginPath();
    context.moveTo(14, y);
    context.lineTo(14 + length, y);
    context.stroke();
  }
  context.lineWidth = 3;
  context.strokeStyle = colours.labelBack;
  context.strokeText(`${metres} m`, 18 + length, y + 4);
  context.fillStyle = colours.label;
  context.fillText(`${metres} m`, 18 + length, y + 4);
}
