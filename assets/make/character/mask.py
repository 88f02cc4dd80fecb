"""The mask: a length of cloth wound over nose, cheeks, chin and neck, and tucked into the collar.

Its mesh is a net of rows and columns, so that rows lie along the edges of its turns.
"""
import numpy as np
from scipy.interpolate import PchipInterpolator

from character import head, hood
from character.cloth import crumple
from decimate import decimate
from mesh import Part, normals_of
from nets import evaluate
from sdf import ramp

_LAYER = 0.0020  # by which a turn of the cloth lies over the one below, m
_LINING = 0.022  # how far down the cloth's inside is made, m
_COLUMNS = 120
_BUDGET = 1750  # vertices

# The upper edges of the turns: heights by the angle from the front to the left, rad; m. The first bounds the slit.
_EDGES = (
    ([-3.15, -2.2, -1.57, -1.2, -0.91, -0.62, -0.35, -0.13, 0.0, 0.13, 0.35, 0.62, 0.91, 1.2, 1.57, 2.2, 3.15],
     [1.622, 1.646, 1.659, 1.654, 1.6440, 1.6345, 1.6325, 1.6400, 1.6440, 1.6405, 1.6325, 1.6335, 1.6425, 1.652, 1.657, 1.646, 1.622]),
    ([-3.15, -2.2, -1.4, -0.9, -0.5, 0.0, 0.5, 0.9, 1.4, 2.2, 3.15], [1.598, 1.628, 1.632, 1.622, 1.610, 1.594, 1.580, 1.577, 1.580, 1.590, 1.598]),
    ([-3.15, -2.2, -1.4, -0.8, 0.0, 0.8, 1.4, 2.2, 3.15], [1.572, 1.548, 1.536, 1.534, 1.541, 1.553, 1.560, 1.568, 1.572]),
)

_LINES = [PchipInterpolator(*line) for line in _EDGES]
# Where the cloth ends, in the collar and behind the lapels.
_END = PchipInterpolator([-3.15, -1.0, -0.55, 0, 0.55, 1.0, 3.15], [1.452, 1.440, 1.31, 1.29, 1.31, 1.440, 1.452])
# Rows of the net across an edge, by height over it, m: the crease below it is that of the turn below.
_ACROSS = (0.0016, 0.0002, -0.0009, -0.0035, -0.0072, -0.0092, -0.0120)

# Folds: angle and height where they start and end, by how much they bow, height and half width; rad, m.
_FOLDS = (
    (0.14, 1.6240, 2.10, 1.6430, -0.006, 0.0026, 0.0075),
    (0.20, 1.6080, 2.30, 1.6260, -0.008, 0.0038, 0.0090),
    (0.06, 1.5850, 2.20, 1.6060, -0.010, 0.0027, 0.0095),
    (0.45, 1.5680, 2.40, 1.5860, -0.008, 0.0024, 0.0085),
    (-0.12, 1.6270, -2.10, 1.6450, -0.005, 0.0028, 0.0075),
    (-0.20, 1.6130, -2.20, 1.6350, -0.009, 0.0036, 0.0090),
    (-0.08, 1.5830, -2.30, 1.6130, -0.011, 0.0036, 0.0100),
    (-0.38, 1.5660, -2.20, 1.5870, -0.009, 0.0030, 0.0085),
)
# Rings round the neck: height, by how much they are lower in front and on the left, height and half width, m.
_RINGS = (
    (1.5360, 0.010, 0.006, 0.0024, 0.0120),
    (1.5070, 0.014, -0.005, 0.0026, 0.0125),
)


def _roll(t):
    """A fold across: it leans down and is undercut."""
    return np.exp(-((t / np.where(t > 0, 1.40, 0.85)) ** 2))


def _folds(p, a):
    y, out = p[:, 1], np.zeros(len(p))
    for start, low, end, high, bow, height, width in _FOLDS:
        t = (a - start) / (end - start)
        line = low + (high - low) * t + bow * 4 * t * (1 - t) + 0.0012 * np.sin(9 * a + 40 * low)
        out += (1.3 * height * ramp(0, 0.25, t) * ramp(1, 0.60, t) * _roll((y - line) / width)) ** 4
    for middle, front, left, height, width in _RINGS:
        line = middle - 0.5 * front * (1 + np.cos(a)) - left * np.sin(a) + 0.0020 * np.sin(3 * a + 90 * middle)
        uneven = 0.75 + 0.25 * np.sin(2 * a + 130 * middle)
        out += (height * uneven * _roll((y - line) / width)) ** 4
    return out**0.25  # nearly the highest


def edge(p, turn=0):
    """Height over the upper edge of a turn."""
    return p[:, 1] - _LINES[turn](hood.around(p))


def _outside(p, folded=True):
    a = hood.around(p)
    over_hood = 0.0030 * ramp(0.75, 1.15, np.abs(a)) * (0.4 * ramp(1.44, 1.50, p[:, 1]) + 0.6 * ramp(1.545, 1.585, p[:, 1]))
    collar = 0.004 * ramp(1.505, 1.480, p[:, 1])  # the collar presses it flat
    d = np.minimum(hood.form(p), hood.scalp(p) + 0.0042) - 0.0036 - over_hood + collar
    if not folded:
        return d
    top = -edge(p)
    d = d - _folds(p, a) * ramp(0.002, 0.012, top) - 0.0005 * crumple(p, 0.7, 1.0) - hood.hem(top)
    for turn in range(1, len(_EDGES)):
        below = -edge(p, turn)
        d = d - (_LAYER + 0.6 * hood.hem(below)) * ramp(-0.0004, 0.0006, below)
    return d


def _inside(p):
    return _outside(p, folded=False) + hood.CLOTH


def _rows(angles):
    """Heights (rows, columns) of the net from the lining's end over the rim to the cloth's end, and which field each
    row lies on: the inside, between both, the outside, or below the skin, which leaves no sight past it."""
    rim, *turns = (line(angles) for line in _LINES)
    heights = [rim + up for up in (-_LINING, -_LINING, -0.010, -0.0012, 0.0, -0.0012, -0.0035, -0.0072, -0.0092, -0.0120)]
    kinds = [3, 0, 0, 0, 1] + [2] * 5
    for line in turns:
        above, below = heights[-1], line + _ACROSS[0]
        heights += [above + (below - above) * t for t in np.linspace(0, 1, 10)[1:-1]]
        heights += [line + up for up in _ACROSS]
    heights += [heights[-1] - 0.0026 * k for k in range(1, 16)]
    above = heights[-1]
    heights += [above + (_END(angles) - above) * t for t in np.linspace(0, 1, 7)[1:]]
    return np.array(heights), kinds + [2] * (len(heights) - len(kinds))


def _reach(field, angles, heights):
    """Where rays from the axis at those angles and heights meet a field from outside."""
    ray = np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=-1)
    middle = np.stack([np.zeros_like(heights), heights, np.full_like(heights, hood.AXIS)], axis=-1)
    near, far = np.full(len(angles), 0.02), np.full(len(angles), 0.30)
    for _ in range(24):  # to 0.02 um
        half = 0.5 * (near + far)
        out = evaluate(field, middle + half[:, None] * ray) > 0
        near, far = np.where(out, near, half), np.where(out, half, far)
    return middle + near[:, None] * ray


def _detail(p):
    """Where errors count more: above the collar, and in front."""
    return (1 - 0.7 * ramp(1.50, 1.47, p[:, 1])) * (1 - 0.4 * ramp(1.4, 2.0, np.abs(hood.around(p))))


def build():
    """The mask as a part, unweighted."""
    u = (np.arange(_COLUMNS) + 0.5) / _COLUMNS * 2 - 1
    angles = np.pi * (0.72 * u + 0.28 * u**3)  # closer in front
    heights, kinds = _rows(angles)
    fields = (_inside, lambda p: _inside(p) - 0.6 * hood.CLOTH, _outside, lambda p: head.head(p) + 0.002)
    points = np.stack([_reach(fields[kind], angles, row) for kind, row in zip(kinds, heights)])
    rows, n = len(heights), _COLUMNS
    number = np.arange(rows * n).reshape(rows, n)
    a, b = number[:-1], number[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    points, triangles = decimate(points.reshape(-1, 3), triangles, _BUDGET, 0.014, _detail)
    return Part("Mask", "Gi", points, normals_of(_outside, points, triangles, 0.0020), triangles)


def cover(p):
    """What hides the hood: the outside below the rim."""
    return np.maximum(_outside(p, folded=False), edge(p) + 0.014)
