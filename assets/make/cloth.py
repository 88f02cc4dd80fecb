"""Folds: ridges and valleys pressed into a cloth surface, placed one by one or in fans."""
import numpy as np

from sdf import intersect, segment
from skeleton import unit


class Folds:
    """A height (m) added along the surface's normal: the sum of soft ridges along segments."""

    def __init__(self):
        self._folds = []

    def ridge(self, start, end, width, height, spread=1.6):
        """From `start`, where it is sharp, to `end`, where it has faded and is `spread` times wider."""
        self._folds.append((np.asarray(start, float), np.asarray(end, float), width, height, spread))
        return self

    def fan(self, origin, aims, width, height, start=0.15, seed=0.0):
        """Ridges with valleys between them, radiating from `origin` to each of `aims`."""
        origin = np.asarray(origin, float)
        aims = [np.asarray(a, float) for a in aims]
        for k, aim in enumerate(aims):
            vary = 1 + 0.25 * np.sin(12.9 * k + seed)
            self.ridge(origin + start * vary * (aim - origin), origin + (0.9 + 0.2 * vary) * (aim - origin), width * vary, height * vary)
            if k:
                between = 0.5 * (aim + aims[k - 1])
                self.ridge(origin + start * (between - origin), between, 0.8 * width, -0.8 * height)
        return self

    def rings(self, centre, axis, side, radius, spacing, count, width, height, lean=0.5, seed=0.0):
        """Folds stacked along a limb's `axis` on one `side` of it: short chords across the limb."""
        axis, side = unit(axis), unit(side)
        across = np.cross(axis, side)
        for k in range(count):
            vary = np.sin(7.7 * k + seed)
            middle = np.asarray(centre, float) + axis * spacing * (k - (count - 1) / 2 + 0.2 * vary)
            tilt = axis * lean * spacing * (1 if k % 2 else -1)
            a = middle + side * radius * 0.75 + across * radius * (0.75 + 0.2 * vary) + tilt
            b = middle + side * radius * 0.85 - across * radius * (0.75 - 0.2 * vary) - tilt
            m = middle + side * radius * 1.05
            self.ridge(m, a, width, height, 1.2).ridge(m, b, width, height, 1.2)
        return self

    def __call__(self, p):
        out = np.zeros(len(p))
        for a, b, width, height, spread in self._folds:
            reach = 2.4 * width * max(1, spread)
            near = np.flatnonzero(np.all((p > np.minimum(a, b) - reach) & (p < np.maximum(a, b) + reach), axis=1))
            if not len(near):
                continue
            q = p[near]
            ab = b - a
            t = np.clip((q - a) @ ab / (ab @ ab), 0, 1)
            d = np.linalg.norm(q - a - np.outer(t, ab), axis=1)
            w = width * (1 + (spread - 1) * t)
            out[near] += height * np.exp(-((d / w) ** 2)) * (1 - t) ** 0.7 * np.minimum(1, 0.4 + 6 * t)
        return out


def crumple(p, size=1.0, seed=0.0):
    """Fine unevenness of hanging cloth, about -1 to 1."""
    p = p / size
    a = np.sin(p @ np.array([31.0, 13, -17]) + 2.1 * np.sin(p @ np.array([11.0, -23, 9]) + seed))
    b = np.sin(p @ np.array([-19.0, 27, 29]) + 1.7 * np.sin(p @ np.array([17.0, 7, -25]) + 2 * seed))
    return 0.5 * (a + b)


def ribbon(p, surface, path, half_width, half_thick, edge=0.003):
    """A strip lying on `surface` (a field's values at p) along a polyline, with rounded edges."""
    d = np.full(len(p), 9.0)
    for a, b in zip(path[:-1], path[1:]):
        m = np.flatnonzero(np.all((p > np.minimum(a, b) - 0.06) & (p < np.maximum(a, b) + 0.06), axis=1))
        d[m] = np.minimum(d[m], segment(p[m], a, b))
    return intersect(d - half_width, np.abs(surface) - half_thick, edge)


def spline(points, per_span=6):
    """Catmull-Rom through points, sampled."""
    p = np.asarray(points, float)
    p = np.concatenate([[2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]])
    out = []
    for k in range(1, len(p) - 2):
        for t in np.arange(per_span) / per_span:
            a, b, c, d = p[k - 1 : k + 3]
            out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return np.array(out + [p[-2]])
