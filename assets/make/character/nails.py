"""Finger nails: plates a little over the skin, under it at their sides and roots."""
import numpy as np

import nets
from character import hands
from mesh import Part, merge
from sdf import ramp
from skeleton import DIGITS, joint, tip, unit

# Nearest at the rim.
_UP = np.array([-1, -0.84, -0.4, 0.2, 0.62, 0.80, 1.0])
_ACROSS = np.array([-1, -0.80, -0.28, 0.28, 0.80, 1])


def _nail(name):
    """A digit's nail."""
    last = f"LeftHand{name}3"
    along, back = unit(tip(last) - joint(last)), hands.out_of_back(name)
    across, r = np.cross(back, along), hands.RADII[name][3]
    u, v = np.meshgrid(_UP, _ACROSS, indexing="ij")
    u, v = u.ravel(), v.ravel()
    s = (0.78 * r + 0.0010) * u * np.sqrt(1 - np.where(u < 0, 0.45, 0.25) * u**2 * v**2)
    angle = 0.88 * v * np.where(u < 0, 1 - 0.08 * u * u, 1.0)
    middle = tip(last) - 0.80 * r * along
    start = middle + np.outer(s, along) + 1.03 * r * np.outer(np.cos(0.9 * angle), back) + r * np.outer(np.sin(angle), across)
    points = nets.project(hands.skin, start, 0.02, 4)
    normals = nets.normals(hands.skin, points, 0.0006)
    rim = np.maximum(np.abs(v), -u)
    lift = 0.00055 - 0.0009 * ramp(0.80, 1.0, rim)
    free = ramp(0.70, 1.0, u) * (1 - 0.5 * v * v)
    points = points + lift[:, None] * normals + np.outer(0.0009 * free, along) + np.outer(0.0004 * free, back)
    n = len(_ACROSS)
    quads = [(n * i + k, n * i + k + 1, n * i + k + n + 1, n * i + k + n) for i in range(len(_UP) - 1) for k in range(n - 1)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    facing = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])
    if np.sum(facing * normals[triangles[:, 0]]) < 0:
        triangles = triangles[:, ::-1]
    part = Part("NailsL", "Nail", points, normals, triangles)
    part.tint(ramp(0.79, 0.98, rim), (0.42, 0.27, 0.24))  # the fold of skin round it
    part.tint(0.5 * ramp(0.6, 0.72, u) * (rim < 0.82), (1.0, 0.98, 0.90))
    part.tint((1 - ramp(0.58, 0.76, u)) * (rim < 0.82), (0.90, 0.74, 0.70))
    return part


def build():
    """The left hand's nails."""
    return merge("NailsL", "Nail", [_nail(name) for name in DIGITS])
