// Scripts beside the page bring episodes and towns: pages from disk may not fetch.

const ID = /^[A-Za-z0-9_][\w.-]*\/[A-Za-z0-9_][\w.-]*$/;
const NAME = /^[A-Za-z0-9_][\w.-]*$/;
const arrived = new Map();

window.plantBenchReplay = (facts) => arrived.set(`replays/${facts.id}.js`, facts);
window.plantBenchTown = (facts) => arrived.set(`towns/${facts.name}.js`, facts);
window.plantBenchIndex = (facts) => arrived.set("replays/index.js", facts);

function load(path) {
  if (arrived.has(path)) return Promise.resolve(arrived.get(path));
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = path;
    script.onerror = () => reject(new Error(`The file ${path} is missing. Make the replays again, or copy the whole folder.`));
    script.onload = () => {
      script.remove();
      if (arrived.has(path)) resolve(arrived.get(path));
      else reject(new Error(`The file ${path} is broken. Remove it, and make the replays again.`));
    };
    document.head.append(script);
  });
}

function wantedIds() {
  const parts = location.hash.slice(1).split("&").filter(Boolean);
  const ids = parts.slice(0, 2).map((part) => {
    try {
      return decodeURIComponent(part);
    } catch {
      return part;
    }
  });
  const bad = ids.find((id) => !ID.test(id));
  if (bad !== undefined) throw new Error(`The address names no replay: "${bad.slice(0, 80)}" is not <run>/<episode>.`);
  return ids;
}

async function loadEpisode(id) {
  const path = `replays/${id}.js`;
  const facts = await load(path);
  if (facts.error) throw new Error(`There is no replay of ${id}: ${facts.error}`);
  if (facts.format !== 1 || !NAME.test(facts.town)) throw new Error(`The file ${path} is of another version. Make the replays again.`);
  const told = await load(`towns/${facts.town}.js`);
  try {
    const columns = await unpack(facts.columns, facts.data);
    const town = makeTown(await unpack(told.columns, told.data), told);
    return makeEpisode(facts, columns, town);
  } catch (error) {
    throw new Error(`The file ${path} is broken (${error.message}). Remove it, and make the replays again.`);
  }
}
