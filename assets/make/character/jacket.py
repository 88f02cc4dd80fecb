"""The jacket of the gi: left over right, wide sleeves, a skirt below the belt."""
import numpy as np

import nets
from character.body import trunk
from character.cloth import ribbon, spline
from character.hanging import SLIT
from character.jacket_folds import folds
from character.jacket_shape import BELT, PIT, lapel_centre, smooth
from sdf import Loft, bump, intersect, limb, mirrored, ramp, subtract, union
from skeleton import joint, unit, vec

HEM = 0.735  # height
_SHOULDER, _ELBOW, _WRIST = joint("LeftArm"), joint("LeftForeArm"), joint("LeftHand")
_FORE = unit(_WRIST - _ELBOW)
_CUFF = _WRIST - 0.060 * _FORE
_LAPEL = 0.021  # half width
_WALL = 0.0075  # of the skirt: what the mesh can still tell from a hole

_SKIRT_CAVITY = Loft(
    y=[0.60, 0.735, 0.80, 0.86],
    half_x=[0.245, 0.240, 0.222, 0.10],
    half_z=[0.191, 0.185, 0.166, 0.06],
    centre_z=[-0.010, -0.010, -0.010, -0.012],
    power=2.5,
)


def lining(p, normals):
    """1 on the insides of sleeves and skirt, 0 outside."""
    return ramp(0.0, -0.5, np.sum(normals * nets.normals(smooth, p, 0.004), axis=1))


def give(p):
    """Over what length the cloth spreads the bend of a limb, m: a raised arm lifts the side down to the belt, and
    the skirt hangs over both thighs."""
    q = mirrored(p)
    above_elbow = ramp(0.13, -0.20, (q - _ELBOW) @ _FORE)
    side = 0.26 * bump(q, PIT, 0.225) * above_elbow
    return side + 0.05 * bump(q, _ELBOW, 0.09) + 0.15 * ramp(0.95, 0.80, p[:, 1])


def _collar(p):
    """What the lapels lie on: the jacket, running up a cone round the neck."""
    return union(smooth(p), limb(p, (0, 1.40, -0.020), (0, 1.62, -0.036), 0.084, 0.072), 0.025)


_LAPEL_PATH = nets.project(
    _collar,
    spline(
        [(0.0, 1.484, -0.102), (0.045, 1.488, -0.085), (0.074, 1.492, -0.040), (0.074, 1.478, 0.010), (0.067, 1.450, 0.042)]
        + [(lapel_centre(y), y, z) for y, z in ((1.40, 0.090), (1.34, 0.118), (1.27, 0.132), (1.20, 0.134), (1.10, 0.130))]
        + [(lapel_centre(y), y, z) for y, z in ((1.02, 0.120), (0.90, 0.140), (0.80, 0.158), (0.715, 0.170))]
    ),
    0.05,
    4,
)


def jacket(p):
    q = mirrored(p)
    height = folds()(p)
    line = p[:, 0] - lapel_centre(p[:, 1])  # > 0: on the left panel, which lies on top
    over = ramp(-_LAPEL + 0.001, -_LAPEL + 0.006, line) * ramp(0.0, 0.04, p[:, 2]) * ramp(1.33, 1.25, p[:, 1])
    under_belt = np.exp(-(((p[:, 1] - BELT) / 0.026) ** 2))  # the belt presses the lapels flat
    over = over * (1 - under_belt)
    d = _openings(p, q, smooth(p) - height - 0.0050 * over, height)
    lying = _collar(p) - 0.6 * height * ramp(1.46, 1.40, p[:, 1]) - 0.0025 + 0.0080 * under_belt
    under = ribbon(p * vec(-1, 1, 1), lying, _LAPEL_PATH, _LAPEL, 0.0058)
    under = np.where(p[:, 1] < 1.40, intersect(under, line + 0.010, 0.003), under)
    d = union(d, under, 0.006)
    d = union(d, ribbon(p, lying - 0.0050 * over, _LAPEL_PATH, _LAPEL, 0.0058), 0.006)
    d = intersect(d, _hem(p), 0.005)
    return _seams(p, q, d)


def _hem(p):
    return HEM - 0.010 * np.cos(9 * p[:, 0]) + 0.004 * np.sin(31 * p[:, 0] + 2) - p[:, 1]


def _openings(p, q, d, height):
    """Neck, front, sleeves and skirt hollowed; the hollows follow the folds, so that walls keep their thickness."""
    inner = -(trunk(p, -0.016))
    v = np.abs(p[:, 0]) - (lapel_centre(p[:, 1]) - 0.6 * _LAPEL)
    v = intersect(intersect(v, -p[:, 2] + 0.005, 0.008), 1.10 - p[:, 1], 0.01)
    d = subtract(d, intersect(v, inner, 0.004), 0.004)
    throat = limb(p, (0, 1.40, -0.020), (0, 1.62, -0.036), 0.0765, 0.0645)
    d = subtract(d, intersect(throat, inner, 0.004), 0.003)
    low, high = _WRIST - 0.15 * _FORE + vec(0, -0.006, 0), _WRIST + 0.02 * _FORE + vec(0, -0.012, 0)
    d = subtract(d, limb(q, low, high, 0.044, 0.0680, (0, 0, 1), 0.86) - 0.8 * height, 0.004)
    skirt = intersect(intersect(_SKIRT_CAVITY(p), p[:, 1] - 0.84, 0.03), smooth(p) - height + _WALL, 0.004)
    d = subtract(d, skirt, 0.004)
    slit = intersect(np.abs(p[:, 2] + 0.012) - 0.003 - 0.05 * np.maximum(SLIT - p[:, 1], 0), p[:, 1] - SLIT, 0.01)
    return subtract(d, np.where(q[:, 0] > 0.12, slit, 9.0), 0.004)


def _seams(p, q, d):
    """Grooves of stitching at hem, cuffs and shoulders."""
    d = d + 0.0014 * np.exp(-(((_hem(p) + 0.030) / 0.0035) ** 2))
    cuff = (q - _CUFF) @ _FORE
    d = d + 0.0014 * np.exp(-(((cuff + 0.030) / 0.0035) ** 2)) * (q[:, 0] > 0.40)
    armhole = (q - _SHOULDER) @ unit(vec(1, -0.25, 0)) - 0.045
    return d + 0.0016 * np.exp(-((armhole / 0.004) ** 2)) * ramp(1.30, 1.34, p[:, 1])
