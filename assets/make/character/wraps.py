"""Bands of cloth wound round the shins from the ankle up, each turn over the edge of the one before, and the cords that
hold them."""
import numpy as np

from character import sheet, tabi, trousers
from character.trousers import TIE, leg_at
from mesh import Part, merge
from nets import evaluate

_LOW, _HIGH, _PITCH = 0.108, 0.424, 0.0335  # heights of the first turn and the last, m, and from turn to turn
_AROUND = 22  # vertices of a turn
# Up a band from its lower edge, in turns: heights over the one beneath (m) and tints.
_ACROSS = np.array([-0.030, 0.012, 0.10, 0.60])
_HEIGHT = np.array([-0.0004, 0.0024, 0.0028, 0.0012])
_TINT = np.array([0.50, 1.10, 1.12, 0.98])
_SLACK = 0.0050  # over the sock and its creases


def _wound(p):
    """What a cord lies on."""
    return np.minimum(tabi.foot(p) - _SLACK, trousers.smooth(p))


def _on_leg(y, angle, over, leg=tabi.foot):
    """Points so far over the skin of the left shin, at heights and angles from the front outwards (rad)."""
    y, angle, over = (v.ravel() for v in np.broadcast_arrays(y, angle, over))
    centre, out = leg_at(y), np.stack([np.sin(angle), 0 * y, np.cos(angle)], axis=1)
    near, far = np.full(len(y), 0.015), np.full(len(y), 0.12)
    for _ in range(22):
        middle = 0.5 * (near + far)
        inside = evaluate(leg, centre + middle[:, None] * out) < 0
        near, far = np.where(inside, middle, near), np.where(inside, far, middle)
    return centre + (near + over)[:, None] * out


def _winding():
    turns = (_HIGH - _LOW) / _PITCH
    count = int(turns * _AROUND)
    k = np.arange(count + 1)[:, None]
    rng = np.random.default_rng(2)
    wander = np.interp(k / _AROUND, np.arange(int(turns) + 2), rng.uniform(-0.0035, 0.0035, int(turns) + 2))
    y = _LOW + _PITCH * (k / _AROUND + _ACROSS) + wander + 0.0035 * np.sin(2 * np.pi * k / _AROUND + 0.7)
    angle = 2 * np.pi * k / _AROUND + 2.9  # it begins behind
    crease = 0.0007 * np.sin(5.1 * angle + 2.0 * _ACROSS) * np.sin(1.7 * angle + 1) * np.sin(np.pi * np.clip(_ACROSS, 0, 1))
    outer = _on_leg(y, angle, _SLACK + _HEIGHT + crease).reshape(count + 1, len(_ACROSS), 3)
    # A turn's upper edge is the next one's lower edge.
    n = len(_ACROSS)
    index = np.arange((count + 1) * n).reshape(count + 1, n)
    above = np.concatenate([index[_AROUND:, 0], np.full(_AROUND, -1)])
    rows = np.column_stack([index, above])
    a, b, c, d = rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]
    q = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
    q = q[(q >= 0).all(axis=1)]
    triangles = np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]])
    points = outer.reshape(-1, 3)
    normals = _vertex_normals(points, triangles)
    tint = np.tile(_TINT, (count + 1, 1)) * (1 + 0.05 * np.sin(3.7 * np.floor(k / _AROUND)))
    return Part("WrapsL", "GiDark", points, normals, triangles, np.repeat(tint.reshape(-1, 1), 3, axis=1))


def _vertex_normals(points, triangles):
    corner = points[triangles]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    n = np.stack([sum(np.bincount(triangles[:, k], cross[:, axis], len(points)) for k in range(3)) for axis in range(3)], axis=1)
    return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)


def _cord(y, over, half, turns=2, ends=0):
    """Flat cords round the leg, side by side; `ends`: their edges go in as far as the sock."""
    angle = np.linspace(0, 2 * np.pi, 20, endpoint=False)[:, None]
    profile = np.linspace(-1, 1, 3 * turns + 1)
    high = 0.0022 * np.sqrt(np.abs(np.sin(0.5 * np.pi * turns * (profile + 1)))) + 0.0006
    high[[0, -1]] = -0.0030 - _SLACK * ends
    slant = 0.004 * np.sin(angle + 0.6)
    outer = _on_leg(y + half * profile + slant, angle, over + high + 0 * angle, _wound).reshape(20, -1, 3)
    tint = np.tile(0.75 + 0.45 * (high > 0.0012), (20, 1))
    return sheet.shell("Cord", "Gi", outer[::-1] if _inward(outer, y) else outer, tint * 1.1, closed=True)


def _inward(outer, y):
    n = sheet.normals(outer, closed=True)
    return np.sum(n * (outer - leg_at(y))) < 0


def _knot(y, angle, over):
    """Where a cord is tied: a flat knot and its two ends."""
    pieces = []
    for lean, long in ((0.30, 0.060), (-0.45, 0.048)):
        t = np.linspace(0, 1, 5)[:, None]
        across = np.array([-0.0055, 0, 0.0055])
        outer = _on_leg(y - 0.002 - long * t + 0 * across, angle + lean * 0.8 * t**0.8 + across / 0.05, over + 0.0065 - 0.003 * t + 0 * across, _wound).reshape(5, 3, 3)
        pieces.append(sheet.slab("End", "Gi", outer[::-1] if _inward(outer, y) else outer, 0.0024)[0])
    u, v = np.linspace(0, 2 * np.pi, 8, endpoint=False)[:, None], np.linspace(-1, 1, 5)
    ring = 0.0085 * np.sqrt(np.maximum(1 - (0.93 * v) ** 4, 0))
    outer = _on_leg(y + 0.0105 * v + 0 * u, angle + ring * np.cos(u) / 0.055, over + 0.003 + 0.0062 * np.sin(u) * ring / 0.0085, _wound).reshape(8, 5, 3)
    outward = np.sum(sheet.normals(outer, True) * (outer - outer.mean(axis=(0, 1)))) > 0
    pieces.append(sheet.shell("Knot", "Gi", outer if outward else outer[::-1], closed=True))
    return pieces


def build():
    """The left leg's wraps, and its cords."""
    wraps = _winding()
    cords = [_cord(TIE, 0.0032, 0.0105), _cord(0.113, 0.0018, 0.0085, ends=1)]
    cords += _knot(TIE, 1.1, 0.0042) + _knot(0.113, 1.2, 0.0026)[2:]
    return wraps, merge("CordsL", "Gi", cords)
