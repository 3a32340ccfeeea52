// One episode: what is where at any moment. Moments are frames, which may be fractions.

const FRESH_PLAN = 1.5; // s for which a plan is shown
const FRESH_ATTENTION = 1.2;

function makeEpisode(facts, columns, town) {
  const length = facts.scales.length;
  const metres = (name) => Float64Array.from(columns[name] ?? [], (value) => value / length);
  const radians = (name) => Float64Array.from(columns[name], (value) => value / facts.scales.angle);
  const frames = columns["ego.x"].length;
  const episode = {
    facts,
    town,
    frames,
    duration: (frames - 1) * facts.step,
    ego: { x: metres("ego.x"), y: metres("ego.y"), yaw: radians("ego.yaw"), speed: metres("ego.speed"), acceleration: metres("ego.acceleration") },
    progress: metres("progress"),
    pose: { x: metres("pose.x"), y: metres("pose.y"), yaw: radians("pose.yaw") },
    route: { x: metres("route.x"), y: metres("route.y") },
    lights: columns.lights,
    tracks: makeTracks(columns, length),
    plans: { ticks: columns["plan.tick"], values: Array.from({ length: 8 }, (_, place) => metres(`plan.${place}`)) },
    causes: columns["reason.cause"],
    actors: columns["reason.actor"],
    attention: makeAttention(columns, facts.scales.share),
    expert: columns["expert.tick"] ? { ticks: columns["expert.tick"], actors: columns["expert.actor"] } : null,
  };
  episode.limits = limitsOf(episode);
  episode.marks = marksOf(facts);
  episode.routePath = linePath(episode.route.x, episode.route.y);
  return episode;
}

function makeTracks(columns, length) {
  let start = 0;
  return Array.from(columns["track.id"], (id, place) => {
    const count = columns["track.count"][place];
    const track = {
      id,
      kind: columns["track.kind"][place],
      length: columns["track.length"][place] / length,
      width: columns["track.width"][place] / length,
      first: columns["track.first"][place],
      count,
      start,
    };
    start += count;
    return track;
  });
}

function makeAttention(columns, scale) {
  const starts = [0];
  for (const count of columns["attention.count"]) starts.push(starts.at(-1) + count);
  return {
    ticks: columns["attention.tick"],
    starts,
    actors: columns["attention.actor"],
    shares: Array.from(columns["attention.share"], (share) => share / scale),
  };
}

function linePath(x, y) {
  const path = new Path2D();
  for (let place = 0; place < x.length; place++) path.lineTo(x[place], y[place]);
  return path;
}

const frameAt = (episode, seconds) => Math.min(Math.max(seconds / episode.facts.step, 0), episode.frames - 1);
const tickAt = (episode, seconds) => Math.floor(seconds / episode.facts.tick + 1e-6);

function between(values, start, last, at) {
  const low = Math.min(Math.max(Math.floor(at), 0), last);
  const high = Math.min(low + 1, last);
  const share = Math.min(Math.max(at - low, 0), 1);
  return values[start + low] * (1 - share) + values[start + high] * share;
}

function egoAt(episode, frame) {
  const at = (values) => between(values, 0, episode.frames - 1, frame);
  const { x, y, yaw, speed, acceleration } = episode.ego;
  return { x: at(x), y: at(y), yaw: at(yaw), speed: at(speed), acceleration: at(acceleration) };
}

function actorsAt(episode, frame) {
  const found = [];
  const { x, y, yaw } = episode.pose;
  for (const track of episode.tracks) {
    const at = frame - track.first;
    if (at < 0 || at >= track.count) continue;
    const of = (values) => between(values, track.start, track.count - 1, at);
    found.push({ ...track, x: of(x), y: of(y), yaw: of(yaw) });
  }
  return found;
}

function lightsAt(episode, frame) {
  const row = Math.floor(frame + 1e-6);
  return episode.facts.signals.map((place, signal) => ({ place, state: episode.lights[signal * episode.frames + row] }));
}

// The waypoints in the world: from where the ego was when it planned.
function planAt(episode, seconds) {
  const tick = tickAt(episode, seconds);
  const row = lastAtOrBefore(episode.plans.ticks, tick);
  if (row < 0 || (tick - episode.plans.ticks[row]) * episode.facts.tick > FRESH_PLAN) return [];
  const then = (episode.plans.ticks[row] * episode.facts.tick) / episode.facts.step;
  const ego = egoAt(episode, then);
  const cos = Math.cos(ego.yaw);
  const sin = Math.sin(ego.yaw);
  return [0, 2, 4, 6].map((place) => {
    const ahead = episode.plans.values[place][row];
    const left = episode.plans.values[place + 1][row];
    return [ego.x + cos * ahead - sin * left, ego.y + sin * ahead + cos * left];
  });
}

function reasonAt(episode, frame) {
  if (!episode.causes) return null;
  const row = Math.floor(frame + 1e-6);
  const cause = episode.causes[row] - 1;
  return cause < 0 ? null : { cause: episode.facts.causes[cause], actor: episode.actors[row] - 1 };
}

function attentionAt(episode, seconds) {
  const { ticks, starts, actors, shares } = episode.attention;
  const tick = tickAt(episode, seconds);
  const row = lastAtOrBefore(ticks, tick);
  if (row < 0 || (tick - ticks[row]) * episode.facts.tick > FRESH_ATTENTION) return [];
  const found = [];
  for (let place = starts[row]; place < starts[row + 1]; place++) found.push({ actor: actors[place], share: shares[place] });
  return found;
}

// Whom the expert would brake for: an id, -1 for nobody, null where that is not known.
function expertAt(episode, seconds) {
  if (!episode.expert) return null;
  const { ticks, actors } = episode.expert;
  const tick = tickAt(episode, seconds);
  const row = lastAtOrBefore(ticks, tick);
  if (row < 0 || (tick - ticks[row]) * episode.facts.tick > FRESH_ATTENTION) return null;
  return actors[row] - 1;
}

// The speed limit at each frame, m/s.
function limitsOf({ facts, progress }) {
  const places = facts.limits.map(([at]) => at);
  return Float64Array.from(progress, (along) => facts.limits[Math.max(lastAtOrBefore(places, along), 0)][1]);
}

const limitAt = (episode, frame) => episode.limits[Math.floor(frame + 1e-6)];

const kindOf = (episode, id) => {
  const track = episode.tracks.find((item) => item.id === id);
  return track ? plain(episode.facts.kinds[track.kind]) : "actor";
};
