"""The trousers of the gi."""
import numpy as np

from cloth import Folds, crumple
from sdf import ellipsoid, intersect, limb, mirrored, ramp, subtract, union
from skeleton import joint, vec

_HIP, _KNEE, _ANKLE = joint("LeftUpLeg"), joint("LeftLeg"), joint("LeftFoot")


def smooth(p, grow=0.0):
    q = mirrored(p)
    d = ellipsoid(p, (0, 0.94, -0.012), (0.182 + grow, 0.105 + grow, 0.128 + grow))
    leg = limb(q, _HIP + vec(0.004, -0.02, -0.004), _KNEE + vec(0.006, 0, 0), 0.102 + grow, 0.084 + grow)
    leg = union(leg, limb(q, _KNEE + vec(0.006, 0, 0), _ANKLE + vec(0.006, 0.02, -0.006), 0.084 + grow, 0.096 + grow), 0.08)
    leg = intersect(leg, hem_height(q) - q[:, 1] - grow, 0.005)
    d = union(d, leg, 0.06)
    return d + 0.016 * ramp(0.66, 0.80, p[:, 1])


def hem_height(q):
    return 0.116 - 0.06 * (q[:, 2] + 0.02)


def _folds():
    f = Folds()
    for s, seed in ((1, 0.0), (-1, 2.1)):
        m = vec(s, 1, 1)
        f.rings(m * (_KNEE + vec(0, 0.0, 0)), (0, 1, 0), m * vec(0.15, 0, -1), 0.088, 0.040, 4, 0.011, 0.0090, seed=seed)
        f.rings(m * (_KNEE + vec(0, -0.06, 0)), (0, 1, 0), m * vec(0.4, 0, 1), 0.088, 0.055, 3, 0.013, 0.0065, lean=0.9, seed=seed + 1)
        f.rings(m * (_ANKLE + vec(0.006, 0.105, -0.006)), (0, 1, 0), m * vec(-0.2, 0, 1), 0.094, 0.036, 3, 0.012, 0.0090, lean=0.9, seed=seed + 2)
        f.rings(m * (_ANKLE + vec(0.006, 0.115, -0.006)), (0, 1, 0), m * vec(0.6, 0, -0.8), 0.094, 0.040, 3, 0.012, 0.0090, lean=0.9, seed=seed + 3)
        f.fan(m * vec(0.035, 0.800, 0.085), [m * vec(*a) for a in ((0.16, 0.83, 0.08), (0.17, 0.74, 0.08), (0.15, 0.64, 0.09), (0.10, 0.58, 0.10))], 0.014, 0.0060, seed=seed)
        f.fan(m * vec(0.035, 0.800, -0.105), [m * vec(*a) for a in ((0.16, 0.84, -0.09), (0.17, 0.73, -0.09), (0.14, 0.62, -0.09))], 0.014, 0.0065, seed=seed + 1)
        f.ridge(m * vec(0.16, 0.66, 0.04), m * vec(0.18, 0.40, 0.03), 0.014, 0.0050)
        f.ridge(m * vec(0.12, 0.44, 0.095), m * vec(0.15, 0.20, 0.085), 0.014, 0.0065)
    return f


_FOLDS = _folds()


def trousers(p):
    q = mirrored(p)
    d = smooth(p) - _FOLDS(p) - 0.0018 * crumple(p, 1.3, 2.0)
    d = intersect(d, p[:, 1] - 0.93, 0.02)
    inside = limb(q, _ANKLE + vec(0.006, 0.12, -0.006), _ANKLE + vec(0.006, -0.12, -0.006), 0.056, 0.090)
    d = subtract(d, inside, 0.004)
    return d + 0.0014 * np.exp(-(((q[:, 1] - hem_height(q) - 0.032) / 0.0038) ** 2))
