// One scene from above: north up, metres, the town below, marks on top.

const RECENT = 2.5; // s for which an infraction stands out

// What of the world a stage shows: middle, pixels a metre, size in pixels.
function seenBy(view) {
  const across = view.width / 2 / view.scale;
  const up = view.height / 2 / view.scale;
  return [view.x - across, view.y - up, view.x + across, view.y + up];
}

const onScreen = (view, x, y) => [view.width / 2 + (x - view.x) * view.scale, view.height / 2 - (y - view.y) * view.scale];

function drawScene(context, episode, seconds, view, colours) {
  const frame = frameAt(episode, seconds);
  const moment = {
    seconds,
    frame,
    ego: egoAt(episode, frame),
    actors: actorsAt(episode, frame),
    attention: attentionAt(episode, seconds),
    ownReason: episode.facts.expertDrove ? null : reasonAt(episode, frame),
    expert: expertAt(episode, seconds),
  };
  const ratio = view.ratio;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, view.width * ratio, view.height * ratio);
  inWorld(context, view);
  drawTown(context, episode.town, seenBy(view), colours);
  drawRoute(context, episode, view, colours);
  inPixels(context, view);
  drawHazards(context, episode, view, colours);
  inWorld(context, view);
  drawAttentionLines(context, moment, view, colours);
  drawActors(context, episode, moment, view, colours);
  drawEgo(context, moment.ego, episode.facts.egoExtent, view.scale, colours);
  drawPlan(context, planAt(episode, seconds), moment.ego, view, colours);
  drawBoxes(context, moment, view, colours);
  inPixels(context, view);
  drawLights(context, lightsAt(episode, frame), view, colours);
  drawInfractions(context, episode, seconds, view, colours);
  drawScale(context, view, colours);
}

function inPixels(context, { ratio }) {
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
}

function inWorld(context, view) {
  const k = view.scale * view.ratio;
  const [x, y] = onScreen(view, 0, 0);
  context.setTransform(k, 0, 0, -k, x * view.ratio, y * view.ratio);
}

function drawRoute(context, episode, view, colours) {
  context.save();
  context.globalAlpha = 0.55;
  context.strokeStyle = colours.route;
  context.lineWidth = Math.max(0.9, 2 / view.scale);
  context.lineCap = context.lineJoin = "round";
  context.stroke(episode.routePath);
  const { x, y } = episode.route;
  context.globalAlpha = 1;
  context.beginPath();
  context.arc(x.at(-1), y.at(-1), Math.max(1.6, 5 / view.scale), 0, 2 * Math.PI);
  context.lineWidth = Math.max(0.5, 2 / view.scale);
  context.stroke();
  context.restore();
}

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

function drawActors(context, episode, moment, view, colours) {
  const shares = new Map(moment.attention.map(({ actor, share }) => [actor, share]));
  for (const actor of moment.actors) {
    const fill = mixed(colours.actor, colours.relevance, shares.get(actor.id) ?? 0);
    drawActor(context, episode.facts.kinds[actor.kind], actor, fill, view.scale, colours);
  }
}

function drawPlan(context, points, ego, view, colours) {
  if (!points.length) return;
  context.save();
  context.strokeStyle = colours.plan;
  context.lineWidth = 2.2 / view.scale;
  context.beginPath();
  context.moveTo(ego.x, ego.y);
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
  context.fillStyle = colours.plan;
  context.strokeStyle = colours.outline;
  context.lineWidth = 1 / view.scale;
  for (const [x, y] of points) {
    context.beginPath();
    context.arc(x, y, 4 / view.scale, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }
  context.restore();
}

function drawBoxes(context, moment, view, colours) {
  const top = moment.attention[0];
  for (const actor of moment.actors) {
    if (top && actor.id === top.actor) drawBox(context, actor, "relevance", view.scale, colours);
    if (actor.id === moment.expert) drawBox(context, actor, "expert", view.scale, colours);
    if (actor.id === moment.ownReason?.actor) drawBox(context, actor, "ownReason", view.scale, colours);
  }
}

// A head with three lamps: which one is lit tells the colour, too.
function drawLights(context, lights, view, colours) {
  const lamps = ["red", "yellow", "green"];
  for (const { place, state } of lights) {
    const lit = [null, "green", "yellow", "red"][state];
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
    const head = onScreen(view, x + Math.sin(heading) * (half + 2), y - Math.cos(heading) * (half + 2));
    context.fillStyle = colours.outline;
    context.beginPath();
    context.roundRect(head[0] - 7, head[1] - 18, 14, 36, 4);
    context.fill();
    context.strokeStyle = colours.paint;
    context.lineWidth = 1;
    context.stroke();
    lamps.forEach((lamp, row) => {
      context.fillStyle = lamp === lit ? colours[lamp] : colours.lampOff;
      context.beginPath();
      context.arc(head[0], head[1] - 11 + 11 * row, 4.4, 0, 2 * Math.PI);
      context.fill();
    });
  }
}

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

function drawInfractions(context, episode, seconds, view, colours) {
  for (const item of episode.facts.infractions) {
    if (item.kind === "outside_lanes" || item.time > seconds + 1e-6) continue;
    const [x, y] = onScreen(view, item.x, item.y);
    drawCross(context, x, y, seconds - item.time < RECENT, colours);
  }
}

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

// A cross in a disc; while it is recent beside a ring, so that the ring leaves free what happened.
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

function drawScale(context, view, colours) {
  const metres = [5, 10, 20, 50, 100, 200].find((length) => length * view.scale > 60) ?? 500;
  const length = metres * view.scale;
  const y = view.height - 14;
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.lineWidth = 5;
  for (const [colour, width] of [[colours.labelBack, 5], [colours.label, 2]]) {
    context.strokeStyle = colour;
    context.lineWidth = width;
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
