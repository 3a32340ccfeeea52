// A town: areas, roads and paint on two levels.

const LEVELS = [
  ["pavement", "junction", "road", "edge", "between", "middle", "zebra", "stop"],
  ["bridge", "road", "edge", "between", "middle"],
];
const AREAS = new Set(["pavement", "junction", "zebra"]);
const PAINT = { edge: 0.14, between: 0.13, middle: 0.17, stop: 0.4 }; // m
const DASHES = [3, 4]; // m

function makeTown(columns, told) {
  const layers = LEVELS.map((kinds) => new Map(kinds.map((kind) => [kind, []])));
  let start = 0;
  columns.kind.forEach((number, place) => {
    const count = columns.count[place];
    const piece = makePiece(columns, start, count, columns.width[place] / 100);
    layers[columns.upper[place]].get(told.kinds[number])?.push(piece);
    start += count;
  });
  return { name: told.name, checksum: told.checksum, layers };
}

function makePiece(columns, start, count, width) {
  const path = new Path2D();
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (let place = start; place < start + count; place++) {
    const x = columns.x[place] / 100;
    const y = columns.y[place] / 100;
    path.lineTo(x, y);
    box[0] = Math.min(box[0], x - width);
    box[1] = Math.min(box[1], y - width);
    box[2] = Math.max(box[2], x + width);
    box[3] = Math.max(box[3], y + width);
  }
  return { path, box, width };
}

function drawTown(context, town, seen, colours) {
  context.lineCap = "butt";
  context.lineJoin = "round";
  for (const layer of town.layers) {
    for (const [kind, pieces] of layer) drawPieces(context, kind, pieces, seen, colours);
  }
  context.setLineDash([]);
}

function drawPieces(context, kind, pieces, seen, colours) {
  const names = { junction: "road", edge: "paint", between: "paint", stop: "paint" };
  context.fillStyle = context.strokeStyle = colours[names[kind] ?? kind];
  context.setLineDash(kind === "between" ? DASHES : []);
  for (const { path, box, width } of pieces) {
    if (box[0] > seen[2] || box[2] < seen[0] || box[1] > seen[3] || box[3] < seen[1]) continue;
    if (AREAS.has(kind)) {
      context.fill(path);
    } else {
      context.lineWidth = PAINT[kind] ?? width;
      context.stroke(path);
    }
  }
}
