"""Eye balls with iris and pupil, brows and lashes."""
import numpy as np

from character import head
from mesh import Part, mirror, sculpt
from sdf import intersect, sphere
from skeleton import unit, vec

_GAZE = unit(vec(0.03, -0.02, 1.0))
_SHUT = 0.62  # rad, by which an upper lid turns down


def _cap(radius, spread, rings, spokes, bulge=0.0):
    """Part of a sphere round +z, `spread` radians wide; points and triangles."""
    theta = np.linspace(0, spread, rings + 1)[1:]
    phi = np.arange(spokes) * 2 * np.pi / spokes
    t, f = np.meshgrid(theta, phi, indexing="ij")
    normal = np.stack([np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)], -1).reshape(-1, 3)
    normal = np.concatenate([[[0, 0, 1.0]], normal])
    height = radius + bulge * np.maximum(0, 1 - (np.arccos(np.clip(normal[:, 2], -1, 1)) / spread) ** 2)
    triangles = [(0, 1 + k, 1 + (k + 1) % spokes) for k in range(spokes)]
    for r in range(rings - 1):
        for k in range(spokes):
            a, b = 1 + r * spokes + k, 1 + r * spokes + (k + 1) % spokes
            triangles += [(a, a + spokes, b + spokes), (a, b + spokes, b)]
    return normal * height[:, None], normal, np.array(triangles)


def _placed(name, material, cap):
    points, normal, triangles = cap
    x = unit(np.cross(vec(0, 1, 0), _GAZE))
    turn = np.stack([x, np.cross(_GAZE, x), _GAZE], axis=1)
    return Part(name, material, points @ turn.T + head.EYE, normal @ turn.T, triangles)


def _brow(q):
    skin = head.head(q)
    t = (q[:, 0] - 0.0105) / 0.042
    s = np.clip(t, 0, 1)
    middle = 1.6745 + 0.0075 * np.sin(2.3 * s) - 0.0035 * s
    half = 0.0033 * (1 - 0.70 * s**1.6) * np.minimum(1, 0.55 + 3 * s)
    comb = 0.0002 * np.sin((q[:, 0] * 0.8 - q[:, 1]) * 2400)
    d = intersect(np.abs(skin + 0.0012) - 0.0020 - comb, np.abs(q[:, 1] - middle) - half, 0.0022)
    return intersect(d, np.abs(t - 0.5) * 0.042 - 0.021, 0.002)


def _lash(q):
    """The upper rim of the lid, dark."""
    rim = head.opening(q)
    shell = np.abs(sphere(q, head.EYE, head.EYE_RADIUS + 0.0013)) - 0.0011
    d = intersect(shell, np.abs(rim - 0.0001) - 0.0007, 0.0006)
    d = intersect(d, np.abs(q[:, 0] - head.EYE[0]) - 0.0155, 0.001)
    return intersect(d, head.EYE[1] + 0.0008 - q[:, 1], 0.001)


def _lid():
    """The part of the upper lid that comes down over the ball, at rest inside the fixed lid: a shell over angles
    about the axis along which it turns, and across. Its rim, dark with lashes, lies on the lower lid when it is shut."""
    radius = head.EYE_RADIUS + 0.0014
    rows = np.array([0, 0.04, 0.08, 0.12, 0.25, 0.40, 0.60, 0.80, 1.0])  # from the rim
    across, up = np.meshgrid(np.linspace(-1.05, 1.05, 17), rows, indexing="ij")
    u = np.clip(radius * np.sin(across) / 0.0158, -1, 1)
    rim = _SHUT - np.arcsin((0.0047 * (1 - u * u) ** 0.75 + 0.0007) / (radius * np.cos(across)))
    turn = (rim + (1.35 - rim) * up).ravel()
    a = across.ravel()
    normal = np.stack([np.sin(a), np.cos(a) * np.sin(turn), np.cos(a) * np.cos(turn)], axis=1)
    quads = [(9 * i + k, 9 * i + 9 + k, 9 * i + 10 + k, 9 * i + k + 1) for i in range(16) for k in range(8)]
    triangles = np.array([t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))])
    part = Part("LidL", "Skin", head.EYE + radius * normal, normal, triangles)
    part.tint(np.full(len(a), 1.0), (0.70, 0.60, 0.55))  # as shaded as the lids beside it
    part.tint(0.92 * (up.ravel() < 0.10), (0.10, 0.08, 0.08))
    return part


def lids():
    """Both upper lids."""
    left = _lid()
    return [left, mirror(left, "LidR")]


def glints():
    """The sky's reflection on each cornea, above the pupil on the side that the light comes from: smaller than what a
    picture of the whole figure resolves, it would be lost in a computed one."""
    x = unit(np.cross(vec(0, 1, 0), _GAZE))
    towards = unit(_GAZE + 0.16 * x + 0.20 * np.cross(_GAZE, x))
    side = unit(np.cross(vec(0, 1, 0), towards))
    points, normal, triangles = _cap(head.EYE_RADIUS + 0.0010, 0.075, 2, 12)
    turn = np.stack([side, np.cross(towards, side), towards], axis=1)
    return [
        Part(name, "EyeWhite", points @ turn.T + head.EYE * vec(sign, 1, 1), normal @ turn.T, triangles)
        for name, sign in (("GlintL", 1), ("GlintR", -1))
    ]


def build():
    left = [
        _placed("EyeL", "EyeWhite", _cap(head.EYE_RADIUS, 1.45, 10, 24)),
        _placed("IrisL", "Iris", _cap(head.EYE_RADIUS + 0.0003, 0.43, 5, 24, 0.0004)),
        _placed("PupilL", "Pupil", _cap(head.EYE_RADIUS + 0.0008, 0.19, 3, 16)),
        sculpt("BrowL", "Skin", _brow, (0.006, 1.662, 0.045), (0.058, 1.692, 0.100), 0.0011, 280),
        sculpt("LashL", "Hair", _lash, (0.012, 1.648, 0.068), (0.051, 1.662, 0.086), 0.0007, 240),
    ]
    eye, iris, brow = left[0], left[1], left[3]
    comb = 0.5 + 0.5 * np.sin((brow.points[:, 0] * 0.8 - brow.points[:, 1]) * 2400)
    brow.tint(0.84 + 0.05 * comb, (0.03, 0.03, 0.03))  # skin shows through
    towards = (eye.points - head.EYE) @ _GAZE / head.EYE_RADIUS
    eye.tint(0.5 * np.clip(1 - (towards - 0.55) / 0.4, 0, 1), (0.85, 0.62, 0.58))
    rim = np.linalg.norm(np.cross(iris.points - head.EYE, _GAZE), axis=1) / (head.EYE_RADIUS * np.sin(0.43))
    iris.tint(np.clip((rim - 0.75) / 0.25, 0, 1), (0.25, 0.22, 0.22))
    return left + [mirror(part, part.name[:-1] + "R") for part in left]
