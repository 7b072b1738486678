// Colours of values and of names.
// SPDX-License-Identifier: BSD-3-Clause

// Viridis of matplotlib, without its darkest end, which a dark page would swallow.
const STOPS = ["#46327e", "#3f4c8a", "#365c8d", "#2b758e", "#21918c", "#2fb47c", "#7ad151", "#bddf26", "#fde725"];
const NAMED = ["#a99b8a", "#d9822b", "#4c8bd0", "#4fa878", "#c3564f", "#8d75c4", "#47aaa8", "#c9a227"];
const ABSENT = [150, 150, 150];

const parse = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
const TABLE = Array.from({ length: 256 }, (_, k) => {
  const at = (k / 255) * (STOPS.length - 1), low = Math.min(Math.floor(at), STOPS.length - 2);
  const [a, b] = [parse(STOPS[low]), parse(STOPS[low + 1])];
  return a.map((value, c) => value + (b[c] - value) * (at - low));
});

export const gradient = `linear-gradient(to right, ${STOPS.join(", ")})`;
export const nameColor = (index) => NAMED[index % NAMED.length];

/// Two parts in a thousand at either end do not count: a few fast bodies would make all others alike.
export function rangeOf(arrays) {
  const total = arrays.reduce((sum, values) => sum + values.length, 0);
  const stride = Math.max(1, Math.floor(total / 200000));
  const sample = [];
  for (const values of arrays)
    for (let k = 0; k < values.length; k += stride) if (Number.isFinite(values[k])) sample.push(values[k]);
  sample.sort((a, b) => a - b);
  if (!sample.length) return { low: 0, high: 1, log: false };
  const at = (part, from = sample) => from[Math.min(from.length - 1, Math.round(part * (from.length - 1)))];
  const positive = sample.slice(sample.findIndex((value) => value > 0));
  const log = sample[0] >= 0 && at(1) > 0 && at(0.998) > 100 * at(0.25, positive);
  const high = at(0.998), low = log ? Math.max(at(0.02, positive), 1e-5 * high) : at(0.002);
  return { low, high: high > low ? high : low + (Math.abs(low) || 1), log };
}

/// Writes a colour a body into `target`, four bytes each.
export function paint(target, values, { low, high, log }) {
  const scale = log ? (value) => Math.log(value / low) / Math.log(high / low) : (value) => (value - low) / (high - low);
  for (let k = 0; k < values.length; ++k) {
    const part = values[k] <= 0 && log ? 0 : scale(values[k]);
    const color = Number.isNaN(part) ? ABSENT : TABLE[Math.round(255 * Math.min(1, Math.max(0, part)))];
    target.set(color, 4 * k);
  }
}

export function paintNames(target, indices) {
  const colors = NAMED.map(parse);
  for (let k = 0; k < indices.length; ++k) target.set(colors[indices[k] % colors.length], 4 * k);
}

/// Grey-brown, a little different for each body, always the same for the same body.
export function paintRock(target, count) {
  for (let k = 0; k < count; ++k) {
    const noise = (Math.imul(k + 1, 2654435761) >>> 8) / 2 ** 24, shade = 255 * (0.68 + 0.2 * noise);
    target.set([shade, shade * 0.95, shade * 0.88], 4 * k);
  }
}
