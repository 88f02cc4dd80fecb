"""Tabi: socks of cloth with a split between the great toe and the others, on a dark sole."""
import numpy as np

from character.cloth import crumple
from sdf import ellipsoid, intersect, limb, ramp, tube, union
from skeleton import joint, vec

_SOLE = 0.0060  # height of its edge, m
_ANKLE, _BALL = joint("LeftFoot"), joint("LeftToeBase")
_AXIS = _ANKLE + vec(0, 0.03, -0.004)


def _toes(p):
    """The great toe and, beside it, the others in one pocket."""
    great = tube(p, [_BALL + vec(-0.034, -0.002, 0.004), _BALL + vec(-0.038, -0.0035, 0.040), _BALL + vec(-0.037, -0.0050, 0.060)], [0.0165, 0.0155, 0.0150])
    others = limb(p, _BALL + vec(0.000, -0.004, 0.000), _BALL + vec(0.0005, -0.0065, 0.0540), 0.0150, 0.0130)
    others = union(others, limb(p, _BALL + vec(0.018, -0.005, 0.000), _BALL + vec(0.0180, -0.0075, 0.0440), 0.0145, 0.0122), 0.012)
    others = union(others, limb(p, _BALL + vec(0.032, -0.006, -0.004), _BALL + vec(0.0350, -0.0085, 0.0280), 0.0140, 0.0115), 0.012)
    return great, others


def foot(p):
    """The left foot in its sock, and the shin to below the knee."""
    knee, ankle, ball = joint("LeftLeg"), _ANKLE, _BALL
    d = limb(p, knee + vec(0, -0.02, 0), ankle + vec(0, 0.03, 0), 0.056, 0.039)
    d = union(d, ellipsoid(p, knee * 0.7 + ankle * 0.3 + vec(0.004, 0, -0.022), (0.050, 0.11, 0.045)), 0.04)
    d = union(d, limb(p, ankle + vec(0, 0.10, -0.026), ankle + vec(0, -0.035, -0.043), 0.014, 0.019), 0.03)  # tendon
    d = union(d, limb(p, ankle + vec(0, 0.03, 0), ankle + vec(0, -0.012, -0.005), 0.038, 0.037), 0.03)
    d = union(d, ellipsoid(p, ankle + vec(-0.002, -0.047, -0.042), (0.033, 0.036, 0.037)), 0.03)  # heel
    d = union(d, limb(p, ankle + vec(-0.004, -0.010, 0.028), ball + vec(-0.010, 0.015, -0.012), 0.036, 0.024, (0, 1, 0), 0.9), 0.035)
    d = union(d, limb(p, ankle + vec(0.012, -0.056, -0.03), ball + vec(0.024, 0.000, -0.012), 0.025, 0.020), 0.03)
    d = union(d, limb(p, ankle + vec(-0.012, -0.046, 0.02), ball + vec(-0.030, 0.000, 0.0), 0.022, 0.021), 0.03)
    d = union(d, ellipsoid(p, ankle + vec(0.035, -0.004, -0.006), (0.009, 0.014, 0.012)), 0.02)  # malleoli
    d = union(d, ellipsoid(p, ankle + vec(-0.035, 0.006, 0.002), (0.008, 0.014, 0.012)), 0.02)
    great, others = _toes(p)
    # The pockets meet in a seam that runs up from the split.
    return union(d, np.minimum(union(d, great, 0.012), union(d, others, 0.014)), 0.004)


def _creases(p):
    """Rings over the ankle, where the foot bends, and creases over the ball and at the split."""
    v = p - _AXIS
    a = np.arctan2(v[:, 0], v[:, 2])
    up = p[:, 1] + 0.30 * v[:, 2]
    out = np.zeros(len(p))
    for height, tilt, tall, width in ((0.150, 0.006, 0.0022, 0.0055), (0.131, -0.006, 0.0030, 0.0060), (0.112, 0.005, 0.0032, 0.0060), (0.094, -0.004, 0.0022, 0.0055)):
        t = (up - height - tilt * np.sin(a + 0.5) - 0.002 * np.sin(3 * a + 60 * height)) / width
        out = np.maximum(out, tall * (0.7 + 0.3 * np.cos(2 * a + 90 * height)) * np.exp(-((t / np.where(t > 0, 1.4, 0.8)) ** 2)))
    ahead = p[:, 2] - _BALL[2]
    for at, tall in ((-0.012, 0.0013), (0.002, 0.0015), (-0.028, 0.0010)):
        t = (ahead - at - 0.15 * (p[:, 0] - _BALL[0]) - 0.002 * np.sin(150 * p[:, 0])) / 0.0050
        out = np.maximum(out, tall * np.exp(-(t**2)) * ramp(0.015, 0.030, p[:, 1]) * ramp(0.07, 0.05, p[:, 1]))
    return out + 0.0005 * crumple(p, 0.6, 3.0)


def _seam(p):
    """The seam from the split over the instep, and the one behind the heel."""
    line = np.interp(p[:, 2], [0.02, 0.10, 0.16], [0.117, 0.109, 0.1095])
    return 0.0011 * np.exp(-(((p[:, 0] - line) / 0.0016) ** 2)) * ramp(0.02, 0.04, p[:, 2]) * (p[:, 1] > 0.02)


def tabi(p):
    """The left sock, cut inside the trouser leg, down into the sole."""
    d = foot(p) - _creases(p) * ramp(0.010, 0.022, p[:, 1]) + _seam(p)
    d = intersect(d, p[:, 1] - 0.26, 0.003)
    return intersect(d, 0.0035 - p[:, 1], 0.002)


def sole(p):
    """The left sole: it lies on the floor, and its edge stands out a little round the foot."""
    low = p * np.array([1, 0, 1]) + np.array([0, 0.0085, 0])
    outline = foot(low) - 0.0006
    return intersect(outline, np.abs(p[:, 1] - 0.5 * _SOLE) - 0.5 * _SOLE, 0.0022)
