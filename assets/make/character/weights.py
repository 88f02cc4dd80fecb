"""Skin weights by heat: every bone warms the body around it, and the mixture of heats is the weight.

Solved on voxels of the clothed body (after Baran and Popovic 2007, who solved it on the surface), so
that skin and cloth layers at one place get the same weights and do not pass through one another, and
so that heat reaches the arm from the chest only through the shoulder.
"""
import numpy as np
from scipy import ndimage, sparse
from scipy.sparse.linalg import cg, splu
from scipy.spatial import cKDTree

import sdf
from skeleton import REST, SIDES, joint, tip

VOXEL = 0.012

# Per bone: the thickness of the body around it, and over what length its weight gives way, m.
_BONES = {
    "Hips": (0.135, 0.050),
    "Spine": (0.130, 0.055),
    "Spine1": (0.130, 0.055),
    "Chest": (0.140, 0.050),
    "Neck": (0.060, 0.024),
    "Head": (0.100, 0.020),
    "Shoulder": (0.075, 0.045),
    "Arm": (0.058, 0.042),
    "ForeArm": (0.046, 0.030),
    "Hand": (0.032, 0.016),
    "UpLeg": (0.095, 0.050),
    "Leg": (0.062, 0.036),
    "Foot": (0.042, 0.018),
    "ToeBase": (0.027, 0.014),
}


def _columns():
    out = {}
    for name in REST.names:
        kind = name.replace("Left", "").replace("Right", "")
        if kind in _BONES:
            out[name] = _BONES[kind]
    return out


class BodyHeat:
    """Weights of all bones but the fingers' anywhere in the body: `at(points)` -> (n, bones)."""

    def __init__(self, inside, lo, hi):
        """inside: field of the whole clothed body, symmetric in x; lo, hi: its bounds."""
        self.bones = _columns()
        self.lo = np.asarray(lo, float)
        shape = np.ceil((np.asarray(hi) - self.lo) / VOXEL).astype(int) + 1
        grid = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), -1)
        centres = self.lo + VOXEL * grid.reshape(-1, 3)
        solid = (inside(centres) < 0.3 * VOXEL).reshape(shape)
        labels, _ = ndimage.label(solid)
        largest = 1 + np.argmax(np.bincount(labels.ravel())[1:])
        solid = labels == largest
        weights = self._solve(centres.reshape(*shape, 3)[solid], solid)
        nearest = ndimage.distance_transform_edt(~solid, return_distances=False, return_indices=True)
        number = np.full(shape, -1)
        number[solid] = np.arange(solid.sum())
        self.grid = weights[number[tuple(nearest)]]

    def _solve(self, points, solid):
        distance = np.stack(
            [sdf.segment(points, joint(b), tip(b)) / radius for b, (radius, _) in self.bones.items()], 1
        )
        for k, b in enumerate(self.bones):  # a limb never warms the other side of the body
            side = {"L": 1, "R": -1}[b[0]] if b.startswith(("Left", "Right")) else 0
            if side:
                distance[side * points[:, 0] < -0.004, k] = np.inf
        nearest = np.argmin(distance, axis=1)
        blend = np.array([length for _, length in self.bones.values()])[nearest]
        heat = (VOXEL / blend) ** 2
        number = np.full(solid.shape, -1)
        number[solid] = np.arange(len(points))
        rows, cols = [], []
        for axis in range(3):
            a = np.moveaxis(number, axis, 0)[:-1].ravel()
            b = np.moveaxis(number, axis, 0)[1:].ravel()
            both = (a >= 0) & (b >= 0)
            rows += [a[both], b[both]]
            cols += [b[both], a[both]]
        rows, cols = np.concatenate(rows), np.concatenate(cols)
        links = sparse.csr_matrix((np.ones(len(rows)), (rows, cols)), shape=(len(points),) * 2)
        diagonal = np.asarray(links.sum(axis=1)).ravel() + heat
        system = sparse.diags(diagonal) - links
        inverse = sparse.diags(1 / diagonal)
        out = np.empty((len(points), len(self.bones)))
        for k in range(len(self.bones)):
            source = heat * (nearest == k)
            out[:, k], failed = cg(system, source, x0=(nearest == k) * 1.0, tol=1e-4, M=inverse, maxiter=500)
            assert failed == 0
        return np.maximum(out, 0)

    def at(self, points, bones):
        """(n, bones): weights of the named bones only, summing to 1."""
        cell = ((points - self.lo) / VOXEL).T
        out = np.zeros((len(points), len(REST.names)))
        for k, b in enumerate(self.bones):
            if b in bones:
                out[:, REST.index(b)] = ndimage.map_coordinates(self.grid[..., k], cell, order=1, mode="nearest")
        return out / out.sum(axis=1, keepdims=True)


def spread(dense, triangles, points, length):
    """Weights blurred along a surface, each vertex's over about `length` (n,), m, so that cloth bends widely where
    the body bends sharply: a step of diffusion by linear finite elements, which no mesh's edges can steer."""
    n, t = len(points), triangles
    corner = points[t]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    rows, cols, values = [], [], []
    for k in range(3):
        i, j = t[:, (k + 1) % 3], t[:, (k + 2) % 3]
        u, v = points[i] - points[t[:, k]], points[j] - points[t[:, k]]
        cotangent = np.sum(u * v, axis=1) / np.maximum(2 * area, 1e-12)
        # A negative one would push weights out of [0, 1].
        value = 0.5 * np.clip(cotangent, 0.02, 20) * 0.5 * (length[i] ** 2 + length[j] ** 2)
        rows, cols, values = rows + [i, j], cols + [j, i], values + [value, value]
    links = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), (n, n))
    mass = np.bincount(t.ravel(), np.repeat(area / 3, 3), n)
    system = sparse.diags(mass + np.asarray(links.sum(axis=1)).ravel()) - links
    return splu(system.tocsc()).solve(mass[:, None] * dense)


def nearby(points, others, dense):
    """The weights of other points, averaged round each point over about 15 mm."""
    distance, k = cKDTree(others).query(points, k=24)
    share = np.exp(-(((distance - distance[:, :1]) / 0.015) ** 2))
    return np.einsum("nk,nkb->nb", share / share.sum(axis=1, keepdims=True), dense[k])


def dense_of(part):
    """A part's weights as (n, bones)."""
    out = np.zeros((len(part.points), len(REST.names)))
    for k in range(4):
        out[np.arange(len(out)), part.joints[:, k]] += part.weights[:, k]
    return out


def sides(*kinds):
    """Both sides' bones of the given kinds."""
    return [side + kind for side, _ in SIDES for kind in kinds]


def strongest(dense):
    """At most four weights per vertex: joints (n, 4), weights (n, 4) that sum to 1 in float32. What the fifth has
    is taken from all, so that a bone that falls behind four others leaves nothing to tear where it does."""
    order = np.argsort(-dense, axis=1, kind="stable")[:, :5]
    w = np.take_along_axis(dense, order, axis=1)
    w, order = w[:, :4] - np.minimum(w[:, 4:], 0.5 * w[:, :1]), order[:, :4]
    w[w < 0.004] = 0
    w = (w / w.sum(axis=1, keepdims=True)).astype(np.float32)
    w[:, 0] = 1 - w[:, 1:].sum(axis=1)
    order[w == 0] = 0
    return order, w


def rigid(n, bone):
    dense = np.zeros((n, len(REST.names)))
    dense[:, REST.index(bone)] = 1
    return dense
