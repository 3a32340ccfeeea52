// The page's data, unpacked: `page_data.py` packs it.

const DATA = JSON.parse(document.getElementById("data").textContent);
const LEVEL = 0.05; // of p corrected: below it two planners are told apart
const RANKED = DATA.ranked; // the score that tables are sorted by
const EPISODE_SCORES = DATA.scores.filter((score) => score.ofEpisode);

/** What the filters say; changed by main.js alone. */
const FILTER = { text: "", track: "", town: "", board: "" };

function unpackEpisode(packed, line, board) {
  const [name, route, repetition, scenario, status, scores, duration, infractions, hazards, replay, reason] = packed;
  const [routeName, town] = board.routes[route];
  return {
    id: `${line.id}/${name}`,
    line,
    route: routeName,
    town: board.towns[town],
    repetition,
    scenario,
    status: DATA.statuses[status],
    scores: Object.fromEntries(EPISODE_SCORES.map((score, place) => [score.name, scores[place]])),
    duration,
    infractions: infractions.map(([kind, time, actor, cause, share]) => ({
      kind: DATA.kinds[kind],
      time,
      actor: DATA.actors[actor] ?? "",
      cause,
      share,
    })),
    hazards: hazards.map(([kind, phase, time, survived = 1]) => ({
      kind: DATA.hazards[kind],
      phase: DATA.phases[phase],
      time,
      survived: Boolean(survived),
    })),
    replay: Boolean(replay),
    reason,
  };
}

function unpackBoard(board, place) {
  board.id = `board-${place}`;
  board.lines.forEach((line, index) => {
    line.place = index;
    line.detail = board.details[index] ?? null;
  });
  const packed = board.episodes;
  let unpacked = null;
  board.allEpisodes = () => {
    unpacked ??= packed.flatMap((list, index) =>
      list.map((item) => unpackEpisode(item, board.lines[index], board)));
    return unpacked;
  };
  board.pairs = board.differences.map(([better, worse, mean, low, high, p, corrected, pairs, routes]) => ({
    better: board.lines[better],
    worse: board.lines[worse],
    mean,
    low,
    high,
    p,
    corrected,
    pairs,
    routes,
    told: known(corrected) && corrected <= LEVEL,
  }));
  return board;
}

const BOARDS = DATA.boards.map(unpackBoard);

/** One of a line's scores, mean and deviation, in the chosen town if there is one. */
function scoreOf(line, name) {
  const scores = FILTER.town ? line.detail?.towns[FILTER.town] : line.scores;
  return scores?.[name] ?? [null, null];
}

/** The difference of one line from another, seen from the first; null where none is known. */
function differenceOf(board, first, second) {
  const found = board.pairs.find(
    (pair) => (pair.better === first && pair.worse === second) || (pair.better === second && pair.worse === first));
  if (!found) return null;
  if (found.better === first) return found;
  const turned = { mean: -found.mean, low: known(found.low) ? -found.high : null, high: known(found.high) ? -found.low : null };
  return { ...found, ...turned };
}

function shownLines(board) {
  const text = FILTER.text.trim().toLowerCase();
  return board.lines.filter((line) => {
    const words = [line.planner, line.inputs.join(" "), line.track, line.source].join(" ").toLowerCase();
    return words.includes(text) && (!FILTER.track || line.track === FILTER.track);
  });
}

const ownTowns = () => [...new Set(BOARDS.flatMap((board) => board.towns))].sort();
