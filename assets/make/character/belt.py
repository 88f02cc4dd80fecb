"""The belt: two turns round the waist, a flat knot, two hanging tails."""
import numpy as np

from character import jacket_shape
from sdf import ellipsoid, intersect, limb, rotation, union
from skeleton import vec

_HALF = 0.021
_KNOT = vec(0.0, 1.026, 0.142)


def height(p):
    """Height over the middle of the belt, which dips in front."""
    return p[:, 1] - (jacket_shape.BELT - 0.06 * p[:, 2])


def _tail(p, lean, length, phase):
    t = np.clip((_KNOT[1] - p[:, 1]) / length, 0, 1)
    x = lean * t**0.8 + np.sign(lean) * 0.008
    z = _KNOT[2] + 0.008 + 0.030 * np.sin(1.7 * t) + 0.004 * np.sin(7 * t + phase)
    twist = 0.35 * np.sin(3 * t + phase)
    u, w = p[:, 0] - x, p[:, 2] - z
    across = u * np.cos(twist) + w * np.sin(twist)
    through = -u * np.sin(twist) + w * np.cos(twist)
    d = intersect(np.abs(across) - 0.0190, np.abs(through) - 0.0034, 0.0025)
    end = np.maximum(p[:, 1] - _KNOT[1] - 0.004, _KNOT[1] - length - p[:, 1])
    seam = 0.0007 * np.exp(-(((np.abs(across) - 0.0125) / 0.0015) ** 2))
    return 0.85 * intersect(d, end, 0.003) + seam


def belt(p):
    base = jacket_shape.smooth(p)
    h = height(p)
    outer = 0.0105 + 0.0030 * (h < 0.006)  # the second turn leaves a sliver of the first in sight
    d = intersect(np.abs(base - 0.0025) - outer + 0.0025, np.abs(h) - _HALF, 0.004)
    d = d + 0.0010 * np.exp(-(((h - 0.006) / 0.0016) ** 2))
    knot = limb(p, _KNOT + vec(-0.020, 0.006, 0.002), _KNOT + vec(0.020, -0.006, 0.002), 0.0165, 0.0165, (0, 0, 1), 0.75)
    knot = union(knot, limb(p, _KNOT + vec(-0.006, 0.016, 0.007), _KNOT + vec(0.006, -0.018, 0.007), 0.0135, 0.0150, (0, 0, 1), 0.7), 0.004)
    knot = knot + 0.0010 * np.sin(560 * (p[:, 1] + 0.4 * p[:, 0])) * (p[:, 2] > _KNOT[2])
    d = union(d, knot, 0.004)
    for lean, length, phase in ((0.070, 0.290, 0.3), (-0.056, 0.262, 1.4)):
        d = union(d, _tail(p, lean, length, phase), 0.003)
    return d
