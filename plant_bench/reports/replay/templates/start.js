// Opens what the address names.

let opening = 0;

async function open() {
  const mine = ++opening;
  player?.stop();
  player = null;
  byId("player").hidden = byId("choice").hidden = byId("message").hidden = true;
  const main = document.querySelector("main");
  main.setAttribute("aria-busy", "true");
  try {
    const ids = wantedIds();
    if (ids.length) showMessage("Loading …", false);
    const episodes = await Promise.all(ids.map(loadEpisode));
    const index = ids.length ? null : await load("replays/index.js");
    if (mine !== opening) return;
    if (index) showChoices(index);
    else showEpisodes(episodes);
  } catch (error) {
    if (mine !== opening) return;
    showMessage(error.message, true);
  }
  main.setAttribute("aria-busy", "false");
}

function showMessage(text, bad) {
  const message = byId("message");
  message.textContent = text;
  message.className = bad ? "message bad" : "message";
  message.hidden = false;
}

function showEpisodes(episodes) {
  byId("message").hidden = true;
  byId("player").hidden = false;
  const { facts } = episodes[0];
  const names = episodes.map((episode) => short(episode.facts.title));
  byId("heading").textContent = facts.route;
  byId("about").textContent = `${names.join(" and ")} · repetition ${facts.repetition} · seed ${facts.seed} · ${facts.protocol}`;
  document.title = `Replay: ${names.join(" and ")} on ${facts.route}`;
  const other = episodes.find((episode) => episode.facts.scenario !== facts.scenario);
  if (other) byId("about").textContent += ` · not the same scenario: the right one is ${other.facts.route}, repetition ${other.facts.repetition}`;
  const stages = episodes.map(stageFor);
  const panels = episodes.map((episode) => panelFor(episode, (mark) => player.goTo(mark)));
  byId("stages").replaceChildren(...stages.map((stage) => stage.figure));
  byId("facts").replaceChildren(...panels.map((panel) => panel.node));
  byId("player").classList.toggle("two", episodes.length > 1);
  for (const stage of stages) connectStage(stage.canvas);
  player = new Player(episodes, stages, panels);
  player.listeners.push(showControls);
  player.start();
  player.tell();
  offerComparison(episodes);
}

async function offerComparison(episodes) {
  const { facts } = episodes[0];
  let index;
  try {
    index = await load("replays/index.js");
  } catch {
    return; // one can do without
  }
  byId("leaderboard").hidden = !index.leaderboard;
  const fitting = index.replays.filter((item) => item.scenario === facts.scenario && item.id !== facts.id && ID.test(item.id));
  byId("compare-group").hidden = !fitting.length;
  const options = fitting.map((item) => element("option", { value: item.id }, `${short(item.title)} (DS ${item.drivingScore.toFixed(1)})`));
  const nobody = element("option", { value: "" }, "no other");
  byId("compare").replaceChildren(nobody, ...options);
  byId("compare").value = episodes[1]?.facts.id ?? "";
}

function compareWith(id) {
  const [first] = wantedIds();
  location.hash = id ? `${first}&${id}` : first;
}

function showChoices({ replays: all, leaderboard }) {
  byId("leaderboard").hidden = !leaderboard;
  byId("heading").textContent = "Replays";
  byId("about").textContent = `${all.length} here`;
  const items = all.filter((item) => ID.test(item.id)).map((item) => {
    const link = element("a", { href: `#${item.id}` }, `${short(item.title)}, ${item.route}, repetition ${item.repetition}`);
    const facts = ` DS ${item.drivingScore.toFixed(1)}, ${item.status}, ${item.infractions} infractions`;
    return element("li", {}, link, element("span", { class: "muted small" }, facts));
  });
  byId("choices").replaceChildren(...items);
  byId("choice").hidden = false;
}

connectControls();
window.addEventListener("hashchange", open);
open();
