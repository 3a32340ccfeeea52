// Columns of whole numbers, as packing.py writes them.

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function unpackColumn(bytes, start, length, order, width) {
  const values = new Int32Array(length);
  for (let plane = 0; plane < width; plane++) {
    const from = start + plane * length;
    for (let row = 0; row < length; row++) values[row] |= bytes[from + row] << (8 * plane);
  }
  for (let row = 0; row < length; row++) values[row] = (values[row] >>> 1) ^ -(values[row] & 1);
  for (let times = 0; times < order; times++) {
    for (let row = 1; row < length; row++) values[row] += values[row - 1];
  }
  return values;
}

async function unpack(columns, text) {
  const bytes = await inflate(text);
  const found = {};
  let start = 0;
  for (const [name, length, order, width] of columns) {
    if (start + length * width > bytes.length) throw new Error("it ends too early");
    found[name] = unpackColumn(bytes, start, length, order, width);
    start += length * width;
  }
  return found;
}

function lastAtOrBefore(values, wanted) {
  let low = -1;
  let high = values.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle;
  }
  return low;
}
