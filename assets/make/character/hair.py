"""Hair combed to a top knot, and the head band over it."""
import numpy as np

from character import head
from sdf import ellipsoid, intersect, limb, mirrored, ramp, rotation, subtract, union
from skeleton import vec

_KNOT = vec(0, 1.798, -0.050)


def _scalp(p):
    q = mirrored(p)
    d = ellipsoid(p, (0, 1.690, -0.016), (0.0825, 0.0985, 0.1035))
    d = union(d, ellipsoid(q, (0.030, 1.645, -0.050), (0.046, 0.072, 0.056)), 0.035)
    return union(d, head.skull(p, q) - 0.0045, 0.010)


def band_height(p):
    """Height over the middle of the band, which rises a little towards the back."""
    return p[:, 1] - (1.7130 - 0.10 * p[:, 2])


def _temple(p):
    """z of the hair line before the ears, by height."""
    return np.interp(p[:, 1], [1.60, 1.625, 1.66, 1.685, 1.705, 1.715], [-0.030, 0.012, 0.018, 0.036, 0.060, 0.30])


def hair(p):
    q = mirrored(p)
    d = _scalp(p)
    # Hair line: over the forehead under the band, down before the ears, round them, and to the nape.
    d = intersect(d, p[:, 2] - _temple(p), 0.008)
    nape = np.interp(p[:, 2], [-0.10, -0.03, 0.0, 0.03], [1.588, 1.592, 1.606, 1.628])
    nape = nape + 0.0025 * np.sin(p[:, 0] * 330 + 3 * np.sin(p[:, 0] * 70)) + 0.0020 * np.sin(p[:, 2] * 410)
    d = intersect(d, nape - p[:, 1], 0.010)
    d = subtract(d, ellipsoid(q, (0.086, 1.637, -0.008), (0.022, 0.037, 0.026)), 0.006)
    # Strands run to the knot: waves over the angle about it, fading at the band.
    v = p - _KNOT
    angle = np.arctan2(v[:, 0], v[:, 2] + 1e-9)
    far = np.linalg.norm(v, axis=1)
    bent = angle + 0.05 * np.sin(far * 30 + 3 * np.sin(3 * angle))
    wave = np.sin(bent * 29 + 2 * np.sin(5 * angle)) + 0.5 * np.sin(bent * 53 + 3 * np.sin(7 * angle)) * ramp(0.04, 0.07, far)
    up = band_height(p)
    above = ramp(0.012, 0.022, up) * ramp(0.022, 0.060, far)
    below = ramp(0.010, 0.030, -up)
    strand = np.sin(p[:, 0] * 640 + 5 * np.sin(p[:, 1] * 60)) * ramp(0.02, -0.03, p[:, 2]) + np.sin(p[:, 2] * 640 + 5 * np.sin(p[:, 1] * 60)) * ramp(0.03, 0.06, q[:, 0])
    d = d - 0.0010 * wave * above - 0.0007 * strand * below
    # Pressed in under the band, so that nothing pokes through it.
    d = np.maximum(d, np.where(np.abs(up) < 0.024, _scalp(p) + 0.0032 * ramp(0.023, 0.015, np.abs(up)), -1))
    return _top_knot(p, d)


def _top_knot(p, d):
    v = p - _KNOT
    turn = np.arctan2(v[:, 0], v[:, 1] + 1e-9)
    bun = ellipsoid(p, _KNOT, (0.027, 0.023, 0.029)) - 0.0013 * np.sin(turn * 8 + v[:, 2] * 160)
    d = union(d, limb(p, _KNOT - vec(0, 0.022, 0), _KNOT - vec(0, 0.012, 0), 0.017, 0.015), 0.010)
    tie = np.hypot(np.hypot(v[:, 0], v[:, 2]) - 0.0165, v[:, 1] + 0.0185) - 0.0032
    return union(union(d, bun, 0.005), tie, 0.001)


def band(p):
    """A cloth band 32 mm wide over hair and forehead, its knot and two tails behind."""
    # From where the hair thins out before the temples the band lies on the forehead's skin.
    hairy = intersect(_scalp(p), p[:, 2] - 0.045 + 0.25 * (1.70 - p[:, 1]), 0.030)
    under = union(hairy, head.head(p), 0.010)
    fold = 0.0007 * np.sin(band_height(p) * 420 + 3 * np.sin(p[:, 0] * 40) + p[:, 2] * 25)
    d = intersect(np.abs(under + 0.0030) - 0.0080 - fold, np.abs(band_height(p)) - 0.0160, 0.004)
    knot = ellipsoid(p, (0, 1.7240, -0.1265), (0.0150, 0.0125, 0.0095))
    knot = knot + 0.0014 * np.abs(np.sin(p[:, 0] * 260))
    return np.minimum(union(d, knot, 0.004), _tails(p))


def _tails(p):
    d = np.full(len(p), 9.0)
    for side, length, phase in ((0.030, 0.165, 0.0), (-0.036, 0.135, 1.3)):
        t = np.clip((1.722 - p[:, 1]) / length, 0, 1)
        x = side * t**0.8 + 0.006 * np.sin(5 * t + phase)
        z = -0.131 - 0.020 * np.sin(2.2 * t) - 0.004 * np.sin(7 * t + phase)
        twist = 0.5 * np.sin(3 * t + phase)
        u, w = p[:, 0] - x, p[:, 2] - z
        across = u * np.cos(twist) + w * np.sin(twist)
        thick = np.abs(-u * np.sin(twist) + w * np.cos(twist)) - 0.0026
        half = 0.010 + 0.006 * t
        s = intersect(np.abs(across) - half, thick, 0.002)
        s = intersect(s, np.maximum(p[:, 1] - 1.724, 1.722 - length - p[:, 1] + 0.25 * across), 0.002)
        d = np.minimum(d, 0.8 * s)
    return d
