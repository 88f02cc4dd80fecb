"""The dojo: plank floor, shoji walls on three sides, posts, lintel, beams and plaster, under half a roof.

The floor's top is y = 0 and the stage is around the origin; the back wall stands at z = -2.6, the side
walls at x = +-4.2. Cameras look from the open side, +z, where the sun comes in: the roof ends over the middle of
the floor, the wall on the sun's side, x < 0, a little farther.
"""
import numpy as np

from garden import Garden
from lathe import box, revolve
from mesh import Part

BACK, SIDE, FRONT, CEILING = -2.6, 4.2, 6.0, 3.3
_BAY = 1.2  # width of a shoji panel
_DEEP = {-1: 4, 1: 7}  # panels along a side wall
_EAVES = 0.75  # where the roof ends, z
_LINTEL = 2.12
_JOINT = 0.0030  # m, a plank's bevel
_END = {side: BACK + panels * _BAY for side, panels in _DEEP.items()}


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

    def sheet(self, corner, across, up, cells, tone=(1, 1, 1)):
        """A plane of cells[0] by cells[1] quads, which faces across x up."""
        i, j = (k.ravel() for k in np.meshgrid(*(np.arange(n + 1) for n in cells), indexing="ij"))
        points = corner + np.outer(i / cells[0], across) + np.outer(j / cells[1], up)
        first = np.flatnonzero((i < cells[0]) & (j < cells[1]))
        right, above = cells[1] + 1, 1
        quads = np.stack([first, first + right, first + right + above, first + above], axis=1)
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        normal = np.cross(across, up)
        normals = np.tile(normal / np.linalg.norm(normal), (len(points), 1))
        self.boxes.append((points, normals, triangles + self.count, np.tile(np.asarray(tone, float), (len(points), 1))))
        self.count += len(points)

    def part(self):
        return Part(self.name, self.material, *[np.concatenate(a) for a in zip(*self.boxes)])


class _Timber:
    """Boxes of wood, a pile for each axis that the grain runs along."""

    def __init__(self, name, material):
        self.piles = [_Pile(name + axis, material) for axis in ("Across", "Up", "Deep")]

    def add(self, centre, size, bevel=0.003, tone=(1, 1, 1), shown=None):
        self.piles[int(np.argmax(size))].add(centre, size, bevel, tone, shown)

    def parts(self):
        return [pile.part() for pile in self.piles]


def _split(part, longest):
    """Halve the edges longer than `longest`(points) until none is left: shade needs vertices to live on."""
    while True:
        p, t = part.points, part.triangles
        ends = t[:, [[0, 1], [1, 2], [2, 0]]]
        length = np.linalg.norm(p[ends[:, :, 0]] - p[ends[:, :, 1]], axis=2)
        limit = longest(p[ends].mean(axis=2).reshape(-1, 3)).reshape(-1, 3)
        over = np.where(length > limit, length, 0)
        worst = np.argmax(over, axis=1)
        cut = np.flatnonzero(over.max(axis=1) > 0)
        if not len(cut):
            return part
        k = worst[cut]
        a, b, c = t[cut, k], t[cut, (k + 1) % 3], t[cut, (k + 2) % 3]
        edge, number = np.unique(np.sort(np.stack([a, b], 1), axis=1), axis=0, return_inverse=True)
        middle = len(p) + number.ravel()
        mean = lambda x: np.concatenate([x, 0.5 * (x[edge[:, 0]] + x[edge[:, 1]])])
        whole = np.delete(t, cut, axis=0)
        t = np.concatenate([whole, np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        part = Part(part.name, part.material, mean(p), mean(part.normals), t, mean(part.colors))


def _distances(p):
    """To the room's planes: floor, ceiling, back wall and side walls (the inner faces)."""
    return [p[:, 1], CEILING - p[:, 1], p[:, 2] - BACK - 0.02, SIDE - 0.02 - np.abs(p[:, 0])]


def _shaded(part):
    """Darken corners: each plane of the room takes light from what stands at right angles to it."""
    part = _split(part, lambda p: 0.36 + 1.5 * np.sort(np.abs(np.stack(_distances(p))), axis=0)[1])
    p, n = part.points, np.abs(part.normals)
    radius = 0.45
    light = np.ones(len(p))
    for d, axis in zip(_distances(p), (1, 1, 2, 0)):
        d = np.maximum(d, 0)
        hidden = 0.5 * (1 - d / np.sqrt(d * d + radius * radius))
        light *= 1 - 0.9 * hidden * (1 - n[:, axis])
    part.colors = part.colors * light[:, None]
    return part


def _floor():
    planks, rng = _Pile("Floor", "Floor"), np.random.default_rng(3)
    width, length = 0.15, 1.8
    for x in np.arange(-SIDE, SIDE - width / 2, width):
        z = BACK
        while z < FRONT:
            long = min(length * (rng.random() if z == BACK else 1), FRONT - z)
            tone = 0.62 + 0.38 * rng.random() ** 0.8
            warm = 1 + 0.16 * (rng.random() - 0.5)
            # Ends overlap by their bevels, which would glitter.
            planks.add(
                (x + width / 2, -0.0125, z + long / 2), (width, 0.025, long + 2 * _JOINT), _JOINT,
                (tone, tone * warm, tone * warm**2), lambda n: n[:, 1] > 0.1,
            )
            z += long
    part = planks.part()
    part.tint(part.normals[:, 1] < 0.95, (0.50, 0.46, 0.42))  # no light comes out of the joints
    return _shaded(part)


def _shoji(frame, paper, garden, where, along, count, first, rng):
    """A row of panels. where(u, y, depth) -> point; along: 0 if the wall runs along x, 2 along z."""

    def size(u, y, depth):
        return (u, y, depth) if along == 0 else (depth, y, u)

    ahead, into = np.subtract(where(1, 0, 0), where(0, 0, 0)), np.subtract(where(0, 0, 1), where(0, 0, 0))
    inwards = np.cross(ahead, (0, 1, 0)) @ into > 0  # along u, the room is on the right

    def inside(n):
        """Where the sun comes from the room, backs are what throws shadows."""
        return (n @ into > -0.5) | (into[0] < -0.5)

    for k in range(count):
        u = first + k * _BAY
        for side in (-1, 1):
            edge = 0 if into[0] > 0.5 else 0.003  # the sun shines through joints from behind
            frame.add(where(u + side * 0.585, 1.05, 0), size(0.030, 2.10, 0.036), edge, shown=inside)
        for y, tall in ((0.03, 0.06), (2.085, 0.03), (0.42, 0.03)):
            frame.add(where(u, y, 0), size(1.14, tall, 0.034), shown=inside)
        frame.add(where(u, 0.225, -0.006), size(1.14, 0.36, 0.012), shown=inside)
        for i in range(1, 4):
            frame.add(where(u - 0.57 + 1.14 * i / 4, 1.2525, 0), size(0.010, 1.635, 0.016), 0, shown=inside)
        for i in range(1, 7):
            frame.add(where(u, 0.435 + 1.635 * i / 7, 0), size(1.14, 0.010, 0.018), 0, shown=inside)
        for i in range(7):  # sheets of paper, one per row, no two quite alike; bars hide where their panes meet
            tone = 0.95 + 0.05 * rng.random()
            low, tall, wide = 0.435 + 1.635 * i / 7, 1.635 / 7, 1.14 / 4
            for j in range(4):
                left = u - 0.57 + wide * j
                ends = [where(left + (0 if inwards else wide), low, -0.0105), where(left + (wide if inwards else 0), low, -0.0105)]
                cells = garden.cells(left, low, wide, tall)
                paper.sheet(np.array(ends[0]), np.subtract(ends[1], ends[0]), (0, tall, 0), cells, (tone, tone, tone**1.3))


def _daylit(paper, gardens):
    """Paper is brightest in the middle of a wall: the eaves outside take the sky from the upper sheets, shrubs the light
    near the ground, and corners see less of it; what light is left is warmer. The evening sun is on the outside of the
    wall at x < 0."""
    p = paper.points
    wall = np.where(np.abs(p[:, 0]) < SIDE, 0, np.sign(p[:, 0]))
    left = np.ones(len(p))
    for k, garden in gardens.items():
        left[wall == k] = garden.light(p[wall == k][:, [2 if k else 0, 1]])
    under = np.clip((p[:, 1] - 0.435) / 1.635, 0, 1)
    corner = np.exp(-np.minimum(SIDE - np.abs(p[:, 0]), p[:, 2] - BACK - 0.02 + 1.5 * (wall == 0)) / 0.9)
    dim = (1 - 0.62 * under**1.5) * (1 - 0.35 * corner)
    sun = np.where((wall < 0)[:, None], (1.0, 0.86, 0.68), (0.92, 0.92, 0.92)) * left[:, None] ** (1.06, 0.94, 1.0)  # leaves are green
    paper.colors = paper.colors * sun * np.stack([dim, dim**1.12, dim**1.3], axis=1)
    return paper


def _beams(frame):
    for y, tall, thick in ((_LINTEL + 0.04, 0.11, 0.11), (CEILING - 0.08, 0.16, 0.12)):
        frame.add((0, y, BACK), (2 * SIDE + 0.2, tall, thick), 0.006)
        for s, end in _END.items():
            frame.add((s * SIDE, y, (BACK + end) / 2), (thick, tall, end - BACK + 0.2), 0.006)
    for x in (-SIDE, -SIDE / 2 - 0.3, SIDE / 2 + 0.3, SIDE):
        frame.add((x, CEILING / 2, BACK + 0.02), (0.13, CEILING, 0.13), 0.006)
    for s, end in _END.items():
        for z in (BACK + 2 * _BAY, end):
            frame.add((s * SIDE, CEILING / 2, z), (0.13, CEILING, 0.13), 0.006)
        frame.add((s * (SIDE - 0.03), 0.045, (BACK + end) / 2), (0.05, 0.09, end - BACK), 0.004)
    frame.add((0, 0.045, BACK + 0.03), (2 * SIDE, 0.09, 0.05), 0.004)
    for z in (BACK + 1.2, BACK + 2.4, _EAVES):
        frame.add((0, CEILING - 0.07, z), (2 * SIDE, 0.14, 0.12), 0.006)
    for x in np.arange(-SIDE + 0.15, SIDE - 0.1, 0.16):  # slats below the eaves
        frame.add((x, CEILING - 0.32, _EAVES), (0.045, 0.40, 0.03), 0.002)
    frame.add((0, CEILING - 0.54, _EAVES), (2 * SIDE, 0.05, 0.05), 0.003)


def _walls():
    frame, paper, plaster = _Timber("Frame", "FrameWood"), _Pile("Paper", "Paper"), _Pile("Wall", "Plaster")
    rng = np.random.default_rng(5)
    bays = int(round(2 * SIDE / _BAY))
    gardens = {0: Garden(2, -SIDE, SIDE), -1: Garden(7, BACK, _END[-1]), 1: Garden(11, BACK, 2.4)}
    _shoji(frame, paper, gardens[0], lambda u, y, d: (u, y, BACK + d), 0, bays, -SIDE + _BAY / 2, rng)
    for s, panels in _DEEP.items():
        _shoji(frame, paper, gardens[s], lambda u, y, d, s=s: (s * (SIDE - d), y, u), 2, panels, BACK + _BAY / 2, rng)
    _beams(frame)
    _stand(frame)
    high = CEILING - _LINTEL
    plaster.add((0, _LINTEL + high / 2, BACK - 0.02), (2 * SIDE, high, 0.05), shown=lambda n: n[:, 2] > -0.5)
    for s, end in _END.items():
        middle, size = (s * (SIDE + 0.02), _LINTEL + high / 2, (BACK + end) / 2), (0.05, high, end - BACK)
        plaster.add(middle, size, shown=lambda n, s=s: s * n[:, 0] < 0.5)
    ceiling = (2 * SIDE + 0.4, 0.05, _EAVES - BACK + 0.2)
    plaster.add((0, CEILING + 0.03, (BACK + _EAVES) / 2), ceiling, shown=lambda n: n[:, 1] < 0.5)
    return [*frame.parts(), _names(rng), _staffs(), _daylit(paper.part(), gardens), _shaded(plaster.part())]


def _names(rng):
    """The pupils' names on a board over the lintel: plates of pale wood, of which each hangs a little otherwise."""
    plates = _Pile("Plates", "PlateWood")
    for row, y in ((0, 2.66), (1, 2.42)):
        for k in range(30 - 7 * row):
            x = -1.62 + 0.088 * k + 0.004 * (rng.random() - 0.5)
            tone = 0.62 + 0.38 * rng.random()
            warm = 1 - 0.08 * rng.random()
            plates.add((x, y + 0.003 * rng.random(), BACK + 0.012 + 0.002 * rng.random()), (0.062, 0.185, 0.010), 0.0015,
                       (tone, tone * warm, tone * warm**2))
    return plates.part()


_STAND = (-3.28, BACK + 0.30, 1.35)  # x and z of its middle, and how long its staffs are
_STAFFS = (0.42, 0.66, 0.90)  # heights


def _stand(frame):
    """What carries the staffs: two posts on feet, with pegs."""
    x, z, long = _STAND
    for side in (-1, 1):
        at = x + side * 0.36 * long
        frame.add((at, 0.53, z), (0.05, 1.0, 0.05), 0.004)
        frame.add((at, 0.025, z), (0.06, 0.05, 0.36), 0.006)
        for y in _STAFFS:
            frame.add((at, y - 0.028, z + 0.05), (0.03, 0.024, 0.06), 0.003)
    frame.add((x, 0.16, z), (0.72 * long, 0.05, 0.035), 0.004)


def _staffs():
    """Three staffs of pale wood, thinner towards their ends."""
    x, z, long = _STAND
    profile = [(0.0, -long / 2), (0.009, -long / 2), (0.0115, -long / 2 + 0.004), (0.0145, -0.2 * long)]
    profile += [(r, -y) for r, y in reversed(profile)]
    parts = []
    for k, y in enumerate(_STAFFS):
        staff = revolve("Staffs", "PlateWood", profile, 16)
        p, n = staff.points, staff.normals
        place = np.array([x + (0.03, -0.05, 0.02)[k], y, z + 0.05])
        parts.append((np.stack([p[:, 1], -p[:, 0], p[:, 2]], 1) + place, np.stack([n[:, 1], -n[:, 0], n[:, 2]], 1), staff.triangles))
    count = np.cumsum([0] + [len(p) for p, _, _ in parts])
    return Part("Staffs", "PlateWood", np.concatenate([p for p, _, _ in parts]), np.concatenate([n for _, n, _ in parts]),
                np.concatenate([t + first for (_, _, t), first in zip(parts, count)]))


def build():
    return [_floor(), *_walls()]
