// @ts-check
// The player: one clock for all episodes of the page, and the drawing of the moment it shows.

/** @import { Episode } from "./episode.js" */
/** @import { Mark } from "./marks.js" */
/** @import { Panel } from "./panel.js" */
import { byId, element } from "../shared/dom.js";
import { egoAt, frameAt } from "./episode.js";
import { formatSpokenTime } from "./labels.js";
import { inOrderOfTime } from "./marks.js";
import { currentColours } from "./palette.js";
import { drawScene } from "./scene.js";
import { contextOf, drawTimeline, makeTimeline, timelineHeight } from "./timeline.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const MIN_SCALE = 1; // px a metre
const MAX_SCALE = 40;
const MIN_FIRST_SCALE = 6; // px a metre when a replay is opened
const FIRST_WIDTH = 105; // m across a scene when a replay is opened
const MAX_STEP = 0.25; // s between two animation frames, however long they took
const PANEL_INTERVAL = 150; // ms between updates of panels while it plays
const SAME_TIME = 0.051; // s

/**
 * A scene's canvas and the place at its centre, m.
 * @typedef {{figure: HTMLElement, canvas: HTMLCanvasElement, x: number, y: number}} Scene
 */

/**
 * @param {Episode} episode
 * @returns {Scene}
 */
export function makeScene({ facts }) {
  const label = `${facts.title} on ${facts.route}, from above`;
  const canvas = element("canvas", { role: "img", "aria-label": label });
  const { drivingScore, status } = facts.result;
  const caption = element(
    "figcaption",
    {},
    element("strong", { class: "name", title: facts.title }, facts.title),
    element("span", { class: "score" }, `DS ${drivingScore.toFixed(1)}`),
    element("span", { class: status === "Completed" ? "chip good" : "chip bad" }, status),
  );
  return { figure: element("figure", { class: "stage" }, caption, canvas), canvas, x: 0, y: 0 };
}

export class Player {
  /**
   * @param {Episode[]} episodes
   * @param {Scene[]} scenes of the episodes
   * @param {Panel[]} panels of the episodes
   * @param {(player: Player) => void} onChange called when what controls show has changed
   */
  constructor(episodes, scenes, panels, onChange) {
    this.episodes = episodes;
    this.scenes = scenes;
    this.panels = panels;
    this.onChange = onChange;
    this.duration = Math.max(...episodes.map((episode) => episode.duration), 0.1);
    this.seconds = 0;
    this.playing = false;
    this.speed = 1;
    this.following = true;
    this.marks = inOrderOfTime(episodes.flatMap((episode) => episode.marks));
    this.timeline = byId("chart", HTMLCanvasElement);
    this.timeline.style.height = `${timelineHeight(episodes)}px`;
    this.colours = currentColours();
    const firstScale = clampedScale(scenes[0].canvas.clientWidth / FIRST_WIDTH);
    this.scale = Math.max(firstScale, MIN_FIRST_SCALE);
    /** @type {number | null} ms of the last animation frame while it plays */
    this.lastFrame = null;
    /** ms of the last update of panels */
    this.lastUpdate = 0;
    /** @type {HTMLCanvasElement | null} */
    this.drawnTimeline = null;
    this.animationFrame = 0;
    this.resizeObserver = new ResizeObserver(() => this.resize());
    for (const canvas of this.canvases()) this.resizeObserver.observe(canvas);
    this.resize();
    this.onChange(this);
  }

  stop() {
    this.playing = false;
    this.resizeObserver.disconnect();
    cancelAnimationFrame(this.animationFrame);
  }

  canvases() {
    return [...this.scenes.map((scene) => scene.canvas), this.timeline];
  }

  resize() {
    for (const canvas of this.canvases()) {
      const ratio = window.devicePixelRatio || 1;
      canvas.width = Math.round(canvas.clientWidth * ratio);
      canvas.height = Math.round(canvas.clientHeight * ratio);
    }
    this.drawnTimeline = null;
    this.scheduleDraw();
  }

  /** Draw with the colours of the current theme. */
  updateColours() {
    this.colours = currentColours();
    this.drawnTimeline = null;
    this.scheduleDraw();
  }

  /** @param {boolean} playing */
  setPlaying(playing) {
    this.playing = playing;
    if (playing && this.seconds >= this.duration) this.seconds = 0;
    this.lastFrame = null;
    this.onChange(this);
    this.scheduleDraw();
  }

  /** @param {number} seconds */
  seek(seconds) {
    this.seconds = Math.min(Math.max(seconds, 0), this.duration);
    this.onChange(this);
    this.scheduleDraw();
  }

  /**
   * Pause, and move by frames.
   * @param {number} frames
   */
  stepBy(frames) {
    this.setPlaying(false);
    this.seek(this.seconds + frames * this.episodes[0].facts.step);
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.speed = speed;
    this.onChange(this);
  }

  /** @param {number} steps in the list of speeds */
  changeSpeed(steps) {
    const place = SPEEDS.indexOf(this.speed) + steps;
    this.setSpeed(SPEEDS[Math.min(Math.max(place, 0), SPEEDS.length - 1)]);
  }

  /** @param {boolean} following whether the view follows the ego */
  setFollowing(following) {
    this.following = following;
    this.onChange(this);
    this.scheduleDraw();
  }

  /** @param {number} factor */
  zoom(factor) {
    this.scale = clampedScale(this.scale * factor);
    this.scheduleDraw();
  }

  /**
   * Move the view.
   * @param {number} right px
   * @param {number} down px
   */
  pan(right, down) {
    this.following = false;
    for (const scene of this.scenes) {
      scene.x -= right / this.scale;
      scene.y += down / this.scale;
    }
    this.onChange(this);
    this.scheduleDraw();
  }

  /**
   * Go to the next infraction, or to the previous one.
   * @param {1 | -1} direction
   */
  goToInfraction(direction) {
    const infractions = this.marks.filter((mark) => mark.infraction);
    const mark =
      direction > 0
        ? infractions.find(({ time }) => time > this.seconds + SAME_TIME)
        : infractions.findLast(({ time }) => time < this.seconds - SAME_TIME);
    if (mark) this.goTo(mark);
    else announce(direction > 0 ? "No infraction after this." : "No infraction before this.");
  }

  /** @param {Mark} mark */
  goTo(mark) {
    this.seek(mark.time);
    announce(`${mark.name}, ${formatSpokenTime(mark.time)}. ${mark.detail}`);
  }

  scheduleDraw() {
    if (this.animationFrame) return;
    this.animationFrame = requestAnimationFrame((now) => {
      this.animationFrame = 0;
      this.drawFrame(now);
    });
  }

  /** @param {number} now ms */
  drawFrame(now) {
    if (this.playing) {
      const elapsed = this.lastFrame === null ? 0 : (now - this.lastFrame) / 1000;
      this.lastFrame = now;
      this.advance(Math.min(elapsed, MAX_STEP) * this.speed);
    }
    this.drawScenes();
    this.drawTimeline();
    if (now - this.lastUpdate > PANEL_INTERVAL || !this.playing) {
      this.lastUpdate = now;
      for (const panel of this.panels) panel.update(this.seconds);
      this.onChange(this);
    }
    if (this.playing) this.scheduleDraw();
  }

  /** @param {number} seconds */
  advance(seconds) {
    const from = this.seconds;
    this.seconds = Math.min(from + seconds, this.duration);
    const passed = this.marks.findLast(
      ({ infraction, time }) => infraction && time > from && time <= this.seconds,
    );
    if (passed) announce(`${passed.name}, ${formatSpokenTime(passed.time)}`);
    if (this.seconds >= this.duration) {
      this.playing = false;
      announce("The end.");
    }
  }

  drawScenes() {
    const ratio = window.devicePixelRatio || 1;
    this.scenes.forEach((scene, place) => {
      const episode = this.episodes[place];
      if (this.following) {
        const ego = egoAt(episode, frameAt(episode, this.seconds));
        scene.x = ego.x;
        scene.y = ego.y;
      }
      const { canvas, x, y } = scene;
      const width = canvas.width / ratio;
      const height = canvas.height / ratio;
      const view = { x, y, scale: this.scale, width, height, ratio };
      drawScene(contextOf(canvas), episode, this.seconds, view, this.colours);
    });
  }

  drawTimeline() {
    const { timeline, duration, colours } = this;
    const ratio = window.devicePixelRatio || 1;
    const size = { width: timeline.width / ratio, height: timeline.height / ratio, ratio };
    this.drawnTimeline ??= makeTimeline(size, this.episodes, duration, colours);
    const context = contextOf(timeline);
    drawTimeline(context, size, this.drawnTimeline, this.seconds, duration, colours);
  }
}

/** @param {number} scale */
const clampedScale = (scale) => Math.min(Math.max(scale, MIN_SCALE), MAX_SCALE);

/**
 * Tell users of screen readers.
 * @param {string} text
 */
function announce(text) {
  byId("live", HTMLElement).textContent = text;
}
