"""The trousers of the gi."""
import functools

import numpy as np

from character.wrinkle import Wrinkles
from sdf import ellipsoid, intersect, limb, mirrored, ramp, subtract, union
from skeleton import joint, vec

BOUNDS = (-0.27, 0.08, -0.20), (0.27, 1.0, 0.21)
_HIP, _KNEE, _ANKLE = joint("LeftUpLeg"), joint("LeftLeg"), joint("LeftFoot")


def smooth(p):
    """Without folds and openings."""
    q = mirrored(p)
    d = ellipsoid(p, (0, 0.94, -0.012), (0.182, 0.105, 0.128))
    leg = limb(q, _HIP + vec(0.013, -0.02, -0.004), _KNEE + vec(0.008, 0, 0), 0.096, 0.082)
    leg = union(leg, limb(q, _KNEE + vec(0.008, 0, 0), _ANKLE + vec(0.006, 0.02, -0.006), 0.082, 0.099), 0.02)
    d = union(d, intersect(leg, _above_hem(q), 0.005), 0.045)
    return d + 0.008 * ramp(0.66, 0.80, p[:, 1])


def _above_hem(q):
    return 0.116 - 0.06 * (q[:, 2] + 0.02) - q[:, 1]


@functools.cache
def _folds():
    def growth(p, d):
        """Too long behind the knee and in front over the shin, too wide towards the hem."""
        y, tall = p[:, 1], d[:, 1] ** 2
        knee = np.exp(-(((y - _KNEE[1] - 0.02) / 0.11) ** 2)) * ramp(0.04, -0.05, p[:, 2])
        shin = np.exp(-(((y - 0.24) / 0.10) ** 2))
        thigh = np.exp(-(((y - 0.70) / 0.10) ** 2))
        return (0.02 + 0.14 * knee + 0.09 * shin + 0.05 * thigh) * tall + (0.06 + 0.06 * ramp(0.5, 0.1, y)) * (1 - tall)

    def loose(p):
        free = ramp(0.92, 0.84, p[:, 1])
        between = np.clip(np.abs(p[:, 0]) - 0.009, 0, 0.013)  # the legs do not touch
        return -0.006 * free, between * free

    return Wrinkles(smooth, *BOUNDS, 0.010, growth, loose, seed=2)


def trousers(p):
    q = mirrored(p)
    height = _folds()(p)
    d = intersect(smooth(p) - height, p[:, 1] - 0.93, 0.02)
    inside = limb(q, _ANKLE + vec(0.006, 0.12, -0.006), _ANKLE + vec(0.006, -0.12, -0.006), 0.058, 0.095)
    d = subtract(d, inside - 0.8 * height, 0.004)
    return d + 0.0014 * np.exp(-(((_above_hem(q) + 0.032) / 0.0038) ** 2))
