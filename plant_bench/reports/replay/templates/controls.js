// Buttons, keys and pointers.

const byId = (id) => document.getElementById(id);
const ZOOM = 1.3; // a press of a button

// What the buttons act on: the player of what is open now.
let player = null;

function connectControls() {
  const press = (id, act) => byId(id).addEventListener("click", () => player && act());
  press("play", () => player.play(!player.playing));
  press("back", () => stepBy(-1));
  press("forward", () => stepBy(1));
  press("previous", () => player.jump(-1));
  press("next", () => player.jump(1));
  press("follow", () => player.follow(!player.following));
  press("in", () => player.zoom(ZOOM));
  press("out", () => player.zoom(1 / ZOOM));
  byId("speed").addEventListener("change", (event) => player?.setSpeed(Number(event.target.value)));
  byId("time").addEventListener("input", (event) => player?.seek(Number(event.target.value)));
  byId("compare").addEventListener("change", (event) => compareWith(event.target.value));
  byId("skip").addEventListener("click", (event) => {
    event.preventDefault(); // the address says what is open
    byId("controls").focus();
  });
  document.addEventListener("keydown", onKey);
  document.addEventListener("themechange", () => {
    player?.recolour();
    showLegend(byId("legend"), paletteNow());
  });
  connectHelp();
  connectChart();
}

function stepBy(frames) {
  player.play(false);
  player.seek(player.seconds + frames * player.episodes[0].facts.step);
}

function connectHelp() {
  const help = byId("help");
  byId("help-open").addEventListener("click", () => help.showModal());
  byId("help-close").addEventListener("click", () => help.close());
  showLegend(byId("legend"), paletteNow());
}

const KEYS = {
  " ": () => player.play(!player.playing),
  ArrowLeft: (event) => (event.shiftKey ? player.seek(player.seconds - 5) : stepBy(-1)),
  ArrowRight: (event) => (event.shiftKey ? player.seek(player.seconds + 5) : stepBy(1)),
  "[": () => player.changeSpeed(-1),
  "]": () => player.changeSpeed(1),
  n: () => player.jump(1),
  p: () => player.jump(-1),
  f: () => player.follow(!player.following),
  "+": () => player.zoom(ZOOM),
  "=": () => player.zoom(ZOOM),
  "-": () => player.zoom(1 / ZOOM),
  Home: () => player.seek(0),
  End: () => player.seek(player.duration),
  "?": () => byId("help").showModal(),
};

function onKey(event) {
  if (!player || event.ctrlKey || event.metaKey || event.altKey || byId("help").open) return;
  const at = event.target;
  // Just after the help has closed its button still has the focus.
  const pressed = at.matches("button, select, a, summary") && !byId("help").contains(at);
  const typed = event.key === " " && pressed;
  const chosen = at.matches("select") && event.key !== "?";
  if (typed || chosen || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key](event);
}

function showControls(now) {
  byId("play").textContent = now.playing ? "Pause" : "Play";
  byId("clock").textContent = `${clockTime(now.seconds)} / ${clockTime(now.duration)}`;
  byId("follow").setAttribute("aria-pressed", String(now.following));
  byId("speed").value = String(now.speed);
  const slider = byId("time");
  slider.max = now.duration.toFixed(1);
  slider.value = now.seconds.toFixed(1);
  slider.setAttribute("aria-valuetext", `${spokenTime(now.seconds)} of ${spokenTime(now.duration)}`);
}

function connectChart() {
  const chart = byId("chart");
  const timeAt = (event) => {
    const box = chart.getBoundingClientRect();
    return chartTime(event.clientX - box.left, box.width, player.episodes, player.duration);
  };
  chart.addEventListener("pointerdown", (event) => {
    if (!player) return;
    const { time, mark } = timeAt(event);
    if (mark) player.goTo(mark);
    else player.seek(time);
    chart.setPointerCapture(event.pointerId);
  });
  chart.addEventListener("pointermove", (event) => {
    if (!player) return;
    const { time, mark } = timeAt(event);
    if (event.buttons) player.seek(time);
    else chart.title = mark ? `${clockTime(mark.time)} ${mark.name}: ${mark.detail}` : "";
  });
}

// Dragging moves the view; the wheel or two fingers zoom.
function connectStage(canvas) {
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before || !player) return;
    const apart = spread(fingers);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 2 && apart > 0) player.zoom(spread(fingers) / apart);
    else player.pan(event.clientX - before[0], event.clientY - before[1]);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    player?.zoom(Math.exp(-event.deltaY / 500));
  }, { passive: false });
}

function spread(fingers) {
  const [one, other] = [...fingers.values()];
  return other ? Math.hypot(one[0] - other[0], one[1] - other[1]) : 0;
}
