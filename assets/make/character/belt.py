"""The belt: two turns round the waist, a flat knot, two hanging tails; sewn along in rows."""
import numpy as np

from character import jacket_shape, sheet, skirt
from mesh import merge, sculpt
from sdf import intersect, limb, union
from skeleton import vec

_HALF = 0.0205
_KNOT = vec(0.0, 1.026, 0.142)
_ROWS = np.array([-0.0135, -0.0045, 0.0045, 0.0135])  # where it is sewn, m across
_GROOVE = 0.0011
_STIFF = 0.6  # 1: a cylinder, 0: as the cloth under it


def _across(half):
    """Places across, from edge to edge, and the height and the tint there."""
    near = np.concatenate([[-half, -half + 0.0016], *[[row - 0.0017, row, row + 0.0017] for row in _ROWS], [half - 0.0016, half]])
    sewn = np.isin(near, _ROWS)
    edge = np.abs(near) == half
    return near, -_GROOVE * sewn - 0.0008 * edge, np.where(sewn, 0.55, np.where(edge, 1.15, 1.0))


def _turns():
    """Round the waist: the second turn leaves a sliver of the first in sight."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)[:, None]
    v, high, tint = _across(_HALF)
    places = np.concatenate([[-_HALF], v - 0.002, [v[-1] - 0.0016, _HALF, _HALF]])
    over = np.concatenate([[-0.004], 0.0088 + high, [0.0060, 0.0055, -0.004]])
    tint = np.concatenate([[0.6], tint, [0.55, 1.0, 0.6]])
    pull = 0.0012 * np.sin(3 * angle + 1) + 0.0008 * np.sin(7 * angle)
    y = np.full((len(angle), len(places)), jacket_shape.BELT)
    for _ in range(4):  # it dips in front
        y = jacket_shape.BELT - 0.06 * skirt.around(angle + 0 * y, y)[..., 2] + places + pull
    flat = y - _STIFF * (places + pull)  # it hardly flares with the hips
    on = skirt.around(angle + 0 * y, flat) * (1, 0, 1) + y[..., None] * (0, 1, 0)
    out = np.cross(skirt.around(angle + 0 * y, flat) - skirt.around(angle - 1e-3 + 0 * y, flat), (0, 1, 0))
    out /= np.linalg.norm(out, axis=2, keepdims=True)
    out *= np.sign(np.sum(out * (on - [0, 0, -0.01]) * [1, 0, 1], axis=2, keepdims=True))
    return sheet.shell("Turns", "Belt", on + out * over[None, :, None], np.tile(tint, (len(angle), 1)), closed=True)


def _tail(lean, length, phase):
    t = np.linspace(0, 1, 12)[:, None]
    v, high, tint = _across(0.0190)
    x = lean * t**0.8 + np.sign(lean) * 0.008
    z = _KNOT[2] + 0.008 + 0.030 * np.sin(1.7 * t) + 0.004 * np.sin(7 * t + phase)
    twist = 0.35 * np.sin(3 * t + phase)
    cos, sin = np.cos(twist), np.sin(twist)
    bend = 0.0018 * (1 - (v / 0.019) ** 2) * np.sin(5 * t + phase)  # it is not quite flat
    y = _KNOT[1] - length * t

    def grid(high):
        return np.stack([x + v * cos - high * sin, y + 0 * v, z + v * sin + high * cos], axis=-1)[::-1].swapaxes(0, 1)

    end = np.where(np.abs(1 - t - 0.03) < 0.03, 1.12, 1.0)
    return sheet.slab("Tail", "Belt", grid(0.0030 + bend + high), 0.0058, (tint * end)[::-1].T, plain=grid(0.0030 + bend))[0]


def _knot(p):
    d = limb(p, _KNOT + vec(-0.020, 0.006, 0.002), _KNOT + vec(0.020, -0.006, 0.002), 0.0165, 0.0165, (0, 0, 1), 0.72)
    over = limb(p, _KNOT + vec(-0.007, 0.017, 0.007), _KNOT + vec(0.007, -0.019, 0.007), 0.0130, 0.0150, (0, 0, 1), 0.62)
    line = (p - _KNOT) @ vec(0.93, 0.37, 0)  # across the turn that lies over the knot
    over = over + 0.0011 * sum(np.exp(-(((line - row) / 0.0014) ** 2)) for row in (-0.0065, 0.0, 0.0065))
    return intersect(union(d, over, 0.002), _KNOT[2] - 0.020 - p[:, 2], 0.003)


def build():
    knot = sculpt("Knot", "Belt", _knot, _KNOT - 0.055, _KNOT + 0.055, 0.0022, 380, 0.02)
    tails = [_tail(0.070, 0.299, 0.3), _tail(-0.056, 0.262, 1.4)]
    return merge("Belt", "Belt", [_turns(), knot, *tails])
