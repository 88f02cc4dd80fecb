"""The jacket's folds: where an arm, the belt or the cloth's own length pulls it or presses it together."""
import functools

import numpy as np

from character import jacket_shape
from character.folds import Fold, Folds, between, flipped, on
from character.jacket_shape import BELT, PIT, smooth
from sdf import mirrored, ramp
from skeleton import joint, unit, vec

_SHOULDER, _ELBOW = joint("LeftArm"), joint("LeftForeArm")
_UPPER, _FORE = unit(_ELBOW - _SHOULDER), unit(joint("LeftHand") - _ELBOW)
_LONG = np.linalg.norm(_ELBOW - _SHOULDER)


@functools.cache
def folds():
    """Heights (m) over jacket_shape.smooth, as a function of points."""
    drawn = []
    for side, rng in (("Left", np.random.default_rng(3)), ("Right", np.random.default_rng(8))):
        own = _elbow(rng) + _fore_arm(rng) + _upper_arm(rng) + _arm_pit(rng) + _back(rng)
        drawn += own if side == "Left" else [flipped(fold) for fold in own]
    return Folds(smooth, *jacket_shape.BOUNDS, drawn + _waist() + _front(), lambda p: 1.3 * _free(p))


def _sleeve(way, angle):
    """Points of the left sleeve so far from the shoulder (m), and so far round it from the front upwards (rad)."""
    way, angle = np.broadcast_arrays(np.asarray(way, float), np.asarray(angle, float))
    below = (way > _LONG)[:, None]
    axis = np.where(below, _FORE, _UPPER)
    centre = np.where(below, _ELBOW + np.outer(way - _LONG, _FORE), _SHOULDER + np.outer(way, _UPPER))
    front = vec(0, 0, 1) - axis * axis[:, 2:]
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    up = np.cross(front, axis)
    return on(smooth, centre + 0.068 * (np.cos(angle)[:, None] * front + np.sin(angle)[:, None] * up))


def _elbow(rng):
    """Inside the elbow the sleeve is pressed together: folds round it that part towards its back."""
    out = []
    for off in (-0.075, -0.048, -0.023, 0.002, 0.026, 0.050, 0.076):
        spread = np.linspace(-1, 1, 11)
        lean = rng.uniform(-0.010, 0.010)
        way = _LONG + (off + rng.uniform(-0.004, 0.004)) * (1 + 0.9 * spread**2) + lean * spread
        near = np.exp(-((off / 0.07) ** 2))
        centre = rng.uniform(-0.35, 0.25)
        out.append(Fold(_sleeve(way, centre + spread * (1.1 + 0.5 * near)), 0.0030 + 0.0042 * near, 0.0085))
    return out


def _fore_arm(rng):
    """Folds that wind from the elbow's point to the cuff, which hangs from the wrist."""
    t = np.linspace(0, 1, 9)
    out = []
    for start, turn, high in ((2.5, -1.9, 0.0045), (1.2, -1.5, 0.0040), (-1.5, 1.3, 0.0036), (-2.6, 1.1, 0.0036)):
        way = _LONG + 0.045 + rng.uniform(0, 0.02) + (0.11 + rng.uniform(0, 0.02)) * t
        out.append(Fold(_sleeve(way, start + rng.uniform(-0.2, 0.2) + turn * t), high, 0.0125))
    return out


def _upper_arm(rng):
    """Folds from under the arm, up over it towards the elbow."""
    t = np.linspace(0, 1, 9)
    out = []
    for start, angle, turn, long, high in (
        (0.055, -1.2, 1.7, 0.10, 0.0055), (0.085, -1.5, 1.9, 0.10, 0.0050), (0.120, -1.3, 1.3, 0.09, 0.0040),
        (0.060, -2.0, -1.6, 0.11, 0.0055), (0.100, -2.1, -1.5, 0.10, 0.0045),
    ):  # fmt: skip
        way = start + rng.uniform(-0.01, 0.01) + long * t
        out.append(Fold(_sleeve(way, angle + turn * t + rng.uniform(-0.15, 0.15)), high, 0.0120, (0.35, 0)))
    return out


def _arm_pit(rng):
    """Folds that a fan of pulls draws from the arm pit over breast and shoulder blade."""
    out = []
    for x, y, z, high in ((0.150, 1.425, 0.085, 0.0055), (0.105, 1.385, 0.125, 0.0060), (0.085, 1.320, 0.135, 0.0058), (0.095, 1.245, 0.132, 0.0052)):
        start = vec(0.196, 1.292, 0.070) + rng.uniform(-0.008, 0.008, 3)
        out.append(Fold(between(smooth, start, (x, y, z), (0.010, -0.012, 0.01)), high, 0.0125, (0.45, 0)))
    for x, y, z, high in ((0.150, 1.425, -0.110, 0.0050), (0.090, 1.365, -0.140, 0.0060), (0.060, 1.285, -0.140, 0.0060), (0.075, 1.200, -0.130, 0.0052)):
        start = vec(0.198, 1.290, -0.085) + rng.uniform(-0.008, 0.008, 3)
        out.append(Fold(between(smooth, start, (x, y, z), (0.010, -0.012, -0.01)), high, 0.0135, (0.45, 0)))
    return out


def _back(rng):
    """Long folds from the shoulder blades down to the belt, where the back is hollow."""
    out = []
    for x, low, high in ((0.115, 0.060, 0.0062), (0.145, 0.110, 0.0055), (0.070, 0.022, 0.0048)):
        start = vec(x + rng.uniform(-0.008, 0.008), 1.245, -0.12)
        out.append(Fold(between(smooth, start, (low, 1.065, -0.11), (-0.012, 0, -0.02)), high, 0.0150, (0, 0.6)))
    return out


def _waist():
    """Cloth that the belt gathers rises from it in short folds, and is blown out over it."""
    rng = np.random.default_rng(11)
    out = []
    for k in range(22):
        angle = 2 * np.pi * (k + rng.uniform(-0.3, 0.3)) / 22
        a, b, c = jacket_shape.section(1.07)
        start = vec(np.cos(angle) * a, BELT + 0.027, c + np.sin(angle) * b)
        long, lean = rng.uniform(0.035, 0.105), rng.uniform(-0.022, 0.022)
        end = start + vec(-np.sin(angle) * lean, long, np.cos(angle) * lean)
        out.append(Fold(between(smooth, start, end, count=5), 0.0022 + 0.018 * long, 0.0135, (0.75, 0)))
    return out


def _front():
    """On the left panel, which the belt holds down: folds from the breast to the knot."""
    out = []
    for start, end, bow, high in (
        ((0.150, 1.225, 0.120), (0.055, 1.065, 0.125), (0.012, 0, 0.01), 0.0050),
        ((0.105, 1.215, 0.130), (0.030, 1.075, 0.130), (0.008, 0, 0.01), 0.0045),
        ((0.172, 1.150, 0.090), (0.105, 1.060, 0.115), (0.010, 0, 0.01), 0.0042),
        ((-0.150, 1.235, 0.115), (-0.085, 1.062, 0.120), (-0.012, 0, 0.01), 0.0050),
        ((-0.172, 1.170, 0.085), (-0.125, 1.060, 0.105), (-0.008, 0, 0.01), 0.0040),
    ):
        out.append(Fold(between(smooth, start, end, bow), high, 0.0150, (0, 0.4)))
    return out


def _free(p):
    """Held by the belt, the yoke of the shoulders and the middle of the arm pits (where folds of sleeve and trunk
    would meet), stiffened by the lapels and the cuffs."""
    q, y = mirrored(p), p[:, 1]
    belt = 1.05 * np.exp(-(((y - BELT) / 0.022) ** 2)) * (q[:, 0] < 0.25)
    shoulders = 0.8 * ramp(1.42, 1.47, y) + np.exp(-np.sum(((q - vec(0.285, 1.408, -0.01)) / vec(0.080, 0.065, 0.080)) ** 2, axis=1))
    left = np.abs(p[:, 0] - jacket_shape.lapel_centre(y))
    right = np.where(y > 1.2, np.abs(p[:, 0] + jacket_shape.lapel_centre(y)), 1)
    lapel = ramp(0.052, 0.026, np.minimum(left, right)) * (p[:, 2] > 0.03)
    cuff = 0.8 * ramp(0.13, 0.18, (q - _ELBOW) @ _FORE)
    pit = 1.3 * np.exp(-np.sum(((q - PIT) / vec(0.050, 0.058, 0.068)) ** 2, axis=1))
    return np.clip(1 - belt - shoulders - lapel - cuff - pit, 0, 1)
