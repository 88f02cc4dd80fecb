"""Signed distance fields: shapes and the operations that join them.

A field maps points (n, 3) in metres to distances (n,), negative inside. Blends and squashed shapes
are only nearly distances; the mesher corrects for it by Newton steps along the gradient.
"""
import numpy as np


def union(a, b, k):
    """Smooth minimum: the blend is at most k/4 thick where both surfaces meet."""
    h = np.maximum(k - np.abs(a - b), 0) / k
    return np.minimum(a, b) - h * h * k * 0.25


def intersect(a, b, k):
    return -union(-a, -b, k)


def subtract(a, b, k):
    return -union(-a, b, k)


def mirrored(p):
    """Points folded to x >= 0: describe the left half, get both."""
    q = p.copy()
    q[:, 0] = np.abs(q[:, 0])
    return q


def ramp(lo, hi, x):
    """Smooth step from 0 at lo to 1 at hi."""
    t = np.clip((x - lo) / (hi - lo), 0, 1)
    return t * t * (3 - 2 * t)


def bump(p, centre, radius):
    """1 at the centre, falling as a Gaussian; radius is a length or one per axis."""
    return np.exp(-np.sum(((p - np.asarray(centre, float)) / radius) ** 2, axis=1))


def _along(p, a, b):
    ab = b - a
    return np.clip((p - a) @ ab / (ab @ ab), 0, 1)


def segment(p, a, b):
    """Distance to a line segment."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return np.linalg.norm(p - a - np.outer(_along(p, a, b), b - a), axis=1)


def limb(p, a, b, ra, rb, thin=None, factor=1.0):
    """A cone with round ends from a (radius ra) to b (radius rb); `factor` < 1 flattens it along `thin`."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    if thin is not None:
        f = np.asarray(thin, float) / np.linalg.norm(thin)
        stretch = 1 / factor - 1
        p = p + np.outer((p - a) @ f, f) * stretch
        b = b + f * ((b - a) @ f) * stretch
    t = _along(p, a, b)
    d = np.linalg.norm(p - a - np.outer(t, b - a), axis=1) - (ra + (rb - ra) * t)
    return d if thin is None else d * (0.5 + 0.5 * factor)


def tube(p, points, radii, k=None):
    """Limbs through a chain of points, blended by k (default: half the thinnest radius)."""
    k = k or 0.5 * min(radii)
    d = limb(p, points[0], points[1], radii[0], radii[1])
    for i in range(1, len(points) - 1):
        d = union(d, limb(p, points[i], points[i + 1], radii[i], radii[i + 1]), k)
    return d


def ellipsoid(p, centre, radii, turn=None):
    """`turn`: rotation matrix whose columns are the ellipsoid's axes."""
    q = p - np.asarray(centre, float)
    if turn is not None:
        q = q @ turn
    r = np.asarray(radii, float)
    k0 = np.linalg.norm(q / r, axis=1)
    k1 = np.linalg.norm(q / (r * r), axis=1) + 1e-9
    return k0 * (k0 - 1) / k1


def sphere(p, centre, radius):
    return np.linalg.norm(p - np.asarray(centre, float), axis=1) - radius


def rotation(axis, angle):
    """Rotation matrix about a unit axis ('x', 'y', 'z' or a vector), radians."""
    a = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}.get(axis, axis) if isinstance(axis, str) else axis
    a = np.asarray(a, float) / np.linalg.norm(a)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


class Loft:
    """A column of superellipses: half widths in x and z and the centre's z, tabulated over y.

    The tables are smoothed, so that the silhouette has no kinks.
    """

    def __init__(self, y, half_x, half_z, centre_z, power=2.4, samples=200, smooth=31):
        self.y = np.linspace(y[0], y[-1], samples)
        kernel = np.hanning(smooth)
        kernel /= kernel.sum()

        def table(values):
            fine = np.interp(self.y, y, values)
            return np.convolve(np.pad(fine, smooth // 2, mode="edge"), kernel, "valid")

        self.a, self.b, self.c = table(half_x), table(half_z), table(centre_z)
        self.power = power

    def __call__(self, p, grow=0.0):
        a = np.interp(p[:, 1], self.y, self.a) + grow
        b = np.interp(p[:, 1], self.y, self.b) + grow
        z = p[:, 2] - np.interp(p[:, 1], self.y, self.c)
        n = self.power
        f = (np.abs(p[:, 0] / a) ** n + np.abs(z / b) ** n) ** (1 / n)
        return (f - 1) * np.minimum(a, b) * 0.95


def within(p, d, lo, hi, change):
    """Apply `change(p, d) -> d` only to the points inside a box: the rest is not touched by it."""
    m = np.all((p >= np.asarray(lo)) & (p <= np.asarray(hi)), axis=1)
    if m.any():
        d = d.copy()
        d[m] = change(p[m], d[m])
    return d
