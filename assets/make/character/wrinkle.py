"""Wrinkles by growth: cloth that is a little too large for the body buckles into folds.

A sheet is meshed on the smooth shape of a garment, its edges are given rest lengths that are a few
per cent too long, and it is relaxed by positions: edges seek their rest lengths, bending resists short
waves, gravity pulls down, and the sheet may neither sink into the body nor leave it far. What remains
of the motion is the height of the folds over the smooth shape.
"""
import numpy as np
from scipy import ndimage, sparse
from scipy.spatial import cKDTree

import nets
from decimate import edges_of
from mesh import smoothing

ROUNDS = 450
STIFFNESS = 0.12  # of bending, per round: sets the shortest wave
SOFTENING = 4
SAG = 2e-5  # m per round, downwards


class Wrinkles:
    """Heights (m) over the smooth shape, as a function of points near it.

    shape: field of the smooth garment, meshed between lo and hi at resolution h. growth: points and
    unit directions of edges -> relative excess length. loose: points -> (lowest, highest) height
    allowed, m; where both are 0 the sheet is pinned.
    """

    def __init__(self, shape, lo, hi, h, growth, loose, seed=1):
        rest, triangles = nets.surface(shape, lo, hi, h, rounds=2)
        normal = nets.normals(shape, rest, 0.35 * h)
        self.rest, self.normal, self.triangles = rest, normal, triangles
        self.height = self._relax(growth, loose, seed)
        self._bake(np.asarray(lo, float), np.asarray(hi, float), 0.8 * h, 1.1 * h)

    def _relax(self, growth, loose, seed):
        rest, normal = self.rest, self.normal
        e = edges_of(self.triangles)
        rows, ends = np.repeat(np.arange(len(e)), 2), e.ravel()
        difference = sparse.csr_matrix((np.tile([1.0, -1.0], len(e)), (rows, ends)), (len(e), len(rest)))
        share = sparse.diags(1 / np.bincount(ends, minlength=len(rest))) @ difference.T
        blur = smoothing(self.triangles, len(rest))
        span = difference @ rest
        length = np.linalg.norm(span, axis=1)
        wanted = length * (1 + growth(0.5 * (rest[e[:, 0]] + rest[e[:, 1]]), span / length[:, None]))
        lowest, highest = loose(rest)

        noise = np.random.default_rng(seed).normal(size=len(rest))
        for _ in range(12):
            noise = blur @ noise
        x = rest + normal * (0.004 * noise / noise.std())[:, None]
        for _ in range(ROUNDS):
            span = difference @ x
            excess = 1 - wanted / np.maximum(np.linalg.norm(span, axis=1), 1e-9)
            x = x - 0.9 * (share @ (span * excess[:, None]))
            bend = x - rest
            bend = bend - blur @ bend
            x = x - STIFFNESS * (bend - blur @ bend)
            x[:, 1] -= SAG
            height = np.sum((x - rest) * normal, axis=1)
            x = x + normal * (np.clip(height, lowest, highest) - height)[:, None]
        height = np.sum((x - rest) * normal, axis=1)
        for _ in range(SOFTENING):  # creases narrower than the sheet's mesh are its noise
            height = blur @ height
        return height

    def _bake(self, lo, hi, step, width):
        """Onto a grid round the surface, from which a cubic spline reads."""
        self._lo, self._step = lo, step
        shape = np.ceil((hi - lo) / step).astype(int) + 1
        near = np.zeros(shape, bool)
        near[tuple(np.clip(np.round((self.rest - lo) / step).astype(int), 0, shape - 1).T)] = True
        # As far as folds rise, and farther: a spline rings where its grid ends.
        near = ndimage.binary_dilation(near, iterations=7)
        cells = np.argwhere(near)
        distance, k = cKDTree(self.rest).query(lo + step * cells, k=16)
        w = np.exp(-((distance / width) ** 2)) + 1e-12
        grid = np.zeros(shape)
        grid[near] = (w * self.height[k]).sum(axis=1) / w.sum(axis=1)
        self._spline = ndimage.spline_filter(grid)

    def __call__(self, p):
        return ndimage.map_coordinates(self._spline, ((p - self._lo) / self._step).T, prefilter=False)
