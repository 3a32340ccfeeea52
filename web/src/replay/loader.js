// @ts-check
// Loads episodes and towns. A page opened from disk may not fetch files, but it may run scripts
// beside it: each of these hands its data to the page by a method of the global `plantBench`.

/** @import { EpisodePayload, ReplayError, ReplayIndex, TownPayload } from "./payload.js" */
/** @import { Episode } from "./episode.js" */
import { decodeColumns } from "./columns.js";
import { makeEpisode } from "./episode.js";
import { makeTown } from "./town.js";

const REPLAY_FORMAT = 1;
const REPLAY_ID = /^[A-Za-z0-9_][\w.-]*\/[A-Za-z0-9_][\w.-]*$/;
const TOWN_NAME = /^[A-Za-z0-9_][\w.-]*$/;
const INDEX_PATH = "replays/index.js";

/** @type {Map<string, unknown>} by the path of the script that brought it */
const received = new Map();

/**
 * The only global of the page, called by the scripts in replays/ and towns/, which
 * plant_bench/reports/replay writes.
 */
const plantBench = {
  /** @param {EpisodePayload | ReplayError} payload */
  addEpisode: (payload) => received.set(episodePath(payload.id), payload),
  /** @param {TownPayload} payload */
  addTown: (payload) => received.set(townPath(payload.name), payload),
  /** @param {ReplayIndex} payload */
  setIndex: (payload) => received.set(INDEX_PATH, payload),
};

/** Make the global that scripts beside the page call. */
export function installLoader() {
  Object.assign(window, { plantBench });
}

/** @param {string} id */
const episodePath = (id) => `replays/${id}.js`;
/** @param {string} name */
const townPath = (name) => `towns/${name}.js`;

/** @param {string} id */
export const isReplayId = (id) => REPLAY_ID.test(id);

/** Return the list of replays. */
export async function loadIndex() {
  return /** @type {ReplayIndex} */ (await runScript(INDEX_PATH));
}

/**
 * @param {string} id
 * @returns {Promise<Episode>}
 */
export async function loadEpisode(id) {
  const path = episodePath(id);
  const payload = /** @type {EpisodePayload | ReplayError} */ (await runScript(path));
  if (payload.error !== undefined) {
    throw new Error(`There is no replay of ${id}: ${payload.error}`);
  }
  if (payload.format !== REPLAY_FORMAT || !TOWN_NAME.test(payload.town)) {
    throw new Error(`The file ${path} has another format version. Create the replays again.`);
  }
  const townPayload = /** @type {TownPayload} */ (await runScript(townPath(payload.town)));
  try {
    const columns = await decodeColumns(payload.columns, payload.data);
    const townColumns = await decodeColumns(townPayload.columns, townPayload.data);
    return makeEpisode(payload, columns, makeTown(townColumns, townPayload));
  } catch (error) {
    throw brokenFile(path, error instanceof Error ? ` (${error.message})` : "");
  }
}

/**
 * Run a script beside the page, and return what it hands over.
 * @param {string} path
 * @returns {Promise<unknown>}
 */
function runScript(path) {
  if (received.has(path)) return Promise.resolve(received.get(path));
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = path;
    script.onerror = () =>
      reject(
        new Error(
          `The file ${path} is missing. Create the replays again, or copy the whole folder.`,
        ),
      );
    script.onload = () => {
      script.remove();
      if (received.has(path)) resolve(received.get(path));
      else reject(brokenFile(path));
    };
    document.head.append(script);
  });
}

/**
 * @param {string} path
 * @param {string} [detail]
 */
const brokenFile = (path, detail = "") =>
  new Error(`The file ${path} is broken${detail}. Delete it, and create the replays again.`);

/**
 * Return the ids in the address: none, one, or two to be compared.
 * @throws {Error} one is not an id
 */
export function idsInAddress() {
  const parts = location.hash.slice(1).split("&").filter(Boolean);
  const ids = parts.slice(0, 2).map((part) => {
    try {
      return decodeURIComponent(part);
    } catch {
      return part;
    }
  });
  const wrong = ids.find((id) => !isReplayId(id));
  if (wrong !== undefined) {
    const quoted = wrong.slice(0, 80);
    throw new Error(
      `This address does not belong to a replay: "${quoted}" is not <run>/<episode>.`,
    );
  }
  return ids;
}
