// Which bodies may be seen: most of a pile lie behind others, and to draw them costs as much.
// SPDX-License-Identifier: BSD-3-Clause

const MOST_CELLS = 1024; // along a side of the picture
const MARGIN = 0.99; // the shader reckons with fewer digits
let places = new Float64Array(0); // left, bottom, z and radius of each body in the picture, kept from call to call

/// Writes the rows of bodies that may be seen into `list`, three indices each, and returns how many they are. The
/// picture is cut into cells. A cell that lies wholly within a body's disc is closed behind the body's middle.
/// `toView`: the matrix into the camera's frame, z towards the viewer; `box`: left, bottom, width, height there;
/// `pixel`: the least radius that is drawn; `cell`: about half a radius; `cut`: the plane, or null.
export function findSeen(list, spheres, count, toView, box, pixel, cell, cut) {
  const size = Math.max(cell, box.width / MOST_CELLS, box.height / MOST_CELLS);
  const across = Math.ceil(box.width / size), up = Math.ceil(box.height / size);
  const closed = new Float32Array(across * up).fill(-Infinity);
  if (places.length < 4 * count) places = new Float64Array(4 * count);
  for (let k = 0; k < count; ++k) {
    const x = spheres[4 * k], y = spheres[4 * k + 1], z = spheres[4 * k + 2], own = spheres[4 * k + 3];
    const vx = toView[0] * x + toView[4] * y + toView[8] * z + toView[12];
    const vy = toView[1] * x + toView[5] * y + toView[9] * z + toView[13];
    const vz = toView[2] * x + toView[6] * y + toView[10] * z + toView[14];
    const above = cut ? cut.x * vx + cut.y * vy + cut.z * vz - cut.w : -Infinity;
    const left = vx - box.left, bottom = vy - box.bottom;
    places[4 * k] = left;
    places[4 * k + 1] = bottom;
    places[4 * k + 2] = vz;
    places[4 * k + 3] = own > 0 && above < own ? Math.max(own, pixel) : 0;
    if (own < size || above > -own) continue;
    const disc = MARGIN * own;
    const last = Math.min(up, Math.floor((bottom + disc) / size));
    for (let j = Math.max(0, Math.ceil((bottom - disc) / size)); j < last; ++j) {
      const apart = Math.max(Math.abs(j * size - bottom), Math.abs((j + 1) * size - bottom));
      if (apart >= disc) continue;
      const half = Math.sqrt(disc * disc - apart * apart), end = Math.min(across, Math.floor((left + half) / size));
      for (let i = Math.max(0, Math.ceil((left - half) / size)); i < end; ++i)
        if (vz > closed[j * across + i]) closed[j * across + i] = vz;
    }
  }
  let found = 0;
  for (let k = 0; k < count; ++k) {
    const r = places[4 * k + 3];
    if (r === 0 || !isOpen(closed, across, up, size, places[4 * k], places[4 * k + 1], places[4 * k + 2] + r / MARGIN, r)) continue;
    for (let corner = 0; corner < 3; ++corner) list[3 * found + corner] = 3 * k + corner;
    ++found;
  }
  return found;
}

/// Whether a cell within reach of a body is not closed before the body begins.
function isOpen(closed, across, up, size, left, bottom, front, r) {
  const end = Math.min(across - 1, Math.floor((left + r) / size)), last = Math.min(up - 1, Math.floor((bottom + r) / size));
  for (let j = Math.max(0, Math.floor((bottom - r) / size)); j <= last; ++j)
    for (let i = Math.max(0, Math.floor((left - r) / size)); i <= end; ++i)
      if (closed[j * across + i] < front) return true;
  return false;
}
