// The clock and what shows it; one clock for all episodes of the page.

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const SCALES = [1, 40]; // px a metre, least and most
const REACH = 105; // m across a stage at first
const LEAST_FIRST = 6; // px a metre at first

class Player {
  constructor(episodes, stages, panels) {
    this.episodes = episodes;
    this.stages = stages;
    this.panels = panels;
    this.duration = Math.max(...episodes.map((episode) => episode.duration), 0.1);
    this.seconds = 0;
    this.playing = false;
    this.speed = 1;
    this.following = true;
    this.scale = 8;
    this.listeners = [];
    this.told = 0;
    this.due = 0;
    this.marks = episodes.flatMap((episode) => episode.marks).sort((one, other) => one.time - other.time);
    this.chart = document.getElementById("chart");
  }

  start() {
    this.colours = paletteNow();
    this.observer = new ResizeObserver(() => this.measure());
    for (const stage of this.stages) this.observer.observe(stage.canvas);
    this.observer.observe(this.chart);
    this.chart.style.height = `${chartHeight(this.episodes)}px`;
    this.scale = clampedScale(this.stages[0].canvas.clientWidth / REACH);
    this.scale = Math.max(this.scale, LEAST_FIRST);
    this.measure();
  }

  stop() {
    this.playing = false;
    this.observer?.disconnect();
    cancelAnimationFrame(this.due);
  }

  measure() {
    for (const canvas of [...this.stages.map((stage) => stage.canvas), this.chart]) {
      const ratio = window.devicePixelRatio || 1;
      canvas.width = Math.round(canvas.clientWidth * ratio);
      canvas.height = Math.round(canvas.clientHeight * ratio);
    }
    this.drawnChart = null;
    this.show();
  }

  recolour() {
    this.colours = paletteNow();
    this.drawnChart = null;
    this.show();
  }

  play(wanted) {
    this.playing = wanted;
    if (wanted && this.seconds >= this.duration) this.seconds = 0;
    this.before = null;
    this.tell();
    this.show();
  }

  seek(seconds) {
    this.seconds = Math.min(Math.max(seconds, 0), this.duration);
    this.announced = this.seconds;
    this.tell();
    this.show();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.tell();
  }

  changeSpeed(by) {
    const place = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.min(Math.max(place, 0), SPEEDS.length - 1)]);
  }

  follow(wanted) {
    this.following = wanted;
    this.tell();
    this.show();
  }

  zoom(factor) {
    this.scale = clampedScale(this.scale * factor);
    this.show();
  }

  pan(across, up) {
    this.following = false;
    for (const stage of this.stages) {
      stage.x -= across / this.scale;
      stage.y += up / this.scale;
    }
    this.tell();
    this.show();
  }

  // Goes to the infraction after or before now.
  jump(direction) {
    const marks = this.marks.filter((mark) => mark.infraction);
    const ahead = (mark) => mark.time > this.seconds + 0.051;
    const behind = (mark) => mark.time < this.seconds - 0.051;
    const mark = direction > 0 ? marks.find(ahead) : marks.findLast(behind);
    if (mark) this.goTo(mark);
    else say(direction > 0 ? "No infraction after this." : "No infraction before this.");
  }

  goTo(mark) {
    this.seek(mark.time);
    say(`${mark.name}, ${spokenTime(mark.time)}. ${mark.detail}`);
  }

  show() {
    if (this.due) return;
    this.due = requestAnimationFrame((now) => {
      this.due = 0;
      this.step(now);
    });
  }

  step(now) {
    if (this.playing) {
      const past = this.before === null ? 0 : Math.min((now - this.before) / 1000, 0.25);
      this.before = now;
      this.advance(past * this.speed);
    }
    this.draw();
    if (now - this.told > 150 || !this.playing) {
      this.told = now;
      for (const panel of this.panels) panel.update(this.seconds);
      this.tell();
    }
    if (this.playing) this.show();
  }

  advance(seconds) {
    const from = this.seconds;
    this.seconds = Math.min(from + seconds, this.duration);
    const passed = this.marks.filter((mark) => mark.infraction && mark.time > from && mark.time <= this.seconds);
    if (passed.length) say(`${passed.at(-1).name}, ${spokenTime(passed.at(-1).time)}`);
    if (this.seconds >= this.duration) {
      this.playing = false;
      say("The end.");
    }
  }

  draw() {
    this.stages.forEach((stage, place) => {
      const episode = this.episodes[place];
      if (this.following) {
        const ego = egoAt(episode, frameAt(episode, this.seconds));
        stage.x = ego.x;
        stage.y = ego.y;
      }
      const { canvas } = stage;
      const ratio = window.devicePixelRatio || 1;
      const view = { x: stage.x, y: stage.y, scale: this.scale, width: canvas.width / ratio, height: canvas.height / ratio, ratio };
      drawScene(canvas.getContext("2d"), episode, this.seconds, view, this.colours);
    });
    this.drawChart();
  }

  drawChart() {
    const ratio = window.devicePixelRatio || 1;
    const size = { width: this.chart.width / ratio, height: this.chart.height / ratio, ratio };
    this.drawnChart ??= makeChart(size, this.episodes, this.duration, this.colours);
    drawChart(this.chart.getContext("2d"), size, this.drawnChart, this.seconds, this.duration, this.colours);
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }
}

const clampedScale = (scale) => Math.min(Math.max(scale, SCALES[0]), SCALES[1]);

const PALETTE = JSON.parse(document.getElementById("palette").textContent);
const paletteNow = () => PALETTE[document.documentElement.dataset.theme === "dark" ? "dark" : "light"];

function say(text) {
  document.getElementById("live").textContent = text;
}
