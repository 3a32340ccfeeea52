// @ts-check
// Buttons, keys and pointers.

/** @import { Player } from "./player.js" */
import { byId } from "../shared/dom.js";
import { formatSpokenTime, formatTime } from "./labels.js";
import { showLegend } from "./legend.js";
import { currentColours } from "./palette.js";
import { timelineAt } from "./timeline.js";

const ZOOM_STEP = 1.3;
const LONG_STEP = 5; // s
const WHEEL_ZOOM = 500; // px of wheel movement that zoom by a factor of e

/** @type {Player | null} of the replay that is open */
let player = null;

/**
 * Let the controls act on another player, or on none.
 * @param {Player | null} next
 */
export function setPlayer(next) {
  player?.stop();
  player = next;
}

/** @typedef {(player: Player, event: KeyboardEvent) => void} KeyAction */

/** @type {Record<string, (player: Player) => void>} by the button's id */
const BUTTONS = {
  play: (player) => player.setPlaying(!player.playing),
  back: (player) => player.stepBy(-1),
  forward: (player) => player.stepBy(1),
  previous: (player) => player.goToInfraction(-1),
  next: (player) => player.goToInfraction(1),
  follow: (player) => player.setFollowing(!player.following),
  in: (player) => player.zoom(ZOOM_STEP),
  out: (player) => player.zoom(1 / ZOOM_STEP),
};

/** @type {Record<string, KeyAction>} */
const KEYS = {
  " ": BUTTONS.play,
  ArrowLeft: (player, event) => moveByKey(player, event, -1),
  ArrowRight: (player, event) => moveByKey(player, event, 1),
  "[": (player) => player.changeSpeed(-1),
  "]": (player) => player.changeSpeed(1),
  n: BUTTONS.next,
  p: BUTTONS.previous,
  f: BUTTONS.follow,
  "+": BUTTONS.in,
  "=": BUTTONS.in,
  "-": BUTTONS.out,
  Home: (player) => player.seek(0),
  End: (player) => player.seek(player.duration),
  "?": () => byId("help", HTMLDialogElement).showModal(),
};

/**
 * Move by a frame, with shift by seconds.
 * @param {Player} player
 * @param {KeyboardEvent} event
 * @param {1 | -1} direction
 */
function moveByKey(player, event, direction) {
  if (event.shiftKey) player.seek(player.seconds + direction * LONG_STEP);
  else player.stepBy(direction);
}

/** @param {(id: string) => void} onCompare called with the id of an episode, empty for none */
export function connectControls(onCompare) {
  for (const [id, act] of Object.entries(BUTTONS)) {
    byId(id, HTMLButtonElement).addEventListener("click", () => player && act(player));
  }
  const speed = byId("speed", HTMLSelectElement);
  speed.addEventListener("change", () => player?.setSpeed(Number(speed.value)));
  const time = byId("time", HTMLInputElement);
  time.addEventListener("input", () => player?.seek(Number(time.value)));
  const compare = byId("compare", HTMLSelectElement);
  compare.addEventListener("change", () => onCompare(compare.value));
  byId("skip", HTMLAnchorElement).addEventListener("click", (event) => {
    event.preventDefault(); // the address says which replay is open
    byId("controls", HTMLElement).focus();
  });
  document.addEventListener("keydown", onKey);
  document.addEventListener("themechange", () => {
    player?.updateColours();
    showLegend(byId("legend", HTMLElement), currentColours());
  });
  connectHelp();
  connectTimeline();
}

function connectHelp() {
  const help = byId("help", HTMLDialogElement);
  byId("help-open", HTMLButtonElement).addEventListener("click", () => help.showModal());
  byId("help-close", HTMLButtonElement).addEventListener("click", () => help.close());
  showLegend(byId("legend", HTMLElement), currentColours());
}

/** @param {KeyboardEvent} event */
function onKey(event) {
  const help = byId("help", HTMLDialogElement);
  if (!player || event.ctrlKey || event.metaKey || event.altKey || help.open) return;
  const action = KEYS[event.key];
  if (!action || isForFocused(event, help)) return;
  event.preventDefault();
  action(player, event);
}

/**
 * Tell whether a key is for the element that has the focus. Buttons of the help do not count: just
 * after it has been closed, its button still has the focus.
 * @param {KeyboardEvent} event
 * @param {HTMLElement} help
 */
function isForFocused(event, help) {
  const focused = event.target;
  if (!(focused instanceof Element)) return false;
  if (focused.matches("select") && event.key !== "?") return true;
  const isPressed = event.key === " " && focused.matches("button, select, a, summary");
  return isPressed && !help.contains(focused);
}

/**
 * Show the state of a player in the controls.
 * @param {Player} shown
 */
export function showPlayer({ playing, seconds, duration, following, speed }) {
  byId("play", HTMLButtonElement).textContent = playing ? "Pause" : "Play";
  byId("clock", HTMLElement).textContent = `${formatTime(seconds)} / ${formatTime(duration)}`;
  byId("follow", HTMLButtonElement).setAttribute("aria-pressed", String(following));
  byId("speed", HTMLSelectElement).value = String(speed);
  const slider = byId("time", HTMLInputElement);
  slider.max = duration.toFixed(1);
  slider.value = seconds.toFixed(1);
  const spoken = `${formatSpokenTime(seconds)} of ${formatSpokenTime(duration)}`;
  slider.setAttribute("aria-valuetext", spoken);
}

function connectTimeline() {
  const timeline = byId("chart", HTMLCanvasElement);
  /**
   * @param {PointerEvent} event
   * @param {Player} shown
   */
  const pointed = (event, { episodes, duration }) => {
    const box = timeline.getBoundingClientRect();
    return timelineAt(event.clientX - box.left, box.width, episodes, duration);
  };
  timeline.addEventListener("pointerdown", (event) => {
    if (!player) return;
    const { time, mark } = pointed(event, player);
    if (mark) player.goTo(mark);
    else player.seek(time);
    timeline.setPointerCapture(event.pointerId);
  });
  timeline.addEventListener("pointermove", (event) => {
    if (!player) return;
    const { time, mark } = pointed(event, player);
    if (event.buttons) player.seek(time);
    else timeline.title = mark ? `${formatTime(mark.time)} ${mark.name}: ${mark.detail}` : "";
  });
}

/**
 * Let dragging move the view, and the wheel or two fingers zoom.
 * @param {HTMLCanvasElement} canvas
 */
export function connectScene(canvas) {
  /** @type {Map<number, [x: number, y: number]>} */
  const pointers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before || !player) return;
    const distance = pointerDistance(pointers);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (pointers.size === 2 && distance > 0) player.zoom(pointerDistance(pointers) / distance);
    else player.pan(event.clientX - before[0], event.clientY - before[1]);
  });
  for (const name of /** @type {const} */ (["pointerup", "pointercancel"])) {
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      player?.zoom(Math.exp(-event.deltaY / WHEEL_ZOOM));
    },
    { passive: false },
  );
}

/** @param {Map<number, [x: number, y: number]>} pointers */
function pointerDistance(pointers) {
  const [one, other] = [...pointers.values()];
  return other ? Math.hypot(one[0] - other[0], one[1] - other[1]) : 0;
}
