"""Weights of cloth by strain: those with which it keeps its shape best over a set of poses.

As rigid as possible (Sorkine and Alexa 2007), with the skinned surface in the place of the free one. Skinned points are
linear in the weights, so the global step is one sparse system for all of them; it is solved by ADMM (Boyd and others
2011), because weights may not be negative and sum to 1.
"""
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from mesh import smoothing
from sdf import rotation
from skeleton import REST, joint

ROUNDS = 90
HOLD = 0.005  # how dear it is to leave the weights that were given, against strain
LIMIT, SHAPE = 1.25, 0.10
PULL = 0.02  # of ADMM
UNTANGLING = 12  # rounds


def pose(turns):
    """Bones' turns against their parents, name -> matrix, to (bones, 3, 4): what takes rest points to posed ones."""
    turned, moved = {}, {}
    for name in REST.names:
        own, parent, at = turns.get(name, np.eye(3)), REST.parent[name], joint(name)
        r, t = (turned[parent], moved[parent]) if parent else (np.eye(3), np.zeros(3))
        turned[name] = r @ own
        moved[name] = r @ at + t - turned[name] @ at
    return np.stack([np.column_stack([turned[n], moved[n]]) for n in REST.names])


def both(side_turns):
    """Turns of both sides' bones from those of the left side's, kind -> (axis, angle) pairs, first turn first."""
    out = {}
    for side, sign in (("Left", 1), ("Right", -1)):
        for kind, steps in side_turns.items():
            m = np.eye(3)
            for axis, angle in steps:
                # The mirror image of a turn: about the mirrored axis, the other way.
                m = rotation(np.asarray(axis, float) * (1, sign, sign), angle) @ m
            out[side + kind] = m
    return out


def ease(points, triangles, dense, poses):
    """The weights (n, bones) near `dense` that strain least over `poses`; each vertex keeps to the bones it has."""
    n, dense = len(points), _four(dense)
    links, weight = _cotangents(points, triangles)
    difference = sparse.csr_matrix(
        (np.tile([1.0, -1.0], len(links)), (np.repeat(np.arange(len(links)), 2), links.ravel())), (len(links), n)
    )
    laplacian = difference.T @ sparse.diags(weight) @ difference
    vertex, bone = np.nonzero(dense)
    # Displacements, not places: what no pose moves has no say. (poses, 3, entries)
    reach = np.stack([np.einsum("eij,ej->ie", m[bone, :, :3], points[vertex]) + m[bone, :, 3].T - points[vertex].T for m in poses])
    columns = np.arange(len(vertex))
    spread = [[sparse.csr_matrix((reach[p, k], (vertex, columns)), (n, len(vertex))) for k in range(3)] for p in range(len(poses))]
    area = np.bincount(triangles.ravel(), np.repeat(_areas(points, triangles) / 3, 3), n)
    hold = HOLD * (area[vertex] / area.mean()) * laplacian.diagonal().mean() * 0.01
    system = sparse.diags(hold + PULL)
    for row in spread:
        for m in row:
            system = system + m.T @ laplacian @ m
    solve = splu(system.tocsc()).solve
    given = dense[vertex, bone]
    z, u = given.copy(), np.zeros_like(given)
    span = points[links[:, 0]] - points[links[:, 1]]
    length = np.linalg.norm(span, axis=1)
    for _ in range(ROUNDS):
        right = hold * given + PULL * (z - u)
        for row in spread:
            moved = points + np.stack([m @ z for m in row], axis=1)
            turn = _rotations(links, weight, span, moved, n)
            wanted = _relieved(moved[links[:, 0]] - moved[links[:, 1]], 0.5 * np.einsum("eij,ej->ei", turn[links[:, 0]] + turn[links[:, 1]], span), length) - span
            for k in range(3):
                right = right + row[k].T @ (difference.T @ (weight * wanted[:, k]))
        x = solve(right)
        z = _simplex(x + u, vertex, bone, dense.shape)
        u = u + x - z
    out = np.zeros_like(dense)
    out[vertex, bone] = z
    return out


def untangle(points, normals, triangles, dense, poses):
    """Weights nearer to their neighbours' at the few triangles that the poses turn inside out."""
    mean = smoothing(triangles, len(points))
    bones = [(np.asarray(m)[:, :, :3], np.asarray(m)[:, :, 3]) for m in poses]

    def inside_out(p, up):
        up = up / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
        a, b, c = (p[triangles[:, k]] for k in range(3))
        return np.sum(np.cross(b - a, c - a) * up[triangles].sum(axis=1), axis=1) < 0

    at_rest = inside_out(points, normals)
    for _ in range(UNTANGLING):
        turned = np.zeros(len(triangles), bool)
        for turn, move in bones:
            blend = np.tensordot(dense, turn, axes=1)
            now = np.einsum("vij,vj->vi", blend, points) + dense @ move
            turned |= inside_out(now, np.einsum("vij,vj->vi", blend, normals)) & ~at_rest
        if not turned.any():
            break
        near = np.zeros(len(points))
        near[triangles[turned]] = 0.3
        dense = dense + near[:, None] * (mean @ dense - dense)
    return dense


def _relieved(now, turned, length):
    """What edges should be: cloth resists stretch above all, and a little that its shape is lost."""
    size = np.linalg.norm(now, axis=1)
    held = now * np.minimum(1, LIMIT * length / np.maximum(size, 1e-9))[:, None]
    return held + SHAPE * (turned - held)


def _four(dense):
    """The four strongest weights, limbs before the trunk: what moves farthest must not end suddenly."""
    limb = np.array([b.startswith(("Left", "Right")) for b in REST.names])
    order = np.argsort(-dense * np.where(limb, 4.0, 1.0), axis=1, kind="stable")
    out = dense.copy()
    np.put_along_axis(out, order[:, 4:], 0, axis=1)
    out[out < 0.004] = 0
    return out / out.sum(axis=1, keepdims=True)


def _areas(points, t):
    return 0.5 * np.linalg.norm(np.cross(points[t[:, 1]] - points[t[:, 0]], points[t[:, 2]] - points[t[:, 0]]), axis=1)


def _cotangents(points, t):
    """Edges (m, 2) and their cotangent weights, none negative."""
    n = len(points)
    total = sparse.csr_matrix((n, n))
    area = np.maximum(_areas(points, t), 1e-12)
    for k in range(3):
        i, j = t[:, (k + 1) % 3], t[:, (k + 2) % 3]
        u, v = points[i] - points[t[:, k]], points[j] - points[t[:, k]]
        value = np.clip(np.sum(u * v, axis=1) / (4 * area), 0.02, 5)
        total = total + sparse.csr_matrix((value, (np.minimum(i, j), np.maximum(i, j))), (n, n))
    total = total.tocoo()
    return np.stack([total.row, total.col], axis=1), total.data


def _rotations(links, weight, span, moved, n):
    """Per vertex the rotation that takes its edges at rest nearest to what they are now."""
    now = moved[links[:, 0]] - moved[links[:, 1]]
    each = (weight[:, None, None] * now[:, :, None] * span[:, None, :]).reshape(-1, 9)
    sums = np.stack(
        [np.bincount(links[:, 0], each[:, k], n) + np.bincount(links[:, 1], each[:, k], n) for k in range(9)], axis=1
    )
    u, _, vt = np.linalg.svd(sums.reshape(-1, 3, 3))
    flip = np.sign(np.linalg.det(u @ vt))
    u[:, :, 2] *= flip[:, None]
    return u @ vt


def _simplex(x, vertex, bone, shape):
    """The nearest weights that are not negative and sum to 1 for every vertex (Held, Wolfe and Crowder 1974)."""
    full = np.full(shape, -np.inf)
    full[vertex, bone] = x
    order = -np.sort(-full, axis=1)
    finite = np.isfinite(order)
    total = np.cumsum(np.where(finite, order, 0), axis=1) - 1
    count = np.arange(1, shape[1] + 1)
    kept = finite & (order * count > total)
    last = kept.sum(axis=1) - 1
    shift = total[np.arange(shape[0]), last] / (last + 1)
    return np.maximum(x - shift[vertex], 0)
