"""The garden behind the paper, as the paper shows it: bamboo and shrubs take a little of the daylight.

A wall's place is (u, y): metres along it and above the floor. What stands there is half a metre behind the paper, and the
sky is wide: edges are soft, nothing is darker than half.
"""
import numpy as np
from scipy import ndimage

_STEP = 0.01  # m, of the picture that is kept
_HIGH = 2.2  # m
_SOFT = 0.036  # m, of an edge


def _bar(place, ends, radius, soft=_SOFT):
    """How far a place is inside a bar with round ends: 0 to 1. `radius` at either end."""
    a, b = (np.asarray(e, float) for e in ends)
    axis = b - a
    t = np.clip((place - a) @ axis / (axis @ axis), 0, 1)
    away = np.linalg.norm(place - a - t[:, None] * axis, axis=1) - (radius[0] + t * (radius[1] - radius[0]))
    s = np.clip(0.5 - away / (2 * soft), 0, 1)
    return s * s * (3 - 2 * s)


def _stalk(rng, u):
    """Bamboo: a stalk that leans, and leaves that hang from its upper joints. Bars of (ends, radii, dark)."""
    lean, thick, dark = rng.uniform(-0.10, 0.10), rng.uniform(0.018, 0.032), rng.uniform(0.20, 0.42)
    bars = [(((u - lean, 0.2), (u + lean, 2.4)), (1.15 * thick, 0.8 * thick), dark)]
    for y in np.arange(1.25 + 0.3 * rng.random(), 2.2, 0.31):
        joint = np.array([u - lean + 2 * lean * (y - 0.2) / 2.2, y])
        side = rng.choice((-1, 1))
        for _ in range(rng.integers(2, 4)):
            twig = joint + (side * rng.uniform(0.02, 0.16), rng.uniform(-0.02, 0.12))
            turn, long = rng.uniform(0.1, 1.2), rng.uniform(0.24, 0.36)
            tip = twig + long * np.array([side * np.cos(turn), -np.sin(turn)])
            bars.append(((twig, tip), (0.024, 0.003), dark * rng.uniform(0.7, 1.0)))
    return bars


def _bushes(place, rng):
    """Shrubs along the ground, farther away and softer."""
    height = 0.62 + sum(a * np.sin(f * place[:, 0] + rng.uniform(0, 6.3)) for a, f in ((0.14, 1.3), (0.08, 3.1), (0.04, 7.7)))
    s = np.clip((height - place[:, 1]) / 0.36 + 0.5, 0, 1)
    return 0.26 * s * s * (3 - 2 * s)


class Garden:
    """What is behind one wall, from u = first to last."""

    def __init__(self, seed, first, last):
        rng = np.random.default_rng(seed)
        bars, u = [], first + rng.uniform(0.1, 0.6)
        while u < last:
            for _ in range(rng.integers(1, 4)):  # stalks stand in groups
                bars += _stalk(rng, u)
                u += rng.uniform(0.14, 0.34)
            u += rng.uniform(0.7, 1.5)
        self.first = first
        us, ys = np.arange(first, last + _STEP, _STEP), np.arange(0, _HIGH, _STEP)
        place = np.stack(np.meshgrid(us, ys, indexing="ij"), axis=-1)
        self.left = 1 - _bushes(place.reshape(-1, 2), rng).reshape(place.shape[:2])
        for (a, b), radius, dark in bars:
            far = max(radius) + _SOFT
            low, high = np.minimum(a, b) - far - (first, 0), np.maximum(a, b) + far - (first, 0)
            part = tuple(slice(max(int(x / _STEP), 0), max(int(y / _STEP) + 2, 0)) for x, y in zip(low, high))
            at = place[part]
            self.left[part] *= 1 - dark * _bar(at.reshape(-1, 2), (a, b), radius).reshape(at.shape[:2])

    def cells(self, u, y, wide, tall):
        """How many cells, along either side, show a pane's light: more where it varies."""
        (i, k), (j, m) = (((int(x / _STEP)), int((x + d) / _STEP)) for x, d in ((u - self.first, wide), (y, tall)))
        part = self.left[i:k, j:m]
        if part.shape[0] < 2:
            return 1, 1
        steep = (np.abs(np.diff(part, axis=axis)).max() / _STEP for axis in (0, 1))  # 1/m
        return tuple(1 + int(np.clip(0.9 * x, 0, 5)) for x in steep)

    def light(self, place):
        """The share of the daylight that is left at places (n, 2)."""
        return ndimage.map_coordinates(self.left, ((place - (self.first, 0)) / _STEP).T, order=1, mode="nearest")
