"""A part of a model, and what is done to meshes after they are made."""
from dataclasses import dataclass

import numpy as np
from scipy import sparse

import nets
from decimate import decimate, edges_of


@dataclass
class Part:
    """One mesh of one material. Colours are linear and multiply the material's."""

    name: str
    material: str
    points: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    colors: np.ndarray = None
    joints: np.ndarray = None
    weights: np.ndarray = None

    def __post_init__(self):
        if self.colors is None:
            self.colors = np.ones((len(self.points), 3))

    def tint(self, amount, color):
        """Multiply the colours by `color` where amount is 1, leave them where it is 0."""
        self.colors *= 1 - np.clip(amount, 0, 1)[:, None] * (1 - np.asarray(color, float))


def sculpt(name, material, shape, lo, hi, h, budget, longest=0.03, detail=None, shown=None):
    """Mesh a field at resolution h, then thin it to `budget` vertices.

    shown: points (n, 3) -> bool (n,), what can be seen at all; the rest is cut away.
    """
    points, triangles = nets.surface(shape, lo, hi, h, rounds=2)
    if shown is not None:
        points, triangles = _cut(points, triangles, shown(points))
    points, triangles = decimate(points, triangles, budget, longest, detail)
    points = nets.project(shape, points, h, 2)
    points, triangles = _without_slivers(points, triangles)
    return Part(name, material, points, normals_of(shape, points, triangles, 0.35 * h), triangles)


def normals_of(shape, points, triangles, e):
    """The field's gradient; where a feature is thinner than e and it misleads, the mesh's own."""
    corner = points[triangles]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    own = np.zeros_like(points)
    for axis in range(3):
        own[:, axis] = sum(np.bincount(triangles[:, k], cross[:, axis], len(points)) for k in range(3))
    size = np.linalg.norm(own, axis=1, keepdims=True)
    own /= np.maximum(size, 1e-30)
    smooth = nets.normals(shape, points, e)
    misled = (np.sum(own * smooth, axis=1, keepdims=True) < 0.4) & (size > 1e-10)
    return np.where(misled, own, smooth)


def _without_slivers(points, triangles):
    corner = points[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    used, t = np.unique(triangles[area > 1e-10], return_inverse=True)
    return points[used], t.reshape(-1, 3)


def _cut(points, triangles, visible):
    """Without the triangles none of whose vertices is visible."""
    t = triangles[visible[triangles].any(axis=1)]
    used, t = np.unique(t, return_inverse=True)
    return points[used], t.reshape(-1, 3)


def cut(part, visible):
    """A part of what was thinned whole, so that its edge is not worn: without the triangles none of whose vertices is
    visible (n,)."""
    t = part.triangles[visible[part.triangles].any(axis=1)]
    used, t = np.unique(t, return_inverse=True)
    return Part(part.name, part.material, part.points[used], part.normals[used], t.reshape(-1, 3))


def mirror(part, name):
    flip = np.array([-1.0, 1, 1])
    return Part(name, part.material, part.points * flip, part.normals * flip, part.triangles[:, ::-1], part.colors.copy())


def merge(name, material, parts):
    offsets = np.cumsum([0] + [len(p.points) for p in parts[:-1]])
    weighted = all(p.weights is not None for p in parts)
    return Part(
        name,
        material,
        np.concatenate([p.points for p in parts]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate([p.triangles + o for p, o in zip(parts, offsets)]),
        np.concatenate([p.colors for p in parts]),
        np.concatenate([p.joints for p in parts]) if weighted else None,
        np.concatenate([p.weights for p in parts]) if weighted else None,
    )


def smoothing(triangles, n):
    """Sparse (n, n): the mean over each vertex's neighbours."""
    e = edges_of(triangles)
    a = sparse.coo_matrix((np.ones(2 * len(e)), (np.r_[e[:, 0], e[:, 1]], np.r_[e[:, 1], e[:, 0]])), shape=(n, n)).tocsr()
    degree = np.asarray(a.sum(axis=1)).ravel()
    return sparse.diags(1 / np.maximum(degree, 1)) @ a
