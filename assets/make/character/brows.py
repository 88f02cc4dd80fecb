"""Brows and lashes: tapered hairs, a triangle each."""
import numpy as np

import nets
from character import head
from mesh import Part
from sdf import ramp
from skeleton import vec

_SEED = 11


def _middle(s):
    """The brow's middle line from the nose (0) to the temple (1)."""
    x = 0.0125 + 0.0420 * s
    y = np.interp(s, [0, 0.3, 0.62, 0.8, 1.0], [1.6736, 1.6749, 1.6763, 1.6763, 1.6752])
    return np.stack([x, y, np.full_like(x, 0.085)], axis=-1)


def _half(s):
    return 0.0043 * np.minimum(1, 0.38 + 2.2 * s) * (1 - 0.78 * np.clip((s - 0.35) / 0.65, 0, 1) ** 1.3)


def _on_skin(p, over):
    """Points moved ahead or back to lie so far over the skin."""
    near, far = np.full(len(p), 0.02), np.full(len(p), 0.13)
    for _ in range(20):
        z = 0.5 * (near + far)
        out = head.head(np.column_stack([p[:, :2], z])) > over
        near, far = np.where(out, near, z), np.where(out, z, far)
    return np.column_stack([p[:, :2], near])


def _hairs(name, root, way, out, width):
    """Hairs from root (n, 3) by way (n, 3), each a triangle that lies across out (n, 3), the normals."""
    n = len(root)
    side = unit3(np.cross(out, way)) * width
    points = np.stack([root - side, root + way, root + side], axis=1).reshape(-1, 3)
    triangles = np.arange(3 * n).reshape(-1, 3)
    corner = points[triangles]
    turned = np.sum(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) * out, axis=1) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    return Part(name, "Lash", points, np.repeat(out, 3, axis=0), triangles)


def brow():
    """The left brow: hairs rise at its inner end, lie along it, and fall to it from above at the outer end."""
    rng = np.random.default_rng(_SEED)
    n = 160
    s = rng.permutation(np.linspace(0.02, 1.0, n) ** 1.3 * 0.95)
    over = rng.uniform(-0.55, 0.85, n)  # the lowest grow where the shade begins
    root = _middle(s) + np.stack([rng.normal(0, 0.0005, n), over * _half(s), np.zeros(n)], axis=1)
    along = unit3(_middle(s + 0.02) - _middle(s - 0.02))
    lean = np.interp(s, [0, 0.10, 0.30, 0.7, 1.0], [0.60, 0.50, 0.32, 0.12, 0.0]) - 0.40 * over * np.minimum(1, 0.3 + 2 * s)
    lean = lean + rng.normal(0, 0.11, n)
    way = along * np.cos(lean)[:, None] + vec(0, 1, 0) * np.sin(lean)[:, None]
    length = np.interp(s, [0, 0.2, 0.6, 1.0], [0.0028, 0.0052, 0.0062, 0.0040]) * rng.uniform(0.75, 1.15, n)
    root = _on_skin(root, 0.0003)
    end = _on_skin(root + way * length[:, None], 0.0010)
    return _hairs("BrowL", root, end - root, nets.normals(head.head, root, 0.001), 0.00026)


def under(q):
    """How much of the skin at q, folded to the left, is dark below the brow's hairs: its whole shape, with a soft edge."""
    s = (q[:, 0] - 0.0125) / 0.0420
    inside = ramp(-0.08, 0.30, s) * ramp(1.10, 0.70, s) * (q[:, 2] > 0.03)
    away = np.abs(q[:, 1] - _middle(np.clip(s, 0, 1))[:, 1] - 0.0012) - _half(np.clip(s, 0, 1))
    return inside * ramp(0.0024, -0.0022, away)


def unit3(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def upper_lashes():
    """Along the upper lid's rim, longest towards the outer corner; they rise from the rim and curl out."""
    rng = np.random.default_rng(_SEED + 1)
    n = 30
    u = np.linspace(-0.86, 0.99, n)
    x = head.EYE[0] + u * 0.0155
    y = head.EYE[1] + 0.05 * u * 0.0155 + head.UPPER * (1 - u * u) ** 0.60
    radius = head.EYE_RADIUS + 0.0029
    z = head.EYE[2] + np.sqrt(np.maximum(radius**2 - (x - head.EYE[0]) ** 2 - (y - head.EYE[1]) ** 2, 1e-6))
    root = np.stack([x, y, z], axis=1)
    out = unit3(root - head.EYE)
    fan = 0.55 * u + rng.normal(0, 0.07, n)
    way = unit3(np.stack([np.sin(fan), np.full(n, 0.55), np.full(n, 0.80)], axis=1) + 0.25 * out)
    length = np.interp(u, [-0.9, -0.2, 0.6, 1.0], [0.0024, 0.0042, 0.0056, 0.0046]) * rng.uniform(0.85, 1.1, n)
    above = unit3(np.cross(np.cross(way, vec(0, 1, 0)), way))
    return _hairs("Lash", root, way * length[:, None], above, 0.00030)
