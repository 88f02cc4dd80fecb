"""Baked ambient occlusion: the share of the sky that each vertex sees past the rest of the model."""
import numpy as np

from mesh import smoothing

VOXEL = 0.003
REACH = 0.40
RAYS = 40


def _solid_samples(parts, voxel):
    """Points on all triangles, dense enough that no voxel of a surface is missed."""
    for part in parts:
        a, b, c = (part.points[part.triangles[:, k]] for k in range(3))
        longest = np.max([np.linalg.norm(u - v, axis=1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
        steps = np.ceil(longest / (0.8 * voxel)).astype(int)
        for n in np.unique(steps):
            m = steps == n
            for i in range(n + 1):
                for j in range(n + 1 - i):
                    u, v = i / n, j / n
                    yield a[m] * (1 - u - v) + b[m] * u + c[m] * v


def _hemisphere():
    """Cosine-weighted directions about +z, a Fibonacci spiral: deterministic and even."""
    k = np.arange(RAYS) + 0.5
    r, angle = np.sqrt(k / RAYS), k * np.pi * (3 - np.sqrt(5))
    return np.stack([r * np.cos(angle), r * np.sin(angle), np.sqrt(1 - r * r)], axis=1)


def _frames(n):
    """Two tangents per normal."""
    helper = np.where(np.abs(n[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
    t = np.cross(helper, n)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    return t, np.cross(n, t)


def bake(parts, share, floor=0.2, voxel=VOXEL, reach=REACH):
    """Multiply the parts' colours by their openness to the sky, at least `floor`; of what is missing of it only
    share(part), (n,) or a number, is taken away."""
    everything = np.concatenate([p.points for p in parts])
    lo = everything.min(axis=0) - 4 * voxel
    shape = np.ceil((everything.max(axis=0) + 4 * voxel - lo) / voxel).astype(int) + 1
    filled = np.zeros(shape, bool)
    for points in _solid_samples(parts, voxel):
        filled[tuple(np.floor((points - lo) / voxel).astype(int).T)] = True
    flat = filled.ravel()
    stride = np.array([shape[1] * shape[2], shape[2], 1])

    distances = [1.7 * voxel]  # growing steps: near occluders matter more
    while distances[-1] < reach:
        distances.append(distances[-1] + max(voxel, 0.18 * distances[-1]))
    for part in parts:
        t, b = _frames(part.normals)
        start = part.points + 1.6 * voxel * part.normals
        seen = np.zeros(len(start))
        for x, y, z in _hemisphere():
            direction = x * t + y * b + z * part.normals
            opened = np.ones(len(start))
            for d in distances:
                cell = np.floor((start + d * direction - lo) / voxel).astype(int)
                ok = np.all((cell >= 0) & (cell < shape), axis=1)
                hit = np.zeros(len(start), bool)
                hit[ok] = flat[cell[ok] @ stride]
                opened = np.where(hit & (opened == 1), min(1.0, 0.75 * d / reach), opened)
            seen += opened
        light = seen / RAYS
        blur = smoothing(part.triangles, len(part.points))
        for _ in range(2):
            light = 0.5 * light + 0.5 * (blur @ light)
        part.colors = part.colors * np.maximum(1 - share(part) * (1 - light), floor)[:, None]
