# Pictures of many spheres: a depth buffer, one light with shadows, and darkness in the gaps.
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np


class Camera:
    """Orthographic. `toward` points from the scene to the viewer; `center` (m) is in the middle of
    the picture, which shows `width` x `height` metres."""

    def __init__(self, toward, up, center, width, height, pixels):
        self.toward = toward / np.linalg.norm(toward)
        right = np.cross(up, self.toward)
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.toward, self.right)
        self.center = np.asarray(center)
        self.width, self.height = width, height
        self.columns = pixels
        self.rows = round(pixels * height / width)

    def project(self, points):
        """Right, up and depth (m, larger is nearer) of points in the picture's frame."""
        relative = points - self.center
        return relative @ self.right, relative @ self.up, relative @ self.toward


def depth_buffer(camera, position, radius):
    """Depth (m) of what is seen in each pixel, -inf where nothing is, and whose it is."""
    scale = camera.columns / camera.width
    x, y, z = camera.project(position)
    column, row, size = (x + camera.width / 2) * scale, (camera.height / 2
                                                         - y) * scale, radius * scale
    depth = np.full(camera.rows * camera.columns, -np.inf)
    owner = np.full(len(depth), -1)
    seen = (column + size > 0) & (column - size < camera.columns)
    seen = np.flatnonzero(seen & (row + size > 0) & (row - size < camera.rows))
    top, height = pixels_across(row, size, camera.rows)
    left, width = pixels_across(column, size, camera.columns)
    # Squares of about equal width, as many at once as stay in the processor's cache.
    wide = np.maximum(width, height)
    seen = seen[np.lexsort((-z[seen], wide[seen]))]  # the nearest first
    batch = np.cumsum(wide[seen] ** 2) // 20_000
    other_width = np.diff(np.floor(4 * np.log2(wide[seen]))) > 0
    for some in np.split(seen, np.flatnonzero((np.diff(batch) > 0) | other_width) + 1):
        if not len(some):
            break  # nothing is seen
        some = some[::-1]
        i, dy = pixels_beside(row[some], top[some], height[some].max(), camera.rows)
        j, dx = pixels_beside(column[some], left[some], width[some].max(), camera.columns)
        with np.errstate(invalid="ignore"):  # no number beside the sphere, which is never nearer
            surface = np.sqrt(size[some, None, None] ** 2 - dx[:, None, :] ** 2
                              - dy[:, :, None] ** 2)
        surface = (z[some, None, None] + surface / scale).ravel()
        pixel = (i[:, :, None] * camera.columns + j[:, None, :]).ravel()
        of = len(surface) // len(some)  # pixels of each
        nearer = np.flatnonzero(surface > depth[pixel])
        while len(nearer):  # of a pixel's spheres the last one stays, until none is nearer
            depth[pixel[nearer]] = surface[nearer]
            owner[pixel[nearer]] = some[nearer // of]
            nearer = nearer[surface[nearer] > depth[pixel[nearer]]]
    return (depth.reshape(camera.rows, camera.columns), owner.reshape(camera.rows, camera.columns))


def pixels_across(center, size, count):
    """The first pixel along an axis that a sphere in sight reaches, and how many it reaches."""
    first = np.maximum(np.floor(center - size), 0).astype(int)
    return first, np.minimum(np.floor(center + size), count - 1).astype(int) + 1 - first


def pixels_beside(center, first, number, count):
    """So many pixels from `first` on, and how far they are from `center`; infinitely far if they
    lie outside."""
    pixels = first[:, None] + np.arange(number)
    inside = pixels < count
    return np.where(inside, pixels, 0), np.where(inside, pixels + 0.5 - center[:, None], np.inf)


def blurred(values, size):
    """Mean over squares of 2 size + 1 pixels."""
    for axis in (0, 1):
        padded = np.pad(values, [(size + 1, size) if a == axis else (0, 0) for a in (0, 1)], "edge")
        sums = np.moveaxis(np.cumsum(padded, axis=axis), axis, 0)
        values = np.moveaxis((sums[2 * size + 1:] - sums[:-2 * size - 1]) / (2 * size + 1), 0, axis)
    return values


def frame_of(hit):
    """The rows and columns of all that is hit and of a pixel around it, beyond which nothing
    changes."""
    def range_of(there):
        places = np.flatnonzero(there)
        return slice(max(places[0] - 1, 0), places[-1] + 2) if len(places) else slice(0, 1)
    return range_of(hit.any(axis=1)), range_of(hit.any(axis=0))


def shadows(camera, light, position, radius, points):
    """Part of the light that reaches points, by a depth buffer seen from the light."""
    reach = 1.3 * max(camera.width, camera.height)  # what is far outside casts no shadow
    seen = Camera(light, camera.up, camera.center, reach, reach, min(2 * camera.columns, 2400))
    depth, _ = depth_buffer(seen, position, radius)
    x, y, z = seen.project(points)
    scale = seen.columns / seen.width
    lit = np.zeros(len(points))
    for dx, dy in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
        column = np.clip(((x + seen.width / 2) * scale + dx).astype(int), 0, seen.columns - 1)
        row = np.clip(((seen.height / 2 - y) * scale + dy).astype(int), 0, seen.rows - 1)
        lit += (depth[row, column] <= z + 0.12 * np.median(radius)) / 4
    return lit


def render(camera, position, radius, color, background, soft=False):
    """Picture (rows, columns, 3) of shaded spheres; twice as fine inside, for smooth edges. `soft`
    takes the shadows away where colours are to be read as values."""
    fine = Camera(camera.toward, camera.up, camera.center, camera.width, camera.height,
                  2 * camera.columns)
    fine.rows = 2 * camera.rows
    depth, owner = depth_buffer(fine, position, radius)
    window = frame_of(owner >= 0)
    depth, owner = depth[window], owner[window]
    hit = owner >= 0
    rows, columns = np.nonzero(hit)
    pixel = fine.width / fine.columns
    x = (columns + window[1].start + 0.5) * pixel - fine.width / 2
    y = fine.height / 2 - (rows + window[0].start + 0.5) * pixel
    points = (fine.center + x[:, None] * fine.right + y[:, None] * fine.up
              + depth[hit][:, None] * fine.toward)
    whose = owner[hit]
    normal = (points - position[whose]) / radius[whose][:, None]

    light = fine.toward * 0.75 - fine.right * 0.75 + fine.up * 0.8
    light /= np.linalg.norm(light)
    sun = np.maximum(normal @ light, 0)
    if not soft and len(points):
        sun *= shadows(fine, light, position, radius, points)
    # Gaps are dark: what lies below the mean depth of its surroundings sees less of the sky.
    floor = depth[hit].min() if hit.any() else 0
    filled = np.where(hit, depth, floor)
    reach = np.median(radius) if len(radius) else 1
    sky = np.ones(len(points))
    for factor in (1, 3):
        around = blurred(filled, max(int(factor * reach / pixel), 1))[hit]
        sky *= 1 - np.clip((around - depth[hit]) / (3 * factor * reach), 0, 0.6)
    facing = normal @ fine.toward
    brightness = (0.62 + 0.38 * facing) * sky if soft else (0.17 + 0.17
                                                            * facing) * sky**2 + 0.95 * sun * sky

    image = np.empty((fine.rows, fine.columns, 3))
    image[:] = background
    image[window][hit] = np.clip(color[whose] * brightness[:, None], 0, 1)
    return (image[::2, ::2] + image[1::2, ::2] + image[::2, 1::2] + image[1::2, 1::2]) / 4
