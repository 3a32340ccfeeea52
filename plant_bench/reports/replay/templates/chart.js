// The time line: speed, limit and acceleration, infractions and hazards, and where one is.

const CHART = { left: 40, right: 12, top: 22, row: 104, name: 16, gap: 24, band: 34 }; // px; the band of accelerations is a part of the row
const HARD = 6; // m/s2 at the edge of the band of accelerations

function chartHeight(episodes) {
  return rowTop(episodes, episodes.length) - CHART.gap + 6;
}

function rowTop(episodes, row) {
  const name = episodes.length > 1 ? CHART.name : 0;
  return CHART.top + name + row * (CHART.row + CHART.gap + name);
}

// All but the cursor changes with the size and the colours alone: it is drawn once for each.
function makeChart(size, episodes, duration, colours) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(size.width * size.ratio));
  canvas.height = Math.max(1, Math.round(size.height * size.ratio));
  const context = canvas.getContext("2d");
  context.scale(size.ratio, size.ratio);
  const most = Math.max(...episodes.map((episode) => Math.max(...episode.facts.limits.map(([, limit]) => limit)))) * 1.15;
  const x = chartPlace(size.width, duration);
  episodes.forEach((episode, row) => {
    drawChartRow(context, episode, { x, top: rowTop(episodes, row), width: size.width, most }, colours, episodes.length > 1);
  });
  return canvas;
}

const chartPlace = (width, duration) => (time) => CHART.left + (time / duration) * (width - CHART.left - CHART.right);

function drawChart(context, size, chart, seconds, duration, colours) {
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, chart.width, chart.height);
  context.drawImage(chart, 0, 0);
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  const x = chartPlace(size.width, duration)(seconds);
  context.strokeStyle = colours.label;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x, 4);
  context.lineTo(x, size.height - 2);
  context.stroke();
}

function drawChartRow(context, episode, place, colours, named) {
  const { x, top, width, most } = place;
  const bottom = top + CHART.row;
  const floor = bottom - CHART.band - 8;
  const speedY = (speed) => floor - (Math.max(speed, 0) / most) * (floor - top);
  const middle = bottom - CHART.band / 2;
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.fillStyle = colours.chartText;
  context.textAlign = "right";
  const step = most > 25 ? 50 : 20;
  for (let kmh = 0; kmh / 3.6 < most; kmh += step) {
    context.fillText(String(kmh), CHART.left - 6, speedY(kmh / 3.6));
    level(context, width, speedY(kmh / 3.6), colours);
  }
  level(context, width, middle, colours);
  context.fillText("m/s²", CHART.left - 6, middle);
  context.fillText("km/h", CHART.left - 6, top - 10);
  context.textAlign = "left";
  if (named) context.fillText(short(episode.facts.title), CHART.left, top - 12 - CHART.name);
  const frames = episode.frames;
  const line = (value, colour, thickness, dashes) => plotLine(context, episode, { x, value, colour, thickness, dashes, frames });
  line((frame) => middle - (clamped(episode.ego.acceleration[frame], HARD) / HARD) * (CHART.band / 2), colours.acceleration, 1, []);
  line((frame) => speedY(limitAt(episode, frame)), colours.limit, 1.2, [4, 3]);
  line((frame) => speedY(episode.ego.speed[frame]), colours.speed, 2, []);
  for (const mark of episode.marks) drawChartMark(context, x(mark.time), top, bottom, mark, colours);
}

function level(context, width, y, colours) {
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(CHART.left, y);
  context.lineTo(width - CHART.right, y);
  context.stroke();
}

const clamped = (value, most) => Math.min(Math.max(value, -most), most);
const short = (text) => (text.length > 40 ? `${text.slice(0, 39)}…` : text);

function plotLine(context, episode, { x, value, colour, thickness, dashes, frames }) {
  context.strokeStyle = colour;
  context.lineWidth = thickness;
  context.setLineDash(dashes);
  context.beginPath();
  const step = Math.max(1, Math.floor(frames / 1500));
  for (let frame = 0; frame < frames; frame += step) context.lineTo(x(frame * episode.facts.step), value(frame));
  context.stroke();
  context.setLineDash([]);
}

function drawChartMark(context, x, top, bottom, mark, colours) {
  const y = top - 12;
  context.strokeStyle = context.fillStyle = mark.infraction ? colours.infraction : colours.hazard;
  context.lineWidth = mark.infraction ? 1.5 : 1;
  context.globalAlpha = mark.infraction ? 1 : 0.8;
  context.beginPath();
  context.moveTo(x, top - 5);
  context.lineTo(x, bottom);
  if (mark.infraction) context.stroke();
  context.globalAlpha = 1;
  context.beginPath();
  if (mark.infraction) {
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

// Whether a hazard has a time: others were never reached, or not played.
function begun(hazard) {
  return hazard.phase !== "void" && hazard.phase !== "dormant";
}

// What lies on the time line, in order of time.
function marksOf({ infractions, hazards }) {
  const marks = infractions.map((item) => ({ time: item.time, infraction: true, name: infractionName(item), detail: infractionDetail(item) }));
  for (const item of hazards) {
    if (begun(item)) marks.push({ time: item.time, infraction: false, name: hazardName(item), detail: hazardDetail(item), title: item.sentence });
  }
  return marks.sort((one, other) => one.time - other.time);
}

// The time under a place of the chart; near a mark that of the mark.
function chartTime(place, width, episodes, duration) {
  const scale = (width - CHART.left - CHART.right) / duration;
  const time = clamped((place - CHART.left) / scale, duration);
  const near = episodes.flatMap((episode) => episode.marks).filter((mark) => Math.abs(mark.time - time) * scale < 7);
  near.sort((one, other) => other.infraction - one.infraction || Math.abs(one.time - time) - Math.abs(other.time - time));
  return { time: Math.max(time, 0), mark: near[0] ?? null };
}
