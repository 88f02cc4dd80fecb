"""Surface nets: a closed triangle mesh of the zero set of a field.

One vertex per grid cell that the surface crosses, at the mean of the crossings on the cell's edges;
then Newton steps put it on the surface itself. A coarse pass first finds where the surface is, so
that the fine grid is evaluated only there.
"""
import numpy as np

CHUNK = 200_000
COARSE = 4  # fine cells per coarse cell


def evaluate(field, p):
    """The field at p (n, 3), in pieces that fit the cache."""
    return np.concatenate([field(p[i : i + CHUNK]) for i in range(0, len(p), CHUNK)]) if len(p) else np.empty(0)


def gradient(field, p, e):
    """Central differences with half step e."""
    g = [evaluate(field, p + e * axis) - evaluate(field, p - e * axis) for axis in np.eye(3)]
    return np.stack(g, axis=1) / (2 * e)


def normals(field, p, e):
    g = gradient(field, p, e)
    return g / (np.linalg.norm(g, axis=1, keepdims=True) + 1e-12)


def project(field, p, step, rounds):
    """Newton steps towards the surface, none longer than 0.3 `step`."""
    for _ in range(rounds):
        g = gradient(field, p, 0.35 * step)
        move = (evaluate(field, p) / (np.sum(g * g, axis=1) + 0.05))[:, None] * g
        length = np.linalg.norm(move, axis=1, keepdims=True)
        p = p - move * np.minimum(1, 0.3 * step / np.maximum(length, 1e-12))
    return p


def _sample(field, lo, shape, h):
    """The field on the grid, exact near the surface and of the right sign elsewhere."""
    blocks = -(-np.array(shape) // COARSE)
    centres = np.stack(np.meshgrid(*[np.arange(n) for n in blocks], indexing="ij"), -1).reshape(-1, 3)
    centres = lo + h * (COARSE * centres + (COARSE - 1) / 2)
    coarse = evaluate(field, centres).reshape(blocks)
    grid = coarse.astype(np.float32)
    for axis in range(3):
        grid = np.repeat(grid, COARSE, axis=axis)
    grid = grid[: shape[0], : shape[1], : shape[2]].copy()
    near = np.argwhere(np.abs(grid) < 1.7 * COARSE * h)
    grid[tuple(near.T)] = evaluate(field, lo + h * near)
    return grid


def _crossings(grid, cells):
    """Mean position of the sign changes on each cell's edges, in cell units."""
    total, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    value = {c: grid[tuple((cells + c).T)].astype(float) for c in corners}
    for corner in corners:
        for axis in range(3):
            if corner[axis]:
                continue
            other = tuple(1 if k == axis else corner[k] for k in range(3))
            fa, fb = value[corner], value[other]
            crossed = (fa < 0) != (fb < 0)
            t = np.where(crossed, fa / np.where(crossed, fa - fb, 1), 0)
            total += (np.array(corner) + np.outer(t, np.eye(3)[axis])) * crossed[:, None]
            count += crossed
    return total / count[:, None]


def surface(field, lo, hi, h, rounds=3):
    """Vertices (n, 3) and triangles (m, 3), counter-clockwise seen from outside."""
    lo, hi = np.asarray(lo, float), np.asarray(hi, float)
    grid = _sample(field, lo, tuple(np.ceil((hi - lo) / h).astype(int) + 1), h)
    inside = grid < 0
    n = np.array(grid.shape)
    count = np.zeros(n - 1, np.int8)
    for dx in (0, 1):
        for dy in (0, 1):
            for dz in (0, 1):
                count += inside[dx : n[0] - 1 + dx, dy : n[1] - 1 + dy, dz : n[2] - 1 + dz]
    active = (count > 0) & (count < 8)
    cells = np.argwhere(active)
    number = np.full(n - 1, -1)
    number[active] = np.arange(len(cells))
    points = lo + h * (cells + _crossings(grid, cells))

    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        first, second = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        edges = np.argwhere(np.moveaxis(first != second, 0, axis))
        edges = edges[(edges[:, u] > 0) & (edges[:, v] > 0) & (edges[:, u] < n[u] - 1) & (edges[:, v] < n[v] - 1)]
        around = []
        for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = edges.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            around.append(number[tuple(cell.T)])
        quad = np.stack(around, axis=1)
        outward = inside[tuple(edges.T)]
        quad[~outward] = quad[~outward][:, ::-1]
        quads.append(quad)
    quads = np.concatenate(quads)
    points = project(field, points, h, rounds)
    return points, _split(points, quads)


def _split(points, quads):
    """Each quad into two triangles along its shorter diagonal."""
    p = points[quads]
    first = np.linalg.norm(p[:, 0] - p[:, 2], axis=1) <= np.linalg.norm(p[:, 1] - p[:, 3], axis=1)
    q = np.where(first[:, None], quads, np.roll(quads, -1, axis=1))
    return np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]])
