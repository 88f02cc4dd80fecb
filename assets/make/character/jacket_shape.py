"""The jacket's outside without folds and openings: what its folds and the belt lie on."""
import numpy as np

from sdf import Loft, ellipsoid, intersect, limb, mirrored, union
from skeleton import joint, unit, vec

BELT = 1.035  # height
LAPEL = 0.021  # half width
BOUNDS = (-0.72, 0.69, -0.25), (0.72, 1.56, 0.24)
PIT = vec(0.220, 1.265, -0.012)  # the bottom of the left arm pit's valley
_SHOULDER, _ELBOW, _WRIST = joint("LeftArm"), joint("LeftForeArm"), joint("LeftHand")
_UPPER, FORE = unit(_ELBOW - _SHOULDER), unit(_WRIST - _ELBOW)
CUFF = _WRIST - 0.060 * FORE

_BODY = Loft(
    y=[0.70, 0.78, 0.86, 0.92, 0.98, 1.035, 1.075, 1.12, 1.20, 1.28, 1.36, 1.42, 1.47, 1.50],
    half_x=[0.235, 0.230, 0.221, 0.206, 0.183, 0.166, 0.178, 0.183, 0.187, 0.196, 0.203, 0.188, 0.130, 0.085],
    half_z=[0.184, 0.177, 0.167, 0.149, 0.129, 0.117, 0.130, 0.132, 0.133, 0.138, 0.138, 0.122, 0.092, 0.078],
    centre_z=[-0.0125, -0.012, -0.012, -0.012, -0.010, -0.002, 0.0, 0.0, 0.001, -0.003, -0.008, -0.016, -0.024, -0.026],
    power=2.5,
    smooth=21,
)


def section(y):
    """Half widths in x and z and the centre's z of the body at a height."""
    return tuple(np.interp(y, _BODY.y, table) for table in (_BODY.a, _BODY.b, _BODY.c))


def lapel_centre(y):
    """x of the middle line of the left lapel on the front; the right lapel is its mirror image."""
    return np.interp(y, [0.70, 1.06, 1.18, 1.30, 1.40, 1.47], [-0.118, -0.070, -0.022, 0.024, 0.056, 0.070])


def fore_sleeve(q):
    """The left sleeve below the elbow, not yet cut: it hangs flat from the wrist."""
    return limb(q, _ELBOW, CUFF + vec(0, -0.012, 0), 0.067, 0.073, (0, 0, 1), 0.78)


def smooth(p):
    """The signed distance from it."""
    q = mirrored(p)
    d = _BODY(p)
    d = intersect(d, p[:, 1] - 1.480, 0.05)
    d = union(d, limb(q, vec(0.055, 1.461, -0.040), vec(0.15, 1.438, -0.030), 0.045, 0.045), 0.04)  # trapezius
    arm = limb(q, vec(0.10, 1.422, -0.02), _SHOULDER + 0.02 * _UPPER, 0.0595, 0.0665)
    arm = union(arm, limb(q, _SHOULDER, _ELBOW, 0.0665, 0.0645), 0.05)
    arm = union(arm, fore_sleeve(q), 0.04)
    arm = intersect(arm, (q - CUFF) @ FORE, 0.005)
    d = union(d, arm, 0.10)
    d = union(d, ellipsoid(q, (0.085, 1.335, 0.066), (0.080, 0.070, 0.060)), 0.06)  # chest
    return union(d, ellipsoid(q, (0.085, 1.375, -0.100), (0.070, 0.085, 0.040)), 0.06)  # shoulder blades
