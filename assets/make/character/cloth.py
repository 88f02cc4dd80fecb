"""Strips and unevenness of cloth."""
import numpy as np

from sdf import intersect, segment


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
