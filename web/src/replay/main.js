// @ts-check
// Entry of the replay page's script: opens the replays that the address names, or lists all.

/** @import { Episode } from "./episode.js" */
/** @import { EpisodePayload, ReplayIndex } from "./payload.js" */
import { byId, element } from "../shared/dom.js";
import { connectControls, connectScene, setPlayer, showPlayer } from "./controls.js";
import { truncatedTitle } from "./labels.js";
import { idsInAddress, installLoader, isReplayId, loadEpisode, loadIndex } from "./loader.js";
import { makePanel } from "./panel.js";
import { makeScene, Player } from "./player.js";

const main = byId("main", HTMLElement);
const message = byId("message", HTMLElement);
const heading = byId("heading", HTMLElement);
const about = byId("about", HTMLElement);
const deck = byId("player", HTMLElement);
const choice = byId("choice", HTMLElement);

let navigations = 0; // a navigation that is not the latest any more shows nothing

async function openAddress() {
  const navigation = ++navigations;
  setPlayer(null);
  deck.hidden = choice.hidden = message.hidden = true;
  main.setAttribute("aria-busy", "true");
  try {
    const ids = idsInAddress();
    if (ids.length) {
      showMessage("Loading …", "message");
      const episodes = await Promise.all(ids.map(loadEpisode));
      if (navigation !== navigations) return;
      showEpisodes(episodes);
    } else {
      const index = await loadIndex();
      if (navigation !== navigations) return;
      showChoices(index);
    }
  } catch (error) {
    if (navigation !== navigations) return;
    showMessage(error instanceof Error ? error.message : String(error), "message bad");
  }
  main.setAttribute("aria-busy", "false");
}

/**
 * @param {string} text
 * @param {string} className
 */
function showMessage(text, className) {
  message.textContent = text;
  message.className = className;
  message.hidden = false;
}

/** @param {Episode[]} episodes one, or two to be compared */
function showEpisodes(episodes) {
  message.hidden = true;
  deck.hidden = false;
  const { facts } = episodes[0];
  const titles = episodes.map((episode) => truncatedTitle(episode.facts.title)).join(" and ");
  heading.textContent = facts.route;
  about.textContent = [
    titles,
    `repetition ${facts.repetition}`,
    `seed ${facts.seed}`,
    facts.protocol,
    ...scenarioWarning(episodes),
  ].join(" · ");
  document.title = `Replay: ${titles} on ${facts.route}`;
  const scenes = episodes.map(makeScene);
  byId("stages", HTMLElement).replaceChildren(...scenes.map(({ figure }) => figure));
  for (const { canvas } of scenes) connectScene(canvas);
  const panels = episodes.map((episode) => makePanel(episode, (mark) => player.goTo(mark)));
  byId("facts", HTMLElement).replaceChildren(...panels.map(({ node }) => node));
  deck.classList.toggle("two", episodes.length > 1);
  const player = new Player(episodes, scenes, panels, showPlayer);
  setPlayer(player);
  void offerComparison(facts, episodes[1]?.facts.id ?? "");
}

/** @param {Episode[]} episodes */
function scenarioWarning(episodes) {
  const other = episodes.find(({ facts }) => facts.scenario !== episodes[0].facts.scenario);
  if (!other) return [];
  const { route, repetition } = other.facts;
  return [`different scenarios: the replay on the right is ${route}, repetition ${repetition}`];
}

/**
 * List the episodes of the same scenario, if there is an index.
 * @param {EpisodePayload} facts
 * @param {string} comparedId empty for none
 */
async function offerComparison(facts, comparedId) {
  let index;
  try {
    index = await loadIndex();
  } catch {
    return; // a single replay can be shown without an index
  }
  byId("leaderboard", HTMLElement).hidden = !index.leaderboard;
  const others = index.replays.filter(
    ({ id, scenario }) => scenario === facts.scenario && id !== facts.id && isReplayId(id),
  );
  const options = others.map(({ id, title, drivingScore }) =>
    element("option", { value: id }, `${truncatedTitle(title)} (DS ${drivingScore.toFixed(1)})`),
  );
  byId("compare-group", HTMLElement).hidden = !others.length;
  const select = byId("compare", HTMLSelectElement);
  select.replaceChildren(element("option", { value: "" }, "no other"), ...options);
  select.value = comparedId;
}

/** @param {string} id empty for none */
function compareWith(id) {
  const [first] = idsInAddress();
  location.hash = id ? `${first}&${id}` : first;
}

/** @param {ReplayIndex} index */
function showChoices({ replays, leaderboard }) {
  byId("leaderboard", HTMLElement).hidden = !leaderboard;
  heading.textContent = "Replays";
  about.textContent = `${replays.length} in this folder`;
  const items = replays
    .filter(({ id }) => isReplayId(id))
    .map(({ id, title, route, repetition, drivingScore, status, infractions }) => {
      const name = `${truncatedTitle(title)}, ${route}, repetition ${repetition}`;
      const facts = ` DS ${drivingScore.toFixed(1)}, ${status}, ${infractions} infractions`;
      return element(
        "li",
        {},
        element("a", { href: `#${id}` }, name),
        element("span", { class: "muted small" }, facts),
      );
    });
  byId("choices", HTMLElement).replaceChildren(...items);
  choice.hidden = false;
}

installLoader();
connectControls(compareWith);
window.addEventListener("hashchange", openAddress);
void openAddress();
