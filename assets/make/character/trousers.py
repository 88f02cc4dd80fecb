"""The trousers: pleated, wide to the knee, and gathered under it where the shins are wrapped."""
import functools

import numpy as np

from character.folds import Fold, Folds, between, flipped, on
from sdf import ellipsoid, intersect, limb, mirrored, ramp, union
from skeleton import joint, vec

BOUNDS = (-0.27, 0.36, -0.20), (0.27, 1.0, 0.21)
_HIP, _KNEE, _ANKLE = joint("LeftUpLeg"), joint("LeftLeg"), joint("LeftFoot")
TIE = 0.408  # height of the cord that gathers them


def leg_at(y):
    """The middle of the left leg at a height (n,)."""
    y = np.asarray(y, float)
    t = np.clip((_KNEE[1] - y) / (_KNEE[1] - _ANKLE[1]), 0, 1)
    u = np.clip((_HIP[1] - y) / (_HIP[1] - _KNEE[1]), 0, 1)
    x = np.where(y < _KNEE[1], _KNEE[0] + t * (_ANKLE[0] - _KNEE[0]), _HIP[0] + u * (_KNEE[0] - _HIP[0]))
    z = np.where(y < _KNEE[1], _KNEE[2] + t * (_ANKLE[2] - _KNEE[2]), _HIP[2] + u * (_KNEE[2] - _HIP[2]))
    return np.stack([x, y, z], axis=-1)


def smooth(p):
    """Without folds and openings."""
    q = mirrored(p)
    d = ellipsoid(p, (0, 0.94, -0.012), (0.180, 0.105, 0.128))
    leg = limb(q, _HIP + vec(0.007, -0.02, -0.004), _KNEE + vec(0.008, 0.03, 0.000), 0.087, 0.079)
    leg = union(leg, limb(q, _KNEE + vec(0.008, 0.03, 0.000), leg_at(0.470) + vec(0.004, 0, -0.004), 0.080, 0.076), 0.02)
    leg = union(leg, limb(q, leg_at(0.470), leg_at(TIE - 0.02) + vec(0, 0, -0.008), 0.066, 0.050), 0.030)
    leg = intersect(leg, TIE - 0.022 - p[:, 1], 0.010)
    d = union(d, leg, 0.045)
    return d + 0.010 * ramp(0.66, 0.80, p[:, 1])


def _around(y, angle, radius=0.08):
    """Points of the left leg at heights, so far round it from the front outwards (rad)."""
    y, angle = np.broadcast_arrays(np.asarray(y, float), np.asarray(angle, float))
    return on(smooth, leg_at(y) + radius * np.stack([np.sin(angle), 0 * y, np.cos(angle)], axis=-1))


def _leg(rng):
    """Pleats from the waist in front, folds behind the knee and between crotch and knee, gathers over the tie."""
    t = np.linspace(0, 1, 9)
    out = []
    for angle, low, high in ((0.15, 0.53, 0.0075), (0.75, 0.60, 0.0060), (-0.55, 0.62, 0.0050), (1.7, 0.58, 0.0055), (3.0, 0.60, 0.0060)):
        out.append(Fold(_around(0.90 + t * (low - 0.90), angle + rng.uniform(-0.08, 0.08) + 0.12 * t), high, 0.0135, (0.9, 0)))
    for off in (-0.062, -0.036, -0.012, 0.014, 0.042):
        spread = np.linspace(-1, 1, 11)
        near = np.exp(-((off / 0.055) ** 2))
        y = _KNEE[1] + 0.015 - (off + rng.uniform(-0.004, 0.004)) * (1 + 0.8 * spread**2) + rng.uniform(-0.012, 0.012) * spread
        out.append(Fold(_around(y, np.pi + spread * (1.2 + 0.4 * near)), 0.0035 + 0.0045 * near, 0.0095))
    for start, turn, y0, y1, high in ((-1.3, 1.2, 0.78, 0.60, 0.0065), (-1.5, 1.5, 0.72, 0.54, 0.0055), (-1.9, -1.3, 0.76, 0.58, 0.0065), (-1.7, -1.5, 0.70, 0.53, 0.0050)):
        out.append(Fold(_around(y0 + (y1 - y0) * t, start + turn * t + rng.uniform(-0.1, 0.1)), high, 0.0140, (0.35, 0)))
    for start, turn, y0, y1, high in ((-1.0, 1.1, 0.535, 0.462, 0.0048), (0.9, -0.9, 0.530, 0.458, 0.0045), (2.0, -0.8, 0.535, 0.455, 0.0050), (-2.2, 0.9, 0.530, 0.455, 0.0048)):
        out.append(Fold(_around(y0 + (y1 - y0) * t, start + turn * t), high, 0.0110))
    count = 17
    for k in range(count):  # drawn together by the cord
        angle = 2 * np.pi * (k + rng.uniform(-0.25, 0.25)) / count
        top = rng.uniform(0.440, 0.485)
        out.append(Fold(_around(TIE + 0.004 + t[::2] * (top - TIE), angle + rng.uniform(-0.12, 0.12) * t[::2], 0.06), 0.0052, 0.0075, (0.8, 0)))
    return out


@functools.cache
def folds():
    drawn = _leg(np.random.default_rng(4)) + [flipped(fold) for fold in _leg(np.random.default_rng(9))]

    def free(p):
        between_legs = np.clip((np.abs(p[:, 0]) - 0.012) / 0.020, 0, 1)  # the legs do not touch
        return (0.75 + 0.60 * ramp(0.70, 0.62, p[:, 1])) * ramp(0.94, 0.86, p[:, 1]) * between_legs

    return Folds(smooth, *BOUNDS, drawn, free)


def trousers(p):
    return intersect(smooth(p) - folds()(p), p[:, 1] - 0.93, 0.02)


def paint(part):
    """Hollows keep their dye, ridges lose it."""
    part.colors *= np.clip(1 + 24 * folds()(part.points), 0.70, 1.22)[:, None]
