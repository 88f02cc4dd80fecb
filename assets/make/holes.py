"""Holes in a model: where a line of sight from outside meets the back of a surface first."""
import numpy as np

PIXEL = 0.001  # m
FOLD = 0.006  # m


def directions(count, lowest):
    """Unit vectors to the eye, a Fibonacci spiral over the part of the sphere above `lowest` (of y)."""
    k = np.arange(count) + 0.5
    y, angle = 1 - (1 - lowest) * k / count, k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.cos(angle), y, r * np.sin(angle)], axis=1)


def _samples(corners):
    """The pixels whose middles are in triangles (n, 3, 3) seen along z, the triangles' numbers, and z there."""
    flat = corners[:, :, :2] / PIXEL
    first = np.ceil(flat.min(axis=1) - 0.5).astype(int)
    size = (np.ceil(flat.max(axis=1) - 0.5).astype(int) - first).max(axis=1)
    a, u, v = flat[:, 0], flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    pixels, numbers, depths = [], [], []
    for i in range(size.max()):
        for j in range(size.max()):
            m = np.flatnonzero((size > max(i, j)) & (np.abs(twice) > 1e-9))
            pixel = first[m] + [i, j]
            w = pixel + 0.5 - a[m]
            s = (w[:, 0] * v[m, 1] - w[:, 1] * v[m, 0]) / twice[m]
            t = (u[m, 0] * w[:, 1] - u[m, 1] * w[:, 0]) / twice[m]
            inside = (s >= 0) & (t >= 0) & (s + t <= 1)
            m, s, t = m[inside], s[inside], t[inside]
            z = corners[m, :, 2]
            pixels.append(pixel[inside])
            numbers.append(m)
            depths.append(z[:, 0] + s * (z[:, 1] - z[:, 0]) + t * (z[:, 2] - z[:, 0]))
    return np.concatenate(pixels), np.concatenate(numbers), np.concatenate(depths)


def seen_from_behind(points, triangles, eye):
    """Places (n, 3) on backs of triangles that nothing hides from an eye far off in direction `eye`."""
    x = np.cross((0, 1, 0), eye)
    x /= np.linalg.norm(x)
    view = np.stack([x, np.cross(eye, x), eye])
    corners = points[triangles] @ view.T
    pixels, numbers, depths = _samples(corners)
    order = np.lexsort((-depths, pixels[:, 1], pixels[:, 0]))  # the nearest first
    pixels, numbers, depths = pixels[order], numbers[order], depths[order]
    nearest = np.r_[True, np.any(np.diff(pixels, axis=0) != 0, axis=1)]
    edges = corners[:, 1:] - corners[:, :1]
    back = np.cross(edges[:, 0], edges[:, 1])[:, 2] < 0
    # A thin fold's far side right behind fills what a turned triangle leaves open.
    first = np.flatnonzero(nearest)
    front = np.where(back[numbers], -np.inf, depths)
    filled = np.maximum.reduceat(front, first) > depths[first] - FOLD
    found = first[back[numbers[first]] & ~filled]
    return np.column_stack([(pixels[found] + 0.5) * PIXEL, depths[found]]) @ view
