// How things are called.

const INFRACTIONS = {
  collision_pedestrian: "Collision with a pedestrian",
  collision_vehicle: "Collision with a vehicle",
  collision_static: "Collision with an object",
  red_light: "Red light",
  outside_lanes: "Outside the lanes",
  route_deviation: "Left the route",
  blocked: "Blocked",
  timeout: "Timed out",
};

const CAUSES = {
  free: "nothing keeps it",
  limit: "speed limit or curve",
  light: "traffic light",
  leader: "vehicle ahead",
  conflict: "crossing path",
  junction: "no room beyond the junction",
};

const PHASES = { done: "met", void: "did not happen", committed: "under way", armed: "about to begin", dormant: "not reached" };

const plain = (name) => String(name).replaceAll("_", " ");

function infractionName(item) {
  const name = INFRACTIONS[item.kind] ?? plain(item.kind);
  return item.actorKind && item.kind === "collision_vehicle" ? `Collision with a ${plain(item.actorKind)}` : name;
}

function infractionDetail(item) {
  const parts = [];
  if (item.cause === "ego") parts.push("the ego ran into the other");
  if (item.cause === "other") parts.push("the other ran into the ego");
  if (item.share !== null) parts.push(`${(100 * item.share).toFixed(1)} % of the way`);
  if (item.actor !== null) parts.push(`actor ${item.actor}`);
  parts.push(`at ${(3.6 * item.speed).toFixed(0)} km/h`);
  if (item.factor < 1) parts.push(`score × ${item.factor.toFixed(2)}`);
  return parts.join(", ");
}

const hazardName = (item) => `Hazard: ${plain(item.kind)}`;

function hazardDetail(item) {
  const phase = PHASES[item.phase] ?? item.phase;
  return item.reason ? `${phase}: ${item.reason}` : phase;
}

function clockTime(seconds) {
  const tenths = Math.round(seconds * 10);
  const rest = (tenths % 600) / 10;
  return `${Math.floor(tenths / 600)}:${rest.toFixed(1).padStart(4, "0")}`;
}

function spokenTime(seconds) {
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  return minutes ? `${minutes} min ${whole % 60} s` : `${whole} s`;
}
