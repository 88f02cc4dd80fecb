"""Fewer triangles where the surface is flat: edge collapse by quadric error, many edges at a time.

Garland and Heckbert's quadrics (1997). Each round collapses the cheapest edges that do not touch one
another's neighbourhoods, so that a round is a handful of array operations.
"""
import numpy as np
from scipy import sparse


def edges_of(triangles):
    e = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    n = int(e.max()) + 1
    key = np.unique(e[:, 0].astype(np.int64) * n + e[:, 1])
    return np.stack([key // n, key % n], axis=1)


def _cross(p, t):
    return np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])


def _quadrics(p, t):
    """Area-weighted plane quadrics per vertex, as symmetric 4x4 matrices (n, 4, 4)."""
    c = _cross(p, t)
    area = np.linalg.norm(c, axis=1) + 1e-20
    n = c / area[:, None]
    plane = np.concatenate([n, -np.sum(n * p[t[:, 0]], axis=1, keepdims=True)], axis=1)
    q = (plane[:, :, None] * plane[:, None, :] * area[:, None, None]).reshape(-1, 16)
    out = np.zeros((len(p), 16))
    for k in range(16):
        out[:, k] = sum(np.bincount(t[:, corner], q[:, k], minlength=len(p)) for corner in range(3))
    return out.reshape(-1, 4, 4)


def _error(q, x):
    h = np.concatenate([x, np.ones((len(x), 1))], axis=1)
    return np.einsum("ni,nij,nj->n", h, q, h)


def _best(q, middle, length):
    """The point of least error, held near the edge's middle."""
    a = q[:, :3, :3].copy()
    damp = 0.02 * np.trace(a, axis1=1, axis2=2) + 1e-20
    a[:, range(3), range(3)] += damp[:, None]
    right = -q[:, :3, 3] + damp[:, None] * middle
    x = np.linalg.solve(a, right[:, :, None])[:, :, 0]
    far = np.linalg.norm(x - middle, axis=1) > length
    return np.where(far[:, None], middle, x)


def _independent(cost, edges, n, passes=3):
    """Cheap edges none of which touches another's neighbourhood, as a mask.

    Each pass takes the edges that are the cheapest of all that touch their ends' neighbourhoods, and
    withdraws those neighbourhoods.
    """
    rank = np.empty(len(edges), np.int64)
    rank[np.argsort(cost, kind="stable")] = np.arange(len(edges))
    taken = np.zeros(len(edges), bool)
    free = np.flatnonzero(np.isfinite(cost))
    free = free[np.argsort(-rank[free], kind="stable")]  # dearest first: the last assignment wins
    for _ in range(passes):
        e, r = edges[free], rank[free]
        best = np.full(n, len(edges))
        best[e.ravel()] = np.repeat(r, 2)
        ring = _least_around(best, edges)
        won = free[(ring[e[:, 0]] == r) & (ring[e[:, 1]] == r)]
        taken[won] = True
        near = np.zeros(n, np.int64)
        near[edges[won].ravel()] = -1
        near = _least_around(near, edges)
        free = free[(near[e] == 0).all(axis=1)]
    return taken


def _least_around(value, edges):
    """The least of each vertex's and its neighbours' values."""
    lower = np.minimum(value[edges[:, 0]], value[edges[:, 1]])
    order = np.argsort(-lower, kind="stable")
    out = value.copy()
    out[edges[order].ravel()] = np.repeat(lower[order], 2)
    return out


def _keeps_manifold(edges, chosen, n):
    """The link condition: the two ends share exactly two neighbours."""
    ones = np.ones(2 * len(edges), np.int32)
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    cols = np.concatenate([edges[:, 1], edges[:, 0]])
    adjacency = sparse.csr_matrix((ones, (rows, cols)), shape=(n, n))
    pair = edges[chosen]
    shared = adjacency[pair[:, 0]].multiply(adjacency[pair[:, 1]]).sum(axis=1)
    return np.asarray(shared).ravel() == 2


def _flips(p, t, edges, chosen, target):
    """Which chosen edges would turn a triangle over or crush it."""
    owner = np.full(len(p), -1)
    owner[edges[chosen].ravel()] = np.repeat(np.arange(len(chosen)), 2)
    of = owner[t]
    touched = (of >= 0).any(axis=1)
    t, of = t[touched], of[touched]
    e = of.max(axis=1)
    stays = (of == e[:, None]).sum(axis=1) == 1
    t, of, e = t[stays], of[stays], e[stays]
    moved = p[t]
    moved[of >= 0] = target[of[of >= 0]]
    before = _cross(p, t)
    after = np.cross(moved[:, 1] - moved[:, 0], moved[:, 2] - moved[:, 0])
    dot = np.sum(before * after, axis=1)
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    longest = np.max([np.sum((moved[:, i] - moved[:, i - 1]) ** 2, axis=1) for i in range(3)], axis=0)
    bad = (dot < 0.3 * size) | (np.linalg.norm(after, axis=1) < 0.06 * longest)
    out = np.zeros(len(chosen), bool)
    out[e[bad]] = True
    return out


def decimate(points, triangles, budget, longest, detail=None):
    """Collapse edges until at most `budget` vertices are left.

    longest: edges do not grow beyond this, m. detail: field (n, 3) -> (n,), how many times more an
    error counts there (a face is looked at more closely than a back).
    """
    p, t = points.copy(), triangles.copy()
    q = _quadrics(p, t)
    if detail is not None:
        q *= (detail(p) ** 2)[:, None, None]
    banned = np.empty(0, np.int64)
    while True:
        used = np.unique(t)
        if len(used) <= budget:
            break
        edges = edges_of(t)
        a, b = edges.T
        length = np.linalg.norm(p[a] - p[b], axis=1)
        both = q[a] + q[b]
        cost = _error(both, 0.5 * (p[a] + p[b])) + 1e-6 * length**2 * np.trace(both, axis1=1, axis2=2)
        cost[length > longest] = np.inf
        cost[np.isin(a * np.int64(len(p)) + b, banned)] = np.inf
        usable = np.isfinite(cost)
        limit = np.quantile(cost[usable], 0.4) if usable.any() else np.inf
        cost[cost > limit] = np.inf
        chosen = np.flatnonzero(_independent(cost, edges, len(p)))
        if not len(chosen):
            break
        chosen = chosen[np.argsort(cost[chosen], kind="stable")][: len(used) - budget]
        target = _best(both[chosen], 0.5 * (p[a[chosen]] + p[b[chosen]]), length[chosen])
        good = _keeps_manifold(edges, chosen, len(p)) & ~_flips(p, t, edges, chosen, target)
        refused = edges[chosen[~good]]
        banned = np.unique(np.concatenate([banned, refused[:, 0] * np.int64(len(p)) + refused[:, 1]]))
        chosen, target = chosen[good], target[good]
        if not len(chosen):
            continue
        keep, drop = edges[chosen].T
        p[keep] = target
        q[keep] += q[drop]
        rename = np.arange(len(p))
        rename[drop] = keep
        t = rename[t]
        t = t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])]
    used, t = np.unique(t, return_inverse=True)
    return p[used], t.reshape(-1, 3)
