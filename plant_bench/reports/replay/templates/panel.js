// What stands beside a scene, as text: how things are now, and what happens when.

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function stageFor(episode) {
  const { facts } = episode;
  const canvas = element("canvas", { role: "img" });
  canvas.setAttribute("aria-label", `${facts.title} on ${facts.route}, from above`);
  const score = element("span", { class: "score" }, `DS ${facts.result.drivingScore.toFixed(1)}`);
  const status = element("span", { class: facts.result.status === "Completed" ? "chip good" : "chip bad" }, facts.result.status);
  const title = element("strong", { class: "name" }, facts.title);
  title.title = facts.title;
  const figure = element("figure", { class: "stage" }, element("figcaption", {}, title, score, status), canvas);
  return { figure, canvas };
}

function panelFor(episode, jump) {
  const now = element("dl", { class: "now" });
  const rows = new Map();
  for (const name of ["Speed", "Acceleration", "Progress", ...(episode.causes ? ["Reason"] : []), ...(episode.attention.ticks.length ? ["Attends to"] : []), ...(episode.expert ? ["Expert"] : [])]) {
    const value = element("dd");
    rows.set(name, value);
    now.append(element("dt", {}, name), value);
  }
  const log = element("ol", { class: "log" });
  const entries = logEntries(episode).map((entry) => {
    const button = element("button", { type: "button", class: entry.infraction ? "event infraction" : "event" });
    button.append(element("span", { class: "sign", "aria-hidden": "true" }, entry.infraction ? "✕" : "◆"));
    button.append(element("span", { class: "when" }, clockTime(entry.time)));
    button.append(element("span", { class: "what" }, element("b", {}, entry.name), element("span", { class: "small" }, entry.detail)));
    if (entry.title) button.title = entry.title;
    button.addEventListener("click", () => jump(entry));
    log.append(element("li", {}, button));
    return { ...entry, button };
  });
  const node = element("section", { class: "panel" }, element("h2", {}, short(episode.facts.title)), now);
  for (const note of notesOf(episode)) node.append(element("p", { class: "note small" }, note));
  const count = episode.facts.infractions.length;
  const reached = episode.facts.hazards.filter((item) => item.phase !== "dormant").length;
  const left = episode.facts.hazards.length - reached;
  const label = `${count} ${count === 1 ? "infraction" : "infractions"}, ${reached} hazards${left ? `, ${left} more not reached` : ""}`;
  node.append(element("h3", {}, label), log);
  return { node, update: (seconds) => updatePanel(episode, rows, entries, seconds) };
}

function logEntries(episode) {
  const idle = episode.facts.hazards.filter((item) => item.phase === "void");
  const more = idle.map((item) => ({ time: item.time, infraction: false, name: hazardName(item), detail: hazardDetail(item), title: item.sentence }));
  return [...episode.marks, ...more].sort((one, other) => one.time - other.time);
}

function notesOf(episode) {
  const { facts, town } = episode;
  const notes = [];
  if (facts.result.reason) notes.push(`It said: ${facts.result.reason}`);
  if (facts.attentionNote) notes.push(`No attention is shown. ${facts.attentionNote}`);
  if (facts.expertNote) notes.push(`The expert is not shown all the time. ${facts.expertNote}`);
  if (town.checksum !== facts.townChecksum) notes.push("The town has changed since: what lies under the scene may be wrong.");
  return notes;
}

function updatePanel(episode, rows, entries, seconds) {
  const frame = frameAt(episode, seconds);
  const ego = egoAt(episode, frame);
  const say = (name, text) => {
    const row = rows.get(name);
    if (row && row.textContent !== text) row.textContent = text;
  };
  say("Speed", `${(3.6 * ego.speed).toFixed(0)} of ${(3.6 * limitAt(episode, frame)).toFixed(0)} km/h`);
  say("Acceleration", `${ego.acceleration.toFixed(1).replace("-", "−")} m/s²`);
  const along = between(episode.progress, 0, episode.frames - 1, frame);
  say("Progress", `${along.toFixed(0)} of ${episode.facts.result.length.toFixed(0)} m`);
  const reason = reasonAt(episode, frame);
  const whom = reason && reason.actor >= 0 ? `: ${kindOf(episode, reason.actor)} ${reason.actor}` : "";
  say("Reason", reason ? `${CAUSES[reason.cause] ?? reason.cause}${whom}` : "none told");
  const top = attentionAt(episode, seconds)[0];
  say("Attends to", top ? `${kindOf(episode, top.actor)} ${top.actor}` : "nobody");
  const expected = expertAt(episode, seconds);
  say("Expert", expected === null ? "not known" : expected < 0 ? "would brake for nobody" : `would brake for ${kindOf(episode, expected)} ${expected}`);
  const current = entries.findLast((entry) => entry.time <= seconds + 0.05);
  if (current && !current.button.hasAttribute("aria-current")) bringIntoView(current.button);
  for (const entry of entries) {
    if (entry === current) entry.button.setAttribute("aria-current", "true");
    else entry.button.removeAttribute("aria-current");
  }
}

// Scrolls the log alone, never the page.
function bringIntoView(button) {
  const log = button.closest(".log");
  const top = button.parentElement.offsetTop;
  if (top < log.scrollTop || top + button.offsetHeight > log.scrollTop + log.clientHeight) {
    log.scrollTop = top - log.clientHeight / 2;
  }
}

const LEGEND = [
  ["Ego, with its plan", (context, colours) => {
    drawPlan(context, [[2, 0], [5, 0], [8, 0]], { x: -4, y: 0 }, { scale: 5 }, colours);
    drawEgo(context, { x: -5, y: 0, yaw: 0 }, [4.9, 2.13], 5, colours);
  }],
  ...["car", "van", "truck", "bus", "motorcycle", "bicycle", "pedestrian", "static"].map((kind) => [
    kind === "static" ? "object" : kind,
    (context, colours) => {
      const [length, width] = { car: [4.6, 1.9], van: [5.4, 2.1], truck: [9, 2.5], bus: [12, 2.5], motorcycle: [2.2, 0.9], bicycle: [1.8, 0.7], pedestrian: [0.9, 0.9], static: [1.5, 1.5] }[kind];
      const enlarged = length < 3 ? 3 : 1;
      context.scale(enlarged, enlarged);
      drawActor(context, kind, { x: 0, y: 0, yaw: 0, length, width }, colours.actor, 5 * enlarged, colours);
    },
  ]),
  ["The redder, the more relevant to the planner; red box: top relevance", (context, colours) => legendBox(context, colours, 1, "relevance")],
  ["Blue box: whom the expert would brake for (in replays made with --expert)", (context, colours) => legendBox(context, colours, 0, "expert")],
  ["White dashes: whom the planner brakes for (its own reason)", (context, colours) => legendBox(context, colours, 0, "ownReason")],
  ["Route", (context, colours) => {
    context.strokeStyle = colours.route;
    context.lineWidth = 0.9;
    context.beginPath();
    context.moveTo(-9, 0);
    context.lineTo(9, 0);
    context.stroke();
  }],
];

function legendBox(context, colours, share, meaning) {
  const actor = { x: 0, y: 0, yaw: 0, length: 4.6, width: 1.9 };
  drawActor(context, "car", actor, mixed(colours.actor, colours.relevance, share), 5, colours);
  drawBox(context, actor, meaning, 5, colours);
}

function showLegend(list, colours) {
  const ratio = window.devicePixelRatio || 1;
  const items = LEGEND.map(([name, draw]) => {
    const canvas = element("canvas", { width: 108 * ratio, height: 40 * ratio, "aria-hidden": "true" });
    const context = canvas.getContext("2d");
    context.fillStyle = colours.road;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.setTransform(5 * ratio, 0, 0, -5 * ratio, 54 * ratio, 20 * ratio);
    draw(context, colours);
    return element("li", {}, canvas, element("span", {}, name));
  });
  const signs = [["◆", "Hazard; its letter says which kind", "hazard"], ["✕", "Infraction", "infraction"]];
  for (const [sign, name, kind] of signs) items.push(element("li", {}, element("span", { class: `legend-sign ${kind}`, "aria-hidden": "true" }, sign), element("span", {}, name)));
  list.replaceChildren(...items);
}
