"""Unevenness of cloth, and smooth lines on it."""
import numpy as np


def crumple(p, size=1.0, seed=0.0):
    """Fine unevenness of hanging cloth, about -1 to 1."""
    p = p / size
    a = np.sin(p @ np.array([31.0, 13, -17]) + 2.1 * np.sin(p @ np.array([11.0, -23, 9]) + seed))
    b = np.sin(p @ np.array([-19.0, 27, 29]) + 1.7 * np.sin(p @ np.array([17.0, 7, -25]) + 2 * seed))
    return 0.5 * (a + b)


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
