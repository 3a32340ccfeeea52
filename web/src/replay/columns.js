// @ts-check
// Decoding of columns of whole numbers, which plant_bench/reports/replay/packing.py encodes.

/** @import { ColumnTable } from "./payload.js" */

/** @typedef {Record<string, Int32Array | undefined>} Columns some columns are optional */

/**
 * @param {ColumnTable} table
 * @param {string} data
 * @returns {Promise<Columns>}
 */
export async function decodeColumns(table, data) {
  const bytes = await inflate(data);
  /** @type {Columns} */
  const found = {};
  let start = 0;
  for (const [name, length, order, width] of table) {
    if (start + length * width > bytes.length) throw new Error("it is truncated");
    found[name] = decodeColumn(bytes, start, length, order, width);
    start += length * width;
  }
  return found;
}

/**
 * Return a column that must be there.
 * @param {Columns} columns
 * @param {string} name
 */
export function requiredColumn(columns, name) {
  const found = columns[name];
  if (!found) throw new Error(`it has no column ${name}`);
  return found;
}

/** @param {string} text deflated bytes in base64 */
async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * @param {Uint8Array} bytes
 * @param {number} start
 * @param {number} length
 * @param {number} order of differences
 * @param {number} width bytes a value
 */
function decodeColumn(bytes, start, length, order, width) {
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

/**
 * Return the index of the last of rising values that is not above a limit; -1 where all are.
 * @param {ArrayLike<number>} values
 * @param {number} limit
 */
export function lastAtOrBefore(values, limit) {
  let low = -1;
  let high = values.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= limit) low = middle;
    else high = middle;
  }
  return low;
}
