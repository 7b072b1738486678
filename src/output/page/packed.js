// Arrays that report_bodies.py packed: base64 of deflated bytes, sorted by their weight.
// SPDX-License-Identifier: BSD-3-Clause

export async function unpack(text, Kind) {
  const raw = atob(text);
  const deflated = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; ++k) deflated[k] = raw.charCodeAt(k);
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  const sorted = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = Kind.BYTES_PER_ELEMENT, count = sorted.length / size;
  const bytes = new Uint8Array(sorted.length);
  for (let b = 0; b < size; ++b)
    for (let k = 0; k < count; ++k) bytes[k * size + b] = sorted[b * count + k];
  return new Kind(bytes.buffer);
}

/// Floats of which only the upper 16 bits were kept, above an offset.
export async function unpackField({ offset, values }) {
  const halves = await unpack(values, Uint16Array);
  const bits = Uint32Array.from(halves, (half) => half << 16);
  return new Float32Array(bits.buffer).map((value) => value + offset);
}

export function readableNumber(value, digits = 3) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1).replace("e+", "e");
}

export function readableTime(seconds) {
  if (seconds === 0) return "0 s";
  for (const [limit, unit, name] of [[1e-3, 1e-6, "µs"], [1, 1e-3, "ms"], [120, 1, "s"], [7200, 60, "min"]])
    if (Math.abs(seconds) < limit) return `${readableNumber(seconds / unit)} ${name}`;
  return `${readableNumber(seconds / 3600)} h`;
}

export function readableLength(meters) {
  for (const [limit, unit, name] of [[1e-3, 1e-6, "µm"], [1, 1e-3, "mm"], [1e3, 1, "m"]])
    if (meters < limit * (1 - 1e-9)) return `${readableNumber(meters / unit)} ${name}`;  // round-off: 1 mm is one
  return `${readableNumber(meters / 1e3)} km`;
}

export function escapeHtml(text) {
  return String(text).replace(/[&<>"']/g, (sign) => `&#${sign.charCodeAt(0)};`);
}
