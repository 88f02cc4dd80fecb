"""Cloth as a sheet: a grid of points, as thick as the cloth, so that hems, bands and seams follow its rows and columns."""
import numpy as np
from scipy.spatial import Delaunay

from mesh import Part

BAND, SEAM = 0.020, 0.0165  # m from a hem: as wide as it is turned in, and where it is sewn
_RAISED, _GROOVE = 0.0013, 0.0016
STEPS = np.array([0, 0.0138, SEAM, 0.0192, 0.0220])


def normals(grid, closed=False):
    """Of a grid (m, n, 3), out of the side where its first direction, its second and they are right-handed."""
    if closed:
        along = np.roll(grid, -1, axis=0) - np.roll(grid, 1, axis=0)
    else:
        along = np.gradient(grid, axis=0)
    n = np.cross(along, np.gradient(grid, axis=1))
    return n / np.maximum(np.linalg.norm(n, axis=2, keepdims=True), 1e-12)


def steps(length, count, first=STEPS, last=STEPS):
    """Distances along a length from one hem to the other, `count` spans between the hems' own."""
    inner = length - first[-1] - last[-1]
    return np.concatenate([first, first[-1] + inner * np.arange(1, count) / count, length - last[::-1]])


def hem(distance):
    """A hem's height over the cloth, m, and its tint, at distances from the edge."""
    raised = _RAISED * np.interp(distance, [BAND - 0.0006, BAND + 0.0018], [1, 0])
    sewn = np.exp(-(((distance - SEAM) / 0.0014) ** 2))
    step = np.exp(-(((distance - 0.0220) / 0.0012) ** 2))
    worn = 0.16 * np.exp(-((distance / 0.003) ** 2))
    return raised - _GROOVE * sewn, (1 + worn) * (1 - 0.45 * sewn) * (1 - 0.25 * step)


def shell(name, material, outer, tint=None, closed=False):
    """The outside of a sheet alone: one whose rims lie under other things."""
    m, n = outer.shape[:2]
    tint = np.ones((m, n)) if tint is None else tint
    colors = np.repeat(tint.reshape(-1, 1), 3, axis=1)
    return Part(name, material, outer.reshape(-1, 3), normals(outer, closed).reshape(-1, 3), _cells(outer, closed), colors)


def _cells(grid, closed):
    """A grid's cells, each as two triangles along its shorter diagonal."""
    m, n = grid.shape[:2]
    a = np.arange(m * n).reshape(m, n)
    a = np.r_[a, a[:1]] if closed else a
    q = np.stack([a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]], axis=-1).reshape(-1, 4)
    p = grid.reshape(-1, 3)[q]
    short = np.linalg.norm(p[:, 0] - p[:, 2], axis=1) <= np.linalg.norm(p[:, 1] - p[:, 3], axis=1)
    q = np.where(short[:, None], q, np.roll(q, -1, axis=1))
    return np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]])


def slab(name, material, outer, thick, tint=None, closed=False, plain=None):
    """A sheet whose outside is a grid (m, n, 3): rounded at its rims; `closed`: its last row joins its first;
    `plain`: the same without what is raised on it, of which the inside shows nothing.

    The second value: for each vertex the point of the outside that it belongs to; what weighs those alike keeps the
    sheet as thick as it is.
    """
    m, n = outer.shape[:2]
    up = normals(outer, closed)
    plain = outer if plain is None else plain
    below = normals(plain, closed)
    inner = plain - thick * below
    tint = np.ones((m, n)) if tint is None else tint
    rim = []  # the grid's border: indices of the grid, and where it turns to
    if not closed:
        rim += [(0, j, outer[0, j] - outer[1, j]) for j in range(n)]
        rim += [(m - 1, j, outer[-1, j] - outer[-2, j]) for j in range(n)]
    rim += [(i, 0, outer[i, 0] - outer[i, 1]) for i in range(m)]
    rim += [(i, n - 1, outer[i, -1] - outer[i, -2]) for i in range(m)]
    turned = {}
    for i, j, out in rim:
        turned.setdefault((i, j), []).append(out / np.linalg.norm(out))
    index = {place: 2 * m * n + k for k, place in enumerate(turned)}
    out = np.array([np.sum(ways, axis=0) for ways in turned.values()])
    at = tuple(np.array(list(turned)).T)
    round_off = 0.5 * np.linalg.norm(outer[at] - inner[at], axis=1, keepdims=True)
    points = np.concatenate([outer.reshape(-1, 3), inner.reshape(-1, 3), 0.5 * (outer[at] + inner[at]) + round_off * out])
    across = out / np.linalg.norm(out, axis=1, keepdims=True)
    facing = np.concatenate([up.reshape(-1, 3), -below.reshape(-1, 3), across])
    flat = np.concatenate([np.arange(m * n)] * 2 + [np.ravel_multi_index(at, (m, n))])

    triangles = []
    front = np.arange(m * n).reshape(m, n)
    sheet = _cells(outer, closed)
    triangles += [sheet, (sheet if closed else _inside(plain))[:, ::-1] + m * n]

    def border(cells):
        """Two strips of triangles along the border: from the outside to the rim, and on to the inside."""
        for u, v in zip(cells[:-1], cells[1:]):
            o0, o1, r0, r1 = front[u], front[v], index[u], index[v]
            i0, i1 = o0 + m * n, o1 + m * n
            triangles.append(np.array([[o0, r0, r1], [o0, r1, o1], [r0, i0, i1], [r0, i1, r1]]))

    rows = list(range(m)) + ([0] if closed else [])
    border([(i, 0) for i in rows])
    border([(i, n - 1) for i in rows[::-1]])
    if not closed:
        border([(0, j) for j in range(n)][::-1])
        border([(m - 1, j) for j in range(n)])
    triangles = np.concatenate(triangles)
    colors = np.repeat(np.concatenate([tint.ravel(), tint.ravel(), tint[at]])[:, None], 3, axis=1)
    used, triangles = np.unique(triangles, return_inverse=True)
    part = Part(name, material, points[used], facing[used], triangles.reshape(-1, 3), colors[used])
    return part, outer.reshape(-1, 3)[flat][used]


def _inside(grid):
    """Triangles of a grid's points, all on its border but few within: little is seen of the inside."""
    m, n = grid.shape[:2]
    way = [np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(grid.mean(axis=1 - k), axis=0), axis=1))]) for k in (0, 1)]
    i, j = np.meshgrid(np.arange(m), np.arange(n), indexing="ij")
    border = (i == 0) | (i == m - 1) | (j == 0) | (j == n - 1)
    within = (i % 4 == 2) & (j % 4 == 2) & (i > 3) & (i < m - 4) & (j > 3) & (j < n - 2)
    chosen = np.flatnonzero((border | within).ravel())
    flat = np.column_stack([way[0][i.ravel()[chosen]], way[1][j.ravel()[chosen]]])
    t = Delaunay(flat).simplices
    corner = flat[t]
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    t = np.where(area[:, None] < 0, t[:, ::-1], t)[np.abs(area) > 1e-12]
    return chosen[t]
