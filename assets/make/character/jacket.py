"""The jacket of the gi above the belt: left over right, wide sleeves."""
import numpy as np

from character import jacket_shape, sheet
from character.body import trunk
from character.jacket_folds import folds
from character.jacket_shape import BELT, CUFF, FORE, PIT, lapel_centre, smooth
from character.lapels import over
from sdf import bump, intersect, limb, mirrored, ramp, subtract
from skeleton import joint, unit, vec

BOUNDS = (-0.72, 1.0, -0.25), (0.72, 1.56, 0.24)
_SHOULDER, _ELBOW, _WRIST = joint("LeftArm"), joint("LeftForeArm"), joint("LeftHand")
_WALL = 0.0085  # of the sleeves: what the mesh can still tell from a hole, however the folds go
_HEM = 0.0064  # of the band at their ends, which hides the wall
_FROM_MOUTH = 0.95  # the share of the light on the sleeves' insides that comes in there
_BAND = 0.0012  # how far a cuff's band lies over the sleeve, and its lining under it


def lining(p):
    """1 on the insides of the sleeves, 0 outside."""
    return ramp(-0.0042, -0.0065, smooth(p) - folds()(p)) * (np.abs(p[:, 0]) > 0.36)


def give(p):
    """Over what length the cloth spreads the bend of a limb, m: a raised arm lifts the side down to the belt."""
    q = mirrored(p)
    above_elbow = ramp(0.07, -0.20, (q - _ELBOW) @ FORE)
    side = 0.27 * bump(q, PIT, 0.25) * above_elbow
    return side + 0.05 * bump(q, _ELBOW, 0.09)


def below_elbow(p):
    """0 on the trunk and the upper arms, 1 on the lower sleeves."""
    q = mirrored(p)
    return ramp(-0.10, 0.02, (q - _ELBOW) @ FORE) * (q[:, 0] > 0.28)


def jacket(p):
    q = mirrored(p)
    height = folds()(p)
    outside = smooth(p) - height
    d = _openings(p, outside - over(p))
    d = intersect(d, BELT - 0.06 * p[:, 2] - 0.008 - p[:, 1], 0.004)
    along = (q - CUFF) @ FORE
    hollow = intersect(jacket_shape.fore_sleeve(q) - 0.7 * height + _WALL, -0.115 - along, 0.006)
    d = np.where(q[:, 0] > 0.36, subtract(np.maximum(d, along + 0.013), hollow, 0.002), d)
    return _seams(p, q, d)


def _openings(p, d):
    """Neck and front."""
    inner = -(trunk(p, -0.016))
    v = np.abs(p[:, 0]) - (lapel_centre(p[:, 1]) - 0.2 * jacket_shape.LAPEL)
    v = intersect(intersect(v, -p[:, 2] + 0.005, 0.008), 1.10 - p[:, 1], 0.01)
    d = subtract(d, intersect(v, inner, 0.004), 0.004)
    throat = limb(p, (0, 1.40, -0.020), (0, 1.62, -0.036), 0.0765, 0.0645)
    return subtract(d, intersect(throat, inner, 0.004), 0.003)


def _seams(p, q, d):
    """Grooves of stitching: the sleeve's seam, and the shoulder's."""
    d = d + 0.0010 * _at(_armhole(q), 0.005) * ramp(1.25, 1.31, p[:, 1]) * ramp(1.46, 1.42, p[:, 1])
    return d + 0.0014 * _at(p[:, 2] + 0.012, 0.004) * ramp(1.40, 1.43, p[:, 1]) * (_armhole(q) < 0)


def _armhole(q):
    """How far beyond the seam of the left sleeve, m."""
    return (q - _SHOULDER) @ unit(vec(1, -0.25, 0)) - 0.045


def _at(x, width):
    return np.exp(-((x / width) ** 2))


def paint(part):
    """Hollows keep their dye, ridges lose it."""
    height = folds()(part.points) * (1 - lining(part.points))
    sewn = 0.4 * _at(_armhole(mirrored(part.points)), 0.004) * ramp(1.25, 1.31, part.points[:, 1])
    part.colors *= (np.clip(1 + 26 * height, 0.70, 1.22) * (1 - sewn))[:, None]
    deep = ramp(-0.05, -0.105, (mirrored(part.points) - CUFF) @ FORE)  # less light gets there
    part.colors *= (1 - 0.7 * deep * lining(part.points))[:, None]


def face_the_mouth(part):
    """Turns the normals of the sleeves' insides to where their light comes from, the sleeve's mouth: the arm would take
    all light from cloth that faces it."""
    inside = lining(part.points)
    if part.name.startswith("Cuff"):
        q, n = mirrored(part.points), _mirrored_with(part, part.normals)
        off = q - CUFF - np.outer((q - CUFF) @ FORE, FORE)
        inside = ramp(-0.1, -0.5, np.sum(n * off, axis=1) / np.maximum(np.linalg.norm(off, axis=1), 1e-9))
    to = _mirrored_with(part, np.broadcast_to(FORE, part.points.shape))
    bent = part.normals + (_FROM_MOUTH * inside)[:, None] * (to - part.normals)
    part.normals = bent / np.linalg.norm(bent, axis=1, keepdims=True)


def _mirrored_with(part, directions):
    """Directions at the part's points, mirrored where the points are on the right."""
    return directions * np.where(part.points[:, :1] > 0, vec(1, 1, 1), vec(-1, 1, 1))


def cuff():
    """The left sleeve's hem: a band round its end that is sewn on, and the points of its outside."""
    away = np.concatenate([sheet.STEPS, [0.0236]])
    angles = np.arange(40) * 2 * np.pi / 40
    front = unit(vec(0, 0, 1) - FORE * FORE[2])
    out = np.outer(np.cos(angles), front) + np.outer(np.sin(angles), np.cross(front, FORE))
    relief, tint = sheet.hem(away)
    relief[-1] = -_BAND - 0.001  # its end goes into the sleeve
    thick = np.interp(away, [0, 0.013], [0.0042, _HEM + 2 * _BAND])
    plain = np.empty((40, len(away), 3))
    for k, distance in enumerate(away):
        near, far = np.full(40, 0.03), np.full(40, 0.12)
        for _ in range(24):
            middle = 0.5 * (near + far)
            p = CUFF - distance * FORE + vec(0, -0.006, 0) + middle[:, None] * out
            inside = jacket_shape.fore_sleeve(p) - folds()(p) < _BAND
            near, far = np.where(inside, middle, near), np.where(inside, far, middle)
        plain[:, k] = CUFF - distance * FORE + vec(0, -0.006, 0) + near[:, None] * out
    up = sheet.normals(plain, closed=True)
    up *= np.sign(np.sum(up * out[:, None], axis=2, keepdims=True))
    if np.sum(sheet.normals(plain, closed=True) * up) < 0:
        plain, up = plain[::-1], up[::-1]
    return sheet.slab("Cuff", "Gi", plain + up * relief[:, None], thick[:, None], np.tile(tint, (40, 1)), True, plain)
