"""The dojo: plank floor, shoji walls on three sides, posts, lintel, beams and plaster.

The floor's top is y = 0 and the stage is around the origin; the back wall stands at z = -2.6, the side
walls at x = +-4.2. Cameras look from the open side, +z.
"""
import numpy as np

from lathe import box
from mesh import Part

BACK, SIDE, FRONT, CEILING = -2.6, 4.2, 6.0, 3.3
_BAY = 1.2  # width of a shoji panel
_LINTEL = 2.12


class _Pile:
    """Boxes of one material, each with its own tone."""

    def __init__(self, name, material):
        self.name, self.material, self.boxes, self.count = name, material, [], 0

    def add(self, centre, size, bevel=0.003, tone=(1, 1, 1), shown=None):
        """shown: normal (n, 3) -> bool (n,), which faces anybody can see."""
        points, normals, triangles = box(np.asarray(centre, float), size, bevel)
        if shown:
            triangles = triangles[shown(normals[triangles[:, 0]])]
            used, triangles = np.unique(triangles, return_inverse=True)
            points, normals, triangles = points[used], normals[used], triangles.reshape(-1, 3)
        self.boxes.append((points, normals, triangles + self.count, np.tile(np.asarray(tone, float), (len(points), 1))))
        self.count += len(points)

    def part(self):
        arrays = [np.concatenate(a) for a in zip(*self.boxes)]
        return Part(self.name, self.material, *arrays)


def _floor():
    planks, rng = _Pile("Floor", "Floor"), np.random.default_rng(3)
    width = 0.15
    for x in np.arange(-SIDE - width, SIDE + width, width):
        z = BACK - 0.3 - 1.8 * rng.random()
        while z < FRONT:
            length = 1.8
            tone = 0.80 + 0.30 * rng.random()
            warm = 1 + 0.10 * (rng.random() - 0.5)
            planks.add((x + width / 2, -0.0125, z + length / 2), (width - 0.0008, 0.025, length - 0.0010), 0.0014, (tone, tone * warm, tone * warm**2), lambda n: n[:, 1] > 0.1)
            z += length
    return planks.part()


def _shoji(frame, paper, where, along, count, first):
    """A row of panels. where(u, y, depth) -> point; along: 0 if the wall runs along x, 2 along z."""

    def size(u, y, depth):
        return (u, y, depth) if along == 0 else (depth, y, u)

    for k in range(count):
        u = first + k * _BAY
        for side in (-1, 1):
            frame.add(where(u + side * 0.585, 1.05, 0), size(0.030, 2.10, 0.036))
        for y, tall in ((0.03, 0.06), (2.085, 0.03), (0.42, 0.03)):
            frame.add(where(u, y, 0), size(1.14, tall, 0.034))
        frame.add(where(u, 0.225, -0.006), size(1.14, 0.36, 0.012))
        for i in range(1, 4):
            frame.add(where(u - 0.57 + 1.14 * i / 4, 1.2525, 0), size(0.010, 1.635, 0.016), 0)
        for i in range(1, 7):
            frame.add(where(u, 0.435 + 1.635 * i / 7, 0), size(1.14, 0.010, 0.018), 0)
        paper.add(where(u, 1.2525, -0.012), size(1.14, 1.635, 0.003), 0)


def _walls():
    frame, paper, plaster = _Pile("Frame", "FrameWood"), _Pile("Paper", "Paper"), _Pile("Wall", "Plaster")
    bays = int(round(2 * SIDE / _BAY))
    _shoji(frame, paper, lambda u, y, d: (u, y, BACK + d), 0, bays, -SIDE + _BAY / 2)
    deep = 7
    for s in (-1, 1):
        _shoji(frame, paper, lambda u, y, d, s=s: (s * (SIDE - d), y, u), 2, deep, BACK + _BAY / 2)
    end = BACK + deep * _BAY
    for y, tall, thick in ((_LINTEL + 0.04, 0.11, 0.11), (CEILING - 0.08, 0.16, 0.12)):
        frame.add((0, y, BACK), (2 * SIDE + 0.2, tall, thick), 0.006)
        for s in (-1, 1):
            frame.add((s * SIDE, y, (BACK + end) / 2), (thick, tall, end - BACK + 0.2), 0.006)
    for x in (-SIDE, -SIDE / 2 - 0.3, SIDE / 2 + 0.3, SIDE):
        frame.add((x, CEILING / 2, BACK + 0.02), (0.13, CEILING, 0.13), 0.006)
    for s in (-1, 1):
        for z in (BACK + 3 * _BAY, end):
            frame.add((s * SIDE, CEILING / 2, z), (0.13, CEILING, 0.13), 0.006)
    plaster.add((0, (CEILING + _LINTEL) / 2, BACK - 0.02), (2 * SIDE, CEILING - _LINTEL, 0.05))
    for s in (-1, 1):
        plaster.add((s * (SIDE + 0.02), (CEILING + _LINTEL) / 2, (BACK + end) / 2), (0.05, CEILING - _LINTEL, end - BACK))
    plaster.add((0, CEILING + 0.03, (BACK + FRONT) / 2), (2 * SIDE + 0.4, 0.05, FRONT - BACK + 0.4))
    for z in np.arange(BACK + 1.2, FRONT, 1.5):
        frame.add((0, CEILING - 0.07, z), (2 * SIDE, 0.14, 0.12), 0.006)
    return [frame.part(), paper.part(), plaster.part()]


def build():
    return [_floor(), *_walls()]
