// @ts-check
// The timeline: speed, limit and acceleration, infractions and hazards, and the time shown.

/** @import { Episode } from "./episode.js" */
/** @import { Mark } from "./marks.js" */
/** @import { Colours } from "./palette.js" */
import { limitAt } from "./episode.js";
import { truncatedTitle } from "./labels.js";

// px
const LEFT = 40;
const RIGHT = 12;
const TOP = 22;
const ROW = 104;
const ROW_GAP = 24;
const TITLE = 16; // of a row, where there are several
const ACCELERATION_BAND = 34; // at the bottom of a row
const MARK_REACH = 7; // from the pointer to a mark that is pointed at
const MAX_POINTS = 1500; // of a curve
const MAX_ACCELERATION = 6; // m/s² at the edge of the band

/** @typedef {CanvasRenderingContext2D} Context */
/** @typedef {{width: number, height: number, ratio: number}} Size px, and device pixels a px */
/** @typedef {(seconds: number) => number} TimeScale px of a time */
/** @typedef {{x: TimeScale, top: number, width: number, maxSpeed: number}} RowFrame */

/** @param {Episode[]} episodes */
export const timelineHeight = (episodes) => rowTop(episodes, episodes.length) - ROW_GAP + 6;

/**
 * @param {Episode[]} episodes
 * @param {number} row
 */
function rowTop(episodes, row) {
  const title = episodes.length > 1 ? TITLE : 0;
  return TOP + title + row * (ROW + ROW_GAP + title);
}

/**
 * @param {number} width
 * @param {number} duration s
 * @returns {TimeScale}
 */
const timeScale = (width, duration) => (seconds) =>
  LEFT + (seconds / duration) * (width - LEFT - RIGHT);

/**
 * Draw everything but the cursor: it changes only with the size and the colours.
 * @param {Size} size
 * @param {Episode[]} episodes
 * @param {number} duration s
 * @param {Colours} colours
 */
export function makeTimeline(size, episodes, duration, colours) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(size.width * size.ratio));
  canvas.height = Math.max(1, Math.round(size.height * size.ratio));
  const context = contextOf(canvas);
  context.scale(size.ratio, size.ratio);
  const limits = episodes.flatMap((episode) => episode.facts.limits.map(([, limit]) => limit));
  const maxSpeed = Math.max(...limits) * 1.15;
  const x = timeScale(size.width, duration);
  episodes.forEach((episode, row) => {
    const frame = { x, top: rowTop(episodes, row), width: size.width, maxSpeed };
    const title = episodes.length > 1 ? truncatedTitle(episode.facts.title) : "";
    drawRow(context, episode, frame, title, colours);
  });
  return canvas;
}

/**
 * Return what draws on a canvas.
 * @param {HTMLCanvasElement} canvas
 */
export function contextOf(canvas) {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("This browser does not support canvas drawing.");
  return context;
}

/**
 * Draw the timeline with its cursor.
 * @param {Context} context
 * @param {Size} size
 * @param {HTMLCanvasElement} timeline of `makeTimeline`
 * @param {number} seconds
 * @param {number} duration s
 * @param {Colours} colours
 */
export function drawTimeline(context, size, timeline, seconds, duration, colours) {
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, timeline.width, timeline.height);
  context.drawImage(timeline, 0, 0);
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  const x = timeScale(size.width, duration)(seconds);
  context.strokeStyle = colours.label;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x, 4);
  context.lineTo(x, size.height - 2);
  context.stroke();
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {RowFrame} frame
 * @param {string} title
 * @param {Colours} colours
 */
function drawRow(context, episode, { x, top, width, maxSpeed }, title, colours) {
  const bottom = top + ROW;
  const speedBottom = bottom - ACCELERATION_BAND - 8;
  const bandMiddle = bottom - ACCELERATION_BAND / 2;
  const speedY = (/** @type {number} */ speed) =>
    speedBottom - (Math.max(speed, 0) / maxSpeed) * (speedBottom - top);
  const accelerationY = (/** @type {number} */ acceleration) =>
    bandMiddle -
    (clamped(acceleration, MAX_ACCELERATION) / MAX_ACCELERATION) * (ACCELERATION_BAND / 2);
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.fillStyle = colours.chartText;
  context.textAlign = "right";
  const step = maxSpeed > 25 ? 50 : 20;
  for (let kmh = 0; kmh / 3.6 < maxSpeed; kmh += step) {
    context.fillText(String(kmh), LEFT - 6, speedY(kmh / 3.6));
    drawGridLine(context, width, speedY(kmh / 3.6), colours);
  }
  drawGridLine(context, width, bandMiddle, colours);
  context.fillText("m/s²", LEFT - 6, bandMiddle);
  context.fillText("km/h", LEFT - 6, top - 10);
  context.textAlign = "left";
  if (title) context.fillText(title, LEFT, top - 12 - TITLE);
  /**
   * @param {(frame: number) => number} y
   * @param {string} colour
   * @param {number} lineWidth
   * @param {number[]} dashes
   */
  const draw = (y, colour, lineWidth, dashes) => {
    context.strokeStyle = colour;
    context.lineWidth = lineWidth;
    context.setLineDash(dashes);
    drawCurve(context, episode, x, y);
    context.setLineDash([]);
  };
  draw((frame) => accelerationY(episode.ego.acceleration[frame]), colours.acceleration, 1, []);
  draw((frame) => speedY(limitAt(episode, frame)), colours.limit, 1.2, [4, 3]);
  draw((frame) => speedY(episode.ego.speed[frame]), colours.speed, 2, []);
  for (const mark of episode.marks) drawMark(context, x(mark.time), top, bottom, mark, colours);
}

/**
 * @param {Context} context
 * @param {number} width
 * @param {number} y
 * @param {Colours} colours
 */
function drawGridLine(context, width, y, colours) {
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(LEFT, y);
  context.lineTo(width - RIGHT, y);
  context.stroke();
}

/**
 * @param {Context} context
 * @param {Episode} episode
 * @param {TimeScale} x
 * @param {(frame: number) => number} y
 */
function drawCurve(context, episode, x, y) {
  const step = Math.max(1, Math.floor(episode.frames / MAX_POINTS));
  context.beginPath();
  for (let frame = 0; frame < episode.frames; frame += step) {
    context.lineTo(x(frame * episode.facts.step), y(frame));
  }
  context.stroke();
}

/**
 * A cross for an infraction, with a line down; a diamond for a hazard.
 * @param {Context} context
 * @param {number} x
 * @param {number} top
 * @param {number} bottom
 * @param {Mark} mark
 * @param {Colours} colours
 */
function drawMark(context, x, top, bottom, mark, colours) {
  const y = top - 12;
  context.strokeStyle = context.fillStyle = mark.infraction ? colours.infraction : colours.hazard;
  context.beginPath();
  if (mark.infraction) {
    context.lineWidth = 1.5;
    context.moveTo(x, top - 5);
    context.lineTo(x, bottom);
    context.stroke();
    context.beginPath();
    context.lineWidth = 2.6;
    for (const side of [-1, 1]) {
      context.moveTo(x - 5, y - 5 * side);
      context.lineTo(x + 5, y + 5 * side);
    }
    context.stroke();
  } else {
    context.moveTo(x, y - 5.5);
    context.lineTo(x + 5.5, y);
    context.lineTo(x, y + 5.5);
    context.lineTo(x - 5.5, y);
    context.fill();
  }
}

/**
 * @param {number} value
 * @param {number} limit
 */
const clamped = (value, limit) => Math.min(Math.max(value, -limit), limit);

/**
 * Return the time at a place of the timeline, and the mark there, if there is one.
 * @param {number} x px from the timeline's left edge
 * @param {number} width px of the timeline
 * @param {Episode[]} episodes
 * @param {number} duration s
 * @returns {{time: number, mark: Mark | null}}
 */
export function timelineAt(x, width, episodes, duration) {
  const scale = (width - LEFT - RIGHT) / duration;
  const time = clamped((x - LEFT) / scale, duration);
  const distance = (/** @type {Mark} */ mark) => Math.abs(mark.time - time);
  const near = episodes
    .flatMap((episode) => episode.marks)
    .filter((mark) => distance(mark) * scale < MARK_REACH)
    .sort(
      (one, other) =>
        Number(other.infraction) - Number(one.infraction) || distance(one) - distance(other),
    );
  return { time: Math.max(time, 0), mark: near[0] ?? null };
}
