"""The head band over the hood: a cloth band, its knot and two tails behind."""
import numpy as np

from character import hood
from sdf import ellipsoid, intersect, union


def band(p):
    a, up = hood.around(p), hood.band_height(p)
    # Creases along it, which gather towards the knot.
    gathered = 0.35 + 0.65 * np.clip((np.abs(a) - 1.2) / 1.6, 0, 1)
    crease = np.abs(np.sin(up * 260 + 1.3 * np.sin(2 * a + 0.5) + 0.7 * np.sin(5 * a))) ** 0.8 - 0.6
    hemmed = 0.0006 * np.exp(-(((np.abs(up) - 0.0125) / 0.0018) ** 2))
    half = 0.0160 - 0.0020 * np.clip((np.abs(a) - 1.6) / 1.4, 0, 1)
    under = hood.outside(p)
    d = intersect(np.abs(under + 0.0010) - 0.0042 - 0.0030 * gathered * crease - hemmed, np.abs(up) - half, 0.0022)
    knot = ellipsoid(p, (0, 1.7300, -0.1245), (0.0160, 0.0125, 0.0105))
    knot = knot + 0.0016 * np.abs(np.sin(p[:, 0] * 230 + p[:, 1] * 90))
    return np.minimum(union(d, knot, 0.004), _tails(p))


def _tails(p):
    d = np.full(len(p), 9.0)
    for side, length, phase in ((0.030, 0.165, 0.0), (-0.036, 0.135, 1.3)):
        t = np.clip((1.728 - p[:, 1]) / length, 0, 1)
        x = side * t**0.8 + 0.006 * np.sin(5 * t + phase)
        z = -0.131 - 0.020 * np.sin(2.2 * t) - 0.004 * np.sin(7 * t + phase)
        twist = 0.5 * np.sin(3 * t + phase)
        u, w = p[:, 0] - x, p[:, 2] - z
        across = u * np.cos(twist) + w * np.sin(twist)
        curl = 0.0016 * np.sin(across * 300 + 4 * t + phase)
        thick = np.abs(-u * np.sin(twist) + w * np.cos(twist) + curl) - 0.0020
        half = 0.010 + 0.006 * t
        s = intersect(np.abs(across) - half, thick, 0.002)
        s = intersect(s, np.maximum(p[:, 1] - 1.730, 1.728 - length - p[:, 1] + 0.25 * across), 0.002)
        d = np.minimum(d, 0.8 * s)
    return d
