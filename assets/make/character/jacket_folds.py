"""Where the jacket's cloth is too large, and where it is held: what makes its folds."""
import functools

import numpy as np

from character import jacket_shape
from character.wrinkle import Wrinkles
from sdf import mirrored, ramp
from skeleton import joint, unit, vec

_SHOULDER, _ELBOW = joint("LeftArm"), joint("LeftForeArm")
_UPPER, _FORE = unit(_ELBOW - _SHOULDER), unit(joint("LeftHand") - _ELBOW)


@functools.cache
def folds():
    """Heights (m) over jacket_shape.smooth, as a function of points."""
    return Wrinkles(jacket_shape.smooth, *jacket_shape.BOUNDS, 0.010, _growth, _loose)


def _bell(x, centre, width):
    return np.exp(-(((x - centre) / width) ** 2))


def _growth(p, d):
    """Sleeves are too long, most at the elbow; the skirt is too wide at its hem; the trunk has folds that
    run down to the belt's knot in front and from the arm pits to the spine behind, and blouses over the belt."""
    q, y = mirrored(p), p[:, 1]
    on_sleeve = ramp(0.17, 0.24, q[:, 0]) * ramp(-0.02, 0.06, (q - _SHOULDER) @ _UPPER)
    below_elbow = (q - _ELBOW) @ _FORE
    axis = np.where(below_elbow[:, None] > 0, _FORE, _UPPER) * np.stack([np.sign(p[:, 0]), 1 + 0 * y, 1 + 0 * y], 1)
    along = np.sum(axis * d, axis=1) ** 2
    sleeve = (0.20 + 0.32 * _bell(below_elbow, 0, 0.08)) * along + 0.05 * (1 - along)

    tall = d[:, 1] ** 2
    round_trunk = np.stack([p[:, 2] + 0.010, 0 * y, -p[:, 0]], axis=1)
    round_trunk /= np.linalg.norm(round_trunk, axis=1, keepdims=True) + 1e-9
    to_left = np.sum(d * round_trunk, axis=1) * np.sign(round_trunk[:, 0])
    slant = np.where(p[:, 2] > 0, 0.45, -0.55 * np.tanh(p[:, 0] / 0.05))
    across_fold = (to_left - slant * d[:, 1]) ** 2 / (1 + slant**2)
    above = 0.110 * ramp(1.46, 1.34, y) * across_fold + 0.10 * _bell(y, 1.075, 0.035) * tall
    skirt = 0.02 * tall + (0.05 + 0.25 * ramp(1.02, 0.80, y)) * (1 - tall)
    return sleeve * on_sleeve + np.where(y > jacket_shape.BELT, above, skirt) * (1 - on_sleeve)


def _loose(p):
    """Held by the belt, the shoulders and the arm pits (where folds of sleeve and trunk would meet), stiffened by the lapels and the cuffs."""
    q, y = mirrored(p), p[:, 1]
    belt = 1.05 * _bell(y, jacket_shape.BELT, 0.024) * (q[:, 0] < 0.25)
    shoulders = 0.75 * ramp(1.42, 1.49, y)
    left = np.abs(p[:, 0] - jacket_shape.lapel_centre(y))
    right = np.where(y > 1.2, np.abs(p[:, 0] + jacket_shape.lapel_centre(y)), 1)
    lapel = 0.95 * ramp(0.060, 0.030, np.minimum(left, right)) * (p[:, 2] > 0.03)
    cuff = 0.5 * ramp(0.14, 0.20, (q - _ELBOW) @ _FORE)
    pit = 1.5 * np.exp(-np.sum(((q - jacket_shape.PIT) / vec(0.055, 0.055, 0.10)) ** 2, axis=1))
    free = np.clip(1 - belt - shoulders - lapel - cuff - pit, 0, 1)
    return -0.006 * free, (0.014 + 0.006 * ramp(0.98, 0.80, y)) * free
