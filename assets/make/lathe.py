"""The hard-edged shapes: surfaces of revolution about y, and boxes with bevelled edges."""
import numpy as np

from mesh import Part


def revolve(name, material, profile, spokes=32, crease=0.6):
    """Turns (radius, y) pairs about y. Where the profile turns by more than `crease` radians the edge is sharp."""
    profile = np.asarray(profile, float)
    step = np.diff(profile, axis=0)
    normal = np.stack([step[:, 1], -step[:, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    rows, pairs = [], []  # (radius, y, normal) and which rows a band joins
    for k in range(len(step)):
        first, last = normal[k], normal[k]
        if k and normal[k - 1] @ normal[k] > np.cos(crease):
            first = _unit(normal[k - 1] + normal[k])
        if k + 1 < len(step) and normal[k + 1] @ normal[k] > np.cos(crease):
            last = _unit(normal[k + 1] + normal[k])
        shared = bool(rows) and np.allclose(rows[-1], [*profile[k], *first])
        if not shared:
            rows.append([*profile[k], *first])
        rows.append([*profile[k + 1], *last])
        pairs.append((len(rows) - 2, len(rows) - 1))
    rows = np.array(rows)
    angle = np.arange(spokes) * 2 * np.pi / spokes
    c, s = np.cos(angle), np.sin(angle)
    points = np.stack([np.outer(rows[:, 0], s), np.repeat(rows[:, 1:2], spokes, 1), np.outer(rows[:, 0], c)], -1)
    normals = np.stack([np.outer(rows[:, 2], s), np.repeat(rows[:, 3:4], spokes, 1), np.outer(rows[:, 2], c)], -1)
    triangles = []
    for a, b in pairs:
        for k in range(spokes):
            i, j = a * spokes + k, a * spokes + (k + 1) % spokes
            m, n = b * spokes + k, b * spokes + (k + 1) % spokes
            triangles += [t for t, r in (((i, j, n), rows[a, 0]), ((i, n, m), rows[b, 0])) if r > 1e-9]
    return Part(name, material, points.reshape(-1, 3), normals.reshape(-1, 3), np.array(triangles))


def _unit(v):
    return v / np.linalg.norm(v)


def arc(centre, radius, start, end, steps=6):
    """Points of a circle's arc in (radius, y), angles in radians from the radial direction."""
    t = np.linspace(start, end, steps)
    return [(centre[0] + radius * np.cos(a), centre[1] + radius * np.sin(a)) for a in t]


def box(centre, size, bevel=0.003):
    """A box with bevelled edges (none where bevel is 0): points, normals, triangles."""
    half, points, normals, triangles = np.asarray(size, float) / 2, [], [], []

    def face(corners):
        n = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        if n @ np.mean(corners, axis=0) < 0:
            corners, n = corners[::-1], -n
        first = len(points)
        points.extend(corners)
        normals.extend([_unit(n)] * len(corners))
        triangles.extend((first, first + k, first + k + 1) for k in range(1, len(corners) - 1))

    def corner(axis, signs):
        """The corner's point that lies on the face across `axis`."""
        return np.array([signs[k] * (half[k] - (0 if k == axis else bevel)) for k in range(3)])

    signs = [np.array((x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1, 1):
            ring = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                s = np.zeros(3)
                s[axis], s[u], s[v] = side, a, b
                ring.append(corner(axis, s))
            face(ring)
        for a in (-1, 1) if bevel else ():  # the edges along `axis`
            for b in (-1, 1):
                ring = []
                for end, on in ((-1, u), (1, u), (1, v), (-1, v)):
                    s = np.zeros(3)
                    s[axis], s[u], s[v] = end, a, b
                    ring.append(corner(on, s))
                face(ring)
    for s in signs if bevel else ():
        face([corner(axis, s) for axis in range(3)])
    return np.array(points) + centre, np.array(normals), np.array(triangles)
