"""A part of a model, and what is done to meshes after they are made."""
from dataclasses import dataclass, field as member

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
    extra: dict = member(default_factory=dict)

    def __post_init__(self):
        if self.colors is None:
            self.colors = np.ones((len(self.points), 3))

    def tint(self, amount, color):
        """Multiply the colours by `color` where amount is 1, leave them where it is 0."""
        self.colors *= 1 - np.clip(amount, 0, 1)[:, None] * (1 - np.asarray(color, float))


def sculpt(name, material, shape, lo, hi, h, budget, longest=0.03, detail=None, rounds=2):
    """Mesh a field at resolution h, then thin it to `budget` vertices."""
    points, triangles = nets.surface(shape, lo, hi, h, rounds)
    points, triangles = decimate(points, triangles, budget, longest, detail)
    points = nets.project(shape, points, h, 2)
    return Part(name, material, points, nets.normals(shape, points, 0.35 * h), triangles)


def mirror(part, name):
    flip = np.array([-1.0, 1, 1])
    return Part(name, part.material, part.points * flip, part.normals * flip, part.triangles[:, ::-1], part.colors.copy())


def merge(name, material, parts):
    offsets = np.cumsum([0] + [len(p.points) for p in parts[:-1]])
    return Part(
        name,
        material,
        np.concatenate([p.points for p in parts]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate([p.triangles + o for p, o in zip(parts, offsets)]),
        np.concatenate([p.colors for p in parts]),
    )


def keep(part, visible):
    """Drop the triangles none of whose vertices is visible, and the vertices that nothing uses."""
    t = part.triangles[visible[part.triangles].any(axis=1)]
    used, t = np.unique(t, return_inverse=True)
    return Part(part.name, part.material, part.points[used], part.normals[used], t.reshape(-1, 3), part.colors[used])


def smoothing(triangles, n):
    """Sparse (n, n): the mean over each vertex's neighbours."""
    e = edges_of(triangles)
    a = sparse.coo_matrix((np.ones(2 * len(e)), (np.r_[e[:, 0], e[:, 1]], np.r_[e[:, 1], e[:, 0]])), shape=(n, n)).tocsr()
    degree = np.asarray(a.sum(axis=1)).ravel()
    return sparse.diags(1 / np.maximum(degree, 1)) @ a
