"""The guard of cloth that covers fore arm, wrist and the back of the hand; a loop round the middle finger holds it."""
import numpy as np
from scipy.interpolate import PchipInterpolator

import nets
from character import hands
from character.cloth import crumple
from mesh import cut, normals_of, sculpt
from sdf import intersect, ramp, union
from skeleton import hand_frame, joint, tip, unit

_WRIST, _ALONG, _THUMB, _PALM = hand_frame()
_CLOTH = 0.0012  # m
# Where it ends: metres along the hand from the wrist, by the angle round the hand from the thumb's side over its back, degrees.
_END = PchipInterpolator(
    [-90, -50, -15, 5, 30, 55, 75, 90, 105, 130, 155, 180, 215, 270],
    [0.002, 0.002, 0.008, 0.020, 0.044, 0.070, 0.080, 0.083, 0.081, 0.075, 0.067, 0.050, 0.014, 0.002],
)
_LOOP = 0.0185, 0.0042  # m from the knuckle, and half its width
_CORDS = -0.006, 0.0, 0.006  # m along the hand: the turns of the cord round the wrist
_CORD = 0.0022  # half a turn's width, m


def _frame(p):
    v = p - _WRIST
    return v @ _ALONG, v @ _THUMB, v @ _PALM


def _loop(p):
    """The distance to the band round the middle finger and to the tongue that leads to it."""
    a, b = joint("LeftHandMiddle1"), tip("LeftHandMiddle1")
    along = unit(b - a)
    v = p - a
    s = v @ along
    off = v - np.outer(s, along)
    apart = np.linalg.norm(off, axis=1) - 0.0155
    band = np.maximum(np.abs(s - _LOOP[0]) - _LOOP[1], apart)
    across = np.abs(v @ _THUMB)
    tongue = np.maximum(across - (0.0060 - 0.18 * np.clip(-0.004 - s, -0.010, 0)), np.maximum(s - _LOOP[0], 0.002 + v @ _PALM))
    tongue = np.maximum(tongue, -0.030 - s)
    return union(band, tongue, 0.004)


def _sheet(p):
    """The distance to the edge of what covers the back of the hand."""
    x, y, z = _frame(p)
    angle = np.degrees(np.arctan2(-2.2 * z, y))
    angle = np.where(angle < -90, angle + 360, angle)
    return 0.85 * (x - _END(angle))


def edge(p):
    """The distance along the skin to the guard's edge; negative under it."""
    return union(_sheet(p), _loop(p), 0.008)


def _over(p):
    """How much the cloth is over the skin: creases at the wrist, the hem, and the cord."""
    x, y, z = _frame(p)
    e = edge(p)
    hem = 0.0010 * ramp(0.0, -0.0012, e) * ramp(-0.0062, -0.0046, e) - 0.0004 * np.exp(-(((e + 0.0052) / 0.0007) ** 2))
    angle = np.arctan2(-2.2 * z, y)
    bend = ramp(0.045, 0.020, x) * ramp(-0.080, -0.030, x)
    folds = bend * np.sin(330 * x + 1.6 * np.sin(2 * angle + 0.5) + 40 * y) * (0.6 + 0.4 * np.sin(3 * angle + 60 * x))
    cord = np.zeros(len(p))
    for at in _CORDS:
        t = (x - at - 0.0018 * np.sin(angle + 1.0)) / _CORD
        cord = np.maximum(cord, np.sqrt(np.clip(1 - t * t, 0, 1)))
    held = ramp(0.016, 0.004, np.abs(x))  # the cord ties it down
    finger = ramp(0.078, 0.088, x)
    inner = finger * ramp(-0.004, 0.003, z)  # nothing thick lies between the finger and what it holds
    hem = hem * (1 - 0.8 * finger)  # the loop is a thin band
    hem = hem * (1 - 0.7 * ramp(2.0, 2.6, np.abs(angle)))  # flat at the hand's edge, where its end is seen from the side
    return (1 - 0.6 * inner) * (_CLOTH + 0.0004 * finger) + (1 - inner) * hem + (1 - held) * (0.0009 * folds + 0.0004 * crumple(p, 1.0)) + 0.0019 * cord


def _outside(p):
    d = hands.skin(p) - _over(p)
    d = intersect(d, 0.8 * edge(p), 0.0018)
    return np.maximum(d, hands.depth(p) - 0.14)


def uncovered(p):
    """Which of the skin can be seen, or is so near to it that it may be when the hand is bent."""
    return (_sheet(p) > -0.0080) & (_loop(p) > -0.0030)


def kept(p):
    """Which of it the hand keeps: a bent finger's back would come out through the loop."""
    return uncovered(p) & ((_loop(p) > -0.0012) | (_frame(p)[2] > -0.002))


def _detail(p):
    """Where errors count more: at the edge; inside not at all."""
    return np.where(hands.skin(p) < -0.0012, 0.10, 0.30 + 2.2 * np.exp(-((edge(p) / 0.004) ** 2)))


def build():
    """The left guard. What it has under the skin goes well under it, as bent skin is not quite where it was."""
    whole = sculpt("GuardL", "GuardCloth", _outside, *hands.bounds(), 0.0010, 1320, 0.016, _detail)
    part = cut(whole, (hands.skin(whole.points) > -0.0003) & (hands.depth(whole.points) < 0.132))
    depth = hands.skin(part.points)
    inside = depth < 0.0001
    inward = np.where(inside, np.minimum(-0.0018 - depth, 0), 0)
    part.points = part.points + inward[:, None] * nets.normals(hands.skin, part.points, 0.0008)
    own = normals_of(lambda p: np.zeros(len(p)), part.points, part.triangles, 1.0)  # of the mesh: no field is there
    part.normals = np.where(inside[:, None], own, part.normals)
    return part


def paint(part, side):
    """Dark along its seam and beside the cord."""
    q = part.points * np.array([side, 1.0, 1.0])
    x, e = _frame(q)[0], edge(q)
    part.tint(0.9 * np.exp(-(((e + 0.0052) / 0.0010) ** 2)), (0.55, 0.55, 0.55))
    part.tint(0.5 * np.exp(-(((np.abs(x) - 0.009) / 0.0016) ** 2)), (0.4, 0.4, 0.4))
