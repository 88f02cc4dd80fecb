"""Folds of cloth, each a ridge along a line for which there is a cause: a pull, or cloth that is pressed together."""
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

import nets


class Fold:
    """A ridge along a polyline: `height` and `width` in m; `ends`: how much of it is left at its first and last point."""

    def __init__(self, path, height, width, ends=(0.0, 0.0)):
        self.path, self.height, self.width, self.ends = np.asarray(path, float), height, width, ends

    def __call__(self, p):
        out = np.zeros(len(p))
        reach = 3.2 * self.width
        near = np.flatnonzero(np.all((p > self.path.min(axis=0) - reach) & (p < self.path.max(axis=0) + reach), axis=1))
        if not len(near):
            return out
        p = p[near]
        best, along = np.full(len(p), 9.0), np.zeros(len(p))
        length = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        start = np.concatenate([[0], np.cumsum(length)])
        for k, (a, b) in enumerate(zip(self.path[:-1], self.path[1:])):
            t = np.clip((p - a) @ (b - a) / max(length[k] ** 2, 1e-12), 0, 1)
            d = np.linalg.norm(p - a - np.outer(t, b - a), axis=1)
            nearer = d < best
            best = np.where(nearer, d, best)
            along = np.where(nearer, (start[k] + t * length[k]) / start[-1], along)
        left = self.ends[0] + (1 - self.ends[0]) * np.clip(along / 0.35, 0, 1)
        right = self.ends[1] + (1 - self.ends[1]) * np.clip((1 - along) / 0.45, 0, 1)
        share = left * right
        share = share * share * (3 - 2 * share)
        x = best / (self.width * (0.65 + 0.35 * share))  # narrower where it ends
        # A ridge and the hollows beside it; its crest is sharper than a Gaussian's.
        out[near] = self.height * share * (np.exp(-np.abs(x) ** 1.6) - 0.34 * np.exp(-((x / 1.9) ** 2)))
        return out


class Folds:
    """The sum of folds on a smooth shape, where `free` (points -> 0..1) lets it move: heights (m) of points near it."""

    def __init__(self, shape, lo, hi, folds, free, step=0.006):
        self._lo, self._step = np.asarray(lo, float), step
        rest, _ = nets.surface(shape, lo, hi, 2 * step, rounds=1)
        count = np.ceil((np.asarray(hi, float) - self._lo) / step).astype(int) + 1
        near = np.zeros(count, bool)
        near[tuple(np.clip(np.round((rest - self._lo) / step).astype(int), 0, count - 1).T)] = True
        near = ndimage.binary_dilation(near, iterations=6)  # a spline rings where its grid ends
        cells = self._lo + step * np.argwhere(near)
        on, k = cKDTree(rest).query(cells)
        normal = nets.normals(shape, rest, 0.7 * step)
        flat = cells - np.sum((cells - rest[k]) * normal[k], axis=1, keepdims=True) * normal[k]
        grid = np.zeros(count)
        grid[near] = sum(fold(flat) for fold in folds) * free(flat)
        self._spline = ndimage.spline_filter(grid)

    def __call__(self, p):
        return ndimage.map_coordinates(self._spline, ((p - self._lo) / self._step).T, prefilter=False)


def on(shape, points, rounds=6):
    """Points brought onto a shape's surface."""
    return nets.project(shape, np.asarray(points, float), 0.05, rounds)


def between(shape, a, b, bow=(0, 0, 0), count=7):
    """A line on a shape from a to b, its middle drawn out by `bow`."""
    t = np.linspace(0, 1, count)[:, None]
    a, b = np.asarray(a, float), np.asarray(b, float)
    return on(shape, a + t * (b - a) + 4 * t * (1 - t) * np.asarray(bow, float))


def flipped(fold):
    """Its mirror image."""
    return Fold(fold.path * np.array([-1.0, 1, 1]), fold.height, fold.width, fold.ends)
