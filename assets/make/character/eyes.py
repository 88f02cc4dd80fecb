"""Eye balls with iris and pupil, the lids that move and their lashes."""
import numpy as np

from character import brows, head
from mesh import Part, merge, mirror, sculpt
from sdf import intersect, ramp, sphere
from skeleton import unit, vec

_GAZE = unit(vec(0.03, -0.02, 1.0))
_SHUT = 0.70  # rad, by which an upper lid turns down
_IRIS = 0.43  # rad, of its rim from its middle
_CORNEA = 0.0010  # m, by which it bulges
_UNDER_LID = 0.0017  # m from the ball, of the lid that moves over it


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


def _lash(q):
    """The dark rim of the upper lid, where the part that moves ends: inside the fixed part."""
    rim = head.opening(q)
    shell = np.abs(sphere(q, head.EYE, head.EYE_RADIUS + 0.0021)) - 0.0013
    d = intersect(shell, np.abs(rim + 0.0006) - 0.0010, 0.0006)
    d = intersect(d, np.abs(q[:, 0] - head.EYE[0]) - 0.0155, 0.001)
    return intersect(d, head.EYE[1] + 0.0008 - q[:, 1], 0.001)


def _lid():
    """The part of the upper lid that comes down over the ball, at rest inside the fixed lid: a shell over angles
    about the axis along which it turns, and across. Its rim, dark with lashes, lies on the lower lid when it is shut."""
    radius = head.EYE_RADIUS + _UNDER_LID
    rows = np.array([0, 0.04, 0.08, 0.12, 0.25, 0.40, 0.60, 0.80, 1.0])  # from the rim
    across, up = np.meshgrid(np.linspace(-1.05, 1.05, 17), rows, indexing="ij")
    u = np.clip(radius * np.sin(across) / 0.0158, -1, 1)
    rim = _SHUT - np.arcsin((head.LOWER * (1 - u * u) ** 0.75 + 0.0007) / (radius * np.cos(across)))
    turn = (rim + (1.35 - rim) * up).ravel()
    a = across.ravel()
    normal = np.stack([np.sin(a), np.cos(a) * np.sin(turn), np.cos(a) * np.cos(turn)], axis=1)
    quads = [(9 * i + k, 9 * i + 9 + k, 9 * i + 10 + k, 9 * i + k + 1) for i in range(16) for k in range(8)]
    triangles = np.array([t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))])
    part = Part("LidL", "Skin", head.EYE + radius * normal, normal, triangles)
    part.tint(np.full(len(a), 1.0), head.LID_SHADE)
    part.tint(0.92 * (up.ravel() < 0.10), (0.10, 0.08, 0.08))
    return part


def lids():
    """Both upper lids."""
    left = _lid()
    return [left, mirror(left, "LidR")]


def glints():
    """The sky's reflection on each cornea, on the pupil's rim on the side that the light comes from: smaller than what a
    picture of the whole figure resolves, it would be lost in a computed one."""
    x = unit(np.cross(vec(0, 1, 0), _GAZE))
    towards = unit(_GAZE + 0.13 * x + 0.03 * np.cross(_GAZE, x))
    side = unit(np.cross(vec(0, 1, 0), towards))
    points, normal, triangles = _cap(head.EYE_RADIUS + 0.0014, 0.095, 2, 8)
    turn = np.stack([side, np.cross(towards, side), towards], axis=1)
    return [
        Part(name, "EyeWhite", points @ turn.T + head.EYE * vec(sign, 1, 1), normal @ turn.T, triangles)
        for name, sign in (("GlintL", 1), ("GlintR", -1))
    ]


def _paint_ball(eye):
    """Redder and darker towards the corners, and in the shade of both lids."""
    v = (eye.points - head.EYE) / head.EYE_RADIUS
    towards = v @ _GAZE
    eye.tint(np.ones(len(v)), (0.80, 0.77, 0.76))
    eye.tint(0.65 * np.clip(1 - (towards - 0.55) / 0.4, 0, 1), (0.74, 0.58, 0.54))
    eye.tint(0.80 * ramp(-0.12, 0.24, v[:, 1]), (0.38, 0.33, 0.33))
    eye.tint(0.40 * ramp(-0.20, -0.42, v[:, 1]), (0.52, 0.44, 0.42))


def _paint_iris(iris):
    """A dark rim, a brown disc of fibres, and a lighter ring round the pupil; darker above, where the lid shades it."""
    v = iris.points - head.EYE
    far = np.linalg.norm(np.cross(v, _GAZE), axis=1) / (head.EYE_RADIUS * np.sin(_IRIS))
    x = unit(np.cross(vec(0, 1, 0), _GAZE))
    turn = np.arctan2(v @ np.cross(_GAZE, x), v @ x)
    fibre = 0.5 + 0.5 * np.sin(17 * turn + 3 * np.sin(5 * turn)) * ramp(0.2, 0.5, far)
    ring = np.exp(-(((far - 0.56) / 0.13) ** 2))
    iris.tint(1 - ring * (0.75 + 0.25 * fibre), (0.34, 0.29, 0.25))
    iris.tint(0.30 * fibre, (0.60, 0.55, 0.50))
    iris.tint(ramp(0.72, 0.98, far), (0.10, 0.09, 0.09))
    iris.tint(0.70 * ramp(-0.0010, 0.0034, v[:, 1]), (0.36, 0.33, 0.33))


def build():
    rim = sculpt("LashL", "Lash", _lash, (0.012, 1.648, 0.068), (0.051, 1.662, 0.086), 0.0007, 140)
    left = [
        _placed("EyeL", "EyeWhite", _cap(head.EYE_RADIUS, 1.30, 7, 16)),
        _placed("IrisL", "Iris", _cap(head.EYE_RADIUS + 0.0003, _IRIS, 8, 22, _CORNEA)),
        _placed("PupilL", "Pupil", _cap(head.EYE_RADIUS + 0.00125, 0.175, 2, 16, 0.00018)),
        brows.brow(),
        merge("LashL", "Lash", [rim, brows.upper_lashes()]),
    ]
    _paint_ball(left[0])
    _paint_iris(left[1])
    return left + [mirror(part, part.name[:-1] + "R") for part in left]
