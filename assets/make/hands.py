"""The left hand and fore arm. Finger radii are published: grips are closed against them."""
import numpy as np

from sdf import bump, ellipsoid, intersect, limb, sphere, union, within
from skeleton import DIGITS, FINGERS, REST, hand_frame, joint, tip, unit

# Radius at each joint and at the finger's end, m.
RADII = {
    "Index": (0.0098, 0.0088, 0.0079, 0.0066),
    "Middle": (0.0100, 0.0090, 0.0081, 0.0068),
    "Ring": (0.0095, 0.0086, 0.0077, 0.0064),
    "Pinky": (0.0084, 0.0076, 0.0068, 0.0057),
    "Thumb": (0.0140, 0.0110, 0.0100, 0.0078),
}
_WRIST, _ALONG, _THUMB, _PALM = hand_frame()


def place(along, thumb, palm):
    """A point in the hand's frame: metres from the wrist."""
    return _WRIST + along * _ALONG + thumb * _THUMB + palm * _PALM


def _digit(p, name, blend):
    r, d = RADII[name], None
    for k in range(3):
        bone = f"LeftHand{name}{k + 1}"
        a, b = joint(bone), tip(bone)
        if k == 2:
            b = b - 0.004 * unit(b - a)
        piece = limb(p, a, b, r[k], r[k + 1])
        d = piece if d is None else union(d, piece, blend)
        if k and name != "Thumb":  # the knuckle stands out a little on the back
            d = union(d, sphere(p, a - 0.0012 * _PALM, r[k] * 1.0), 0.004)
    return union(d, _nail(p, name), 0.0010)


def _nail(p, name):
    last = f"LeftHand{name}3"
    end = tip(last)
    along = unit(end - joint(last))
    back = -_PALM if name != "Thumb" else unit(np.cross(along, np.cross(_THUMB * 0.75 - _PALM * 0.65, along)))
    across = np.cross(back, along)
    r = RADII[name][3]
    wide = 1.35 if name == "Thumb" else 1.0
    return ellipsoid(
        p, end - 0.0065 * along + back * (r - 0.0004), (0.0064 * wide, 0.0046 * wide, 0.0015), np.stack([along, across, back], 1)
    )


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
    d = union(d, ellipsoid(p, place(0.036, 0.022, 0.012), (0.023, 0.021, 0.016)), 0.016)  # thenar
    d = union(d, limb(p, place(0.018, -0.022, 0.007), place(0.055, -0.027, 0.006), 0.0135, 0.0115), 0.015)
    d = union(d, limb(p, place(0.030, 0.030, 0.004), place(0.080, 0.030, 0.001), 0.011, 0.008), 0.014)  # web
    d = within(p, d, place(0, 0, 0) - 0.11, place(0.11, 0, 0) + 0.13, _with_digits)
    return d


def _with_digits(p, d):
    for name in FINGERS:
        d = union(d, _digit(p, name, 0.0035), 0.0055)
    return union(d, _digit(p, "Thumb", 0.005), 0.013)


def below_elbow(p):
    """Cut inside the sleeve."""
    return intersect(hand(p), -((p - (_WRIST - 0.15 * _ALONG)) @ _ALONG), 0.003)


def bounds():
    """Opposite corners of a box that holds what below_elbow leaves."""
    points = [place(a, b, 0) for a in (-0.15, 0) for b in (-0.02, 0.02)] + [tip(f"LeftHand{d}3") for d in DIGITS]
    return np.min(points, axis=0) - 0.045, np.max(points, axis=0) + 0.045


def weights(points, blur):
    """(n, 52) for the left hand: digits by nearness, phalanges by planes through the joints.

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
        share = member[:, c]
        chain = [f"LeftHand{name}{k}" for k in (1, 2, 3)]
        steps = [_past(points, bone, name, k) for k, bone in enumerate(chain)] + [np.zeros(n)]
        hand_part += share * (1 - steps[0])
        for k, bone in enumerate(chain):
            out[:, REST.index(bone)] = share * steps[k] * (1 - steps[k + 1])
    x = (points - _WRIST) @ _ALONG
    t = np.clip((x + 0.030) / 0.042, 0, 1)
    turned = t * t * (3 - 2 * t)
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


def paint(part, side):
    q = part.points * np.array([side, 1.0, 1.0])
    for name in FINGERS:
        for k in (1, 2):
            part.tint(0.35 * bump(q, joint(f"LeftHand{name}{k}") - 0.006 * _PALM, 0.009), (0.90, 0.68, 0.60))
    for name in DIGITS:
        part.tint(0.50 * bump(q, tip(f"LeftHand{name}3") + 0.003 * _PALM, 0.011), (0.96, 0.70, 0.64))
        last = f"LeftHand{name}3"
        nail = _nail(q, name) < 0.0004
        part.tint(0.55 * nail, (1.0, 0.86, 0.84))
    part.tint(0.30 * bump(q, place(0.05, 0, 0.02), (0.035, 0.035, 0.02)), (0.98, 0.80, 0.74))
