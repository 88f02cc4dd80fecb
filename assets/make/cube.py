"""The rope drop's cube of 1.2 m, open to +z and +x, ruled every 0.1 m, and the bracket in its centre.

The floor's top is y = 0, the back wall's face z = -0.6; the bracket ends in a ball at (0, 0.6, 0), to
which the rope is tied.
"""
import numpy as np

from lathe import box, revolve
from mesh import Part

SIDE = 1.2  # m
_HALF = SIDE / 2
_BAR, _LINE, _THICK = 0.016, 0.0016, 0.012


def _pile(name, material, boxes):
    """boxes: (centre, size, bevel) each."""
    pieces, count = [], 0
    for centre, size, bevel in boxes:
        points, normals, triangles = box(np.asarray(centre, float), size, bevel)
        pieces.append((points, normals, triangles + count))
        count += len(points)
    return Part(name, material, *[np.concatenate(a) for a in zip(*pieces)])


def _card():
    """Floor, back wall and the wall on the left; each a grid of tiles, so that light can vary on it."""
    tiles = []
    at = np.arange(-_HALF + 0.05, _HALF, 0.1)
    for u in at:
        for v in at:
            tiles.append(((u, -_THICK / 2, v), (0.1, _THICK, 0.1), 0))
            tiles.append(((u, v + _HALF, -_HALF - _THICK / 2), (0.1, 0.1, _THICK), 0))
            tiles.append(((-_HALF - _THICK / 2, v + _HALF, u), (_THICK, 0.1, 0.1), 0))
    part = _pile("Card", "Card", tiles)
    return _cornered(_inward(part))


def _inward(part):
    """Only the faces that look into the cube."""
    centre = np.array([0, _HALF, 0])
    corners = part.points[part.triangles]
    middle = corners.mean(axis=1)
    normal = part.normals[part.triangles[:, 0]]
    inside = np.all(np.abs(middle - centre) < _HALF + 1e-6, axis=1)
    keep = part.triangles[inside & (np.sum((centre - middle) * normal, axis=1) > 0)]
    used, triangles = np.unique(keep, return_inverse=True)
    return Part(part.name, part.material, part.points[used], part.normals[used], triangles.reshape(-1, 3))


def _cornered(part):
    """Darker towards the corners, where the walls take light from one another."""
    p = part.points
    light = np.ones(len(p))
    for d in (p[:, 1], p[:, 2] + _HALF, p[:, 0] + _HALF):
        light *= np.where(d > 1e-4, 1 - 0.30 * np.exp(-np.maximum(d, 0) / 0.16), 1)
    part.colors = part.colors * light[:, None]
    return part


def _lines():
    """A rule every 0.1 m on floor and walls, standing a hair before them."""
    boxes = []
    for k in range(1, 12):
        u, thin = -_HALF + 0.1 * k, 0.0006
        for centre, size in (
            ((u, 0, 0), (_LINE, thin, SIDE)),
            ((0, 0, u), (SIDE, thin, _LINE)),
            ((u, _HALF, -_HALF), (_LINE, SIDE, thin)),
            ((0, u + _HALF, -_HALF), (SIDE, _LINE, thin)),
            ((-_HALF, _HALF, u), (thin, SIDE, _LINE)),
            ((-_HALF, u + _HALF, 0), (thin, _LINE, SIDE)),
        ):
            boxes.append((centre, size, 0))
    return _pile("Lines", "Ink", boxes)


def _edges():
    boxes, s = [], _HALF
    for a in (-s, s):
        for b in (-s, s):
            boxes.append(((0, a + s, b), (SIDE + _BAR, _BAR, _BAR), 0.002))
            boxes.append(((a, s, b), (_BAR, SIDE - _BAR, _BAR), 0.002))
            boxes.append(((a, b + s, 0), (_BAR, _BAR, SIDE - _BAR), 0.002))
    return _pile("Edges", "FrameWood", boxes)


def build():
    return [_card(), _lines(), _edges()]


def bracket():
    """A rod from the back wall, and the ball at its end."""
    rod = revolve("Rod", "Steel", [(0, 0), (0.022, 0), (0.022, 0.006), (0.0045, 0.010), (0.0045, _HALF)], 24)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 17)
    ball = revolve("Ball", "Brass", np.stack([0.011 * np.cos(angle).clip(0), 0.011 * np.sin(angle)], axis=1), 24)
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)  # y to z
    rod.points = rod.points @ turn.T + (0, _HALF, -_HALF)
    rod.normals = rod.normals @ turn.T
    ball.points = ball.points + (0, _HALF, 0)
    return [rod, ball]
