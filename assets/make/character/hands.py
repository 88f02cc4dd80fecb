"""The left hand and fore arm in a glove of leather. Finger radii are published: grips are closed against them."""
import numpy as np

import nets
from character.cloth import crumple
from character.weights import split
from mesh import Part, merge, sculpt
from sdf import bump, ellipsoid, intersect, limb, mirrored, ramp, sphere, union, within
from skeleton import DIGITS, FINGERS, REST, hand_frame, joint, tip, unit

# Radius at each joint and at the finger's end, m.
RADII = {
    "Index": (0.0104, 0.0093, 0.0084, 0.0071),
    "Middle": (0.0106, 0.0095, 0.0086, 0.0073),
    "Ring": (0.0101, 0.0091, 0.0082, 0.0069),
    "Pinky": (0.0089, 0.0080, 0.0072, 0.0061),
    "Thumb": (0.0142, 0.0114, 0.0106, 0.0082),
}
WRIST_SEAMS = 0.004, 0.010  # m above the wrist: where the cuff of the glove is sewn on
_WRIST, _ALONG, _THUMB, _PALM = hand_frame()


def place(along, thumb, palm):
    """A point in the hand's frame: metres from the wrist."""
    return _WRIST + along * _ALONG + thumb * _THUMB + palm * _PALM


def _digit(p, name):
    r, d = RADII[name], None
    for k in range(3):
        bone = f"LeftHand{name}{k + 1}"
        a, b = joint(bone), tip(bone)
        if k == 2:
            b = b - 0.75 * r[3] * unit(b - a)
        piece = limb(p, a, b, r[k], r[k + 1])
        d = piece if d is None else union(d, piece, 0.0015)
        if k and name != "Thumb":  # the knuckle stands out a little on the back
            d = union(d, sphere(p, a - 0.0016 * _PALM, 0.97 * r[k]), 0.0020)
    return d


def _back(name):
    """The end of a digit, its direction, and out of its back."""
    last = f"LeftHand{name}3"
    along = unit(tip(last) - joint(last))
    side = _THUMB if name != "Thumb" else unit(np.cross(_THUMB * 0.75 - _PALM * 0.65, along))
    return tip(last), along, unit(np.cross(along, side)) * (-1 if name != "Thumb" else 1)


def cap(name):
    """Leather over a digit's end, where it would wear through: a shell a little over the hand, under it at its rim."""
    end, along, back = _back(name)
    across, r = np.cross(back, along), RADII[name][3]
    u, v = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    u, v = u.ravel(), v.ravel()
    round_corner = np.sqrt(1 - 0.40 * u * u), np.sqrt(1 - 0.40 * v * v)
    length, angle = (0.0062 if name != "Thumb" else 0.0074) * u * round_corner[1], 0.85 * v * round_corner[0]
    start = end + np.outer(length - 0.0072, along)
    points = start + 1.1 * r * (np.outer(np.cos(angle), back) + np.outer(np.sin(angle), across))
    points = nets.project(hand, points, 0.02, 4)
    rim = np.maximum(np.abs(u), np.abs(v))
    lift = np.where(rim > 0.99, -0.0004, np.where(u > 0.7, 0.0006, 0.00035))
    normals = nets.normals(hand, points, 0.0005)
    points = points + lift[:, None] * normals
    quads = [(9 * i + k, 9 * i + k + 1, 9 * i + k + 10, 9 * i + k + 9) for i in range(8) for k in range(8)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    part = Part("Cap", "Glove", points, normals, triangles)
    facing = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])
    if np.sum(facing * normals[triangles[:, 0]]) < 0:
        part.triangles = triangles[:, ::-1]
    return part


def hand(p):
    elbow = joint("LeftForeArm")
    d = limb(p, elbow - 0.02 * _ALONG, elbow + 0.09 * _ALONG, 0.040, 0.044)
    d = union(d, limb(p, elbow + 0.08 * _ALONG, _WRIST, 0.043, 0.0275, _PALM, 0.80), 0.05)
    d = union(d, limb(p, _WRIST - 0.03 * _ALONG, place(0.02, 0, 0), 0.0262, 0.0285, _PALM, 0.68), 0.03)
    palm = np.full(len(p), 9.0)
    for name, r in (("Index", 0.0132), ("Middle", 0.0135), ("Ring", 0.0128), ("Pinky", 0.0116)):
        knuckle = joint(f"LeftHand{name}1")
        root = place(0.012, 0.55 * ((knuckle - _WRIST) @ _THUMB), 0)
        palm = union(palm, limb(p, root, knuckle + 0.001 * _PALM, 0.0152, r), 0.017)
    d = union(d, palm, 0.020)
    for name in FINGERS:  # knuckles, and the tendons that run to them
        knuckle = joint(f"LeftHand{name}1")
        d = union(d, sphere(p, knuckle - 0.0045 * _PALM, 0.78 * RADII[name][0] + 0.0012), 0.006)
        root = place(0.020, 0.5 * ((knuckle - _WRIST) @ _THUMB), -0.0135)
        d = union(d, limb(p, root, knuckle - 0.0105 * _PALM, 0.0022, 0.0024), 0.0045)
    d = union(d, ellipsoid(p, place(0.036, 0.022, 0.012), (0.023, 0.021, 0.016)), 0.016)  # thenar
    d = union(d, limb(p, place(0.018, -0.022, 0.007), place(0.055, -0.027, 0.006), 0.0135, 0.0115), 0.015)
    d = union(d, limb(p, place(0.030, 0.030, 0.004), place(0.080, 0.030, 0.001), 0.011, 0.008), 0.014)  # web
    lo, hi = bounds()
    return within(p, d, lo, hi, _with_digits)


def _with_digits(p, d):
    for name in FINGERS:
        d = union(d, _digit(p, name), 0.0050)
    return union(d, _digit(p, "Thumb"), 0.013)


def below_elbow(p):
    """Cut inside the sleeve."""
    return intersect(hand(p), depth(p) - 0.14, 0.003)


def depth(p):
    """How far up the fore arm from the wrist, m, of either arm."""
    return (_WRIST - mirrored(p)) @ _ALONG


def bounds():
    """Opposite corners of a box that holds what below_elbow leaves."""
    points = [place(a, b, 0) for a in (-0.15, 0) for b in (-0.02, 0.02)] + [tip(f"LeftHand{d}3") for d in DIGITS]
    return np.min(points, axis=0) - 0.045, np.max(points, axis=0) + 0.045


def build():
    """The left hand in its glove, with a cap on every digit."""
    glove = sculpt("HandL", "Glove", below_elbow, *bounds(), 0.0018, 2500, 0.012)
    return merge("HandL", "Glove", [glove] + [cap(name) for name in DIGITS])


def weights(points, blur):
    """(n, bones) for the left hand: digits by nearness, phalanges by planes through the joints.

    blur: sparse neighbour mean of the mesh. A phalanx gives way to the next within +-`soft` of the
    plane that halves the angle of the joint: narrow enough to bend like a knuckle.
    """
    n = len(points)
    nearness = np.empty((n, 6))
    for c, name in enumerate(DIGITS):
        r = RADII[name]
        nearness[:, c] = np.min(
            [
                np.linalg.norm(points - _on(points, f"LeftHand{name}{k + 1}"), axis=1) - 0.5 * (r[k] + r[k + 1])
                for k in range(3)
            ],
            axis=0,
        )
    nearness[:, 5] = 9
    member = np.zeros((n, 5))
    member[np.arange(n), np.argmin(nearness[:, :5], axis=1)] = 1
    for _ in range(2):
        member = 0.5 * member + 0.5 * (blur @ member)
    out = np.zeros((n, len(REST.names)))
    hand_part = np.zeros(n)
    for c, name in enumerate(DIGITS):
        # The web between two digits goes with the hand, not with the other digit.
        share = member[:, c] * ramp(0.010, 0.003, nearness[:, c])
        chain = [f"LeftHand{name}{k}" for k in (1, 2, 3)]
        steps = [_past(points, bone, name, k) for k, bone in enumerate(chain)] + [np.zeros(n)]
        hand_part += share * (1 - steps[0])
        for k, bone in enumerate(chain):
            out[:, REST.index(bone)] = share * steps[k] * (1 - steps[k + 1])
    x = (points - _WRIST) @ _ALONG
    t = np.clip((x + 0.030) / 0.042, 0, 1)
    turned = t * t * (3 - 2 * t)
    hand_part += 1 - (hand_part + out.sum(axis=1))
    out[:, REST.index("LeftHand")] = hand_part * turned
    out[:, REST.index("LeftForeArm")] = hand_part * (1 - turned)
    out /= out.sum(axis=1, keepdims=True)
    for _ in range(1):
        out = 0.6 * out + 0.4 * (blur @ out)
    return out


def _on(points, bone):
    a, b = joint(bone), tip(bone)
    t = np.clip((points - a) @ (b - a) / np.sum((b - a) ** 2), 0, 1)
    return a + np.outer(t, b - a)


def _past(points, bone, name, k):
    """0 before the joint where `bone` starts, 1 after it."""
    a = joint(bone)
    before = unit(a - joint(REST.parent[bone])) if k else (_ALONG if name != "Thumb" else unit(tip(bone) - a))
    normal = unit(before + unit(tip(bone) - a))
    soft = (0.0075, 0.0055, 0.0048)[k] if name != "Thumb" else (0.016, 0.0075, 0.0060)[k]
    t = np.clip(((points - a) @ normal + soft) / (2 * soft), 0, 1)
    return t * t * (3 - 2 * t)


def _beside(q):
    """Which digit a point (n,) is on, -1: none; and how far it is out of the plane of that digit's seam, m."""
    near = np.empty((len(DIGITS), len(q)))
    over = np.empty_like(near)
    for c, name in enumerate(DIGITS):
        chain = [f"LeftHand{name}{k}" for k in (1, 2, 3)]
        away = np.stack([q - _on(q, bone) for bone in chain])
        size = np.linalg.norm(away, axis=2)
        nearest = np.argmin(size, axis=0)
        near[c] = size.min(axis=0)
        over[c] = away[nearest, np.arange(len(q))] @ _back(name)[2]
        begun = (q - joint(chain[0])) @ unit(tip(chain[0]) - joint(chain[0])) > (0.012 if name != "Thumb" else 0.018)
        near[c][~begun] = 9
    digit = np.argmin(near, axis=0)
    columns = np.arange(len(q))
    return np.where(near[digit, columns] < 0.020, digit, -1), over[digit, columns]


def sew(part):
    """Vertices along the wrist's seams, for their colour; the surface stays what it is."""
    for line in [edge for at in WRIST_SEAMS for edge in (at - 0.0018, at, at + 0.0018)]:
        split(part, depth(part.points) - line)


def paint(part, side):
    """Leather: dark in its seams, worn light on the knuckles, uneven."""
    q = part.points * np.array([side, 1.0, 1.0])
    part.colors *= (0.64 + 0.08 * crumple(q, 0.45))[:, None]
    back = ramp(0.002, -0.006, (q - _WRIST) @ _PALM)
    for name in FINGERS:
        for k in (1, 2, 3):
            at = joint(f"LeftHand{name}{k}") - (0.0050, 0.0040, 0.0034)[k - 1] * _PALM
            size = (0.0125, 0.0085, 0.0070)[k - 1]
            part.tint(bump(q, at, size) * back, (1.45, 1.50, 1.60))
            ring = np.exp(-(((np.linalg.norm(q - at, axis=1) - 1.15 * size) / 0.0030) ** 2))
            part.tint(0.42 * ring * back, (0.40, 0.38, 0.36))
    digit, over = _beside(q)
    part.tint(0.55 * np.exp(-((over / 0.0022) ** 2)) * (digit >= 0), (0.30, 0.28, 0.26))
    for at in WRIST_SEAMS:
        part.tint(0.85 * np.exp(-(((depth(part.points) - at) / 0.0010) ** 2)), (0.28, 0.26, 0.24))
    part.tint(0.80 * ramp(WRIST_SEAMS[1], WRIST_SEAMS[1] + 0.002, depth(part.points)), (0.58, 0.58, 0.58))
