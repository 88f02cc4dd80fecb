"""The left hand and fore arm. Finger radii are published: grips are closed against them."""
import numpy as np

from character import guard
from mesh import cut, sculpt
from sdf import bump, ellipsoid, intersect, limb, mirrored, ramp, tube, union, within
from skeleton import DIGITS, FINGERS, REST, hand_frame, joint, tip, unit

# Radius at each joint and at the finger's end, m.
RADII = {
    "Index": (0.0104, 0.0093, 0.0084, 0.0071),
    "Middle": (0.0106, 0.0095, 0.0086, 0.0073),
    "Ring": (0.0101, 0.0091, 0.0082, 0.0069),
    "Pinky": (0.0089, 0.0080, 0.0072, 0.0061),
    "Thumb": (0.0142, 0.0114, 0.0106, 0.0082),
}
_WRIST, _ALONG, _THUMB, _PALM = hand_frame()


def place(along, thumb, palm):
    """A point in the hand's frame: metres from the wrist."""
    return _WRIST + along * _ALONG + thumb * _THUMB + palm * _PALM


# Of the outer two joints: how far over the joint the knuckle's middle is, and its half height, by the joint's radius; of fingers, then
# of thumbs.
_KNOBS = (((0.52, 0.80), (0.38, 0.74)), ((0.40, 0.78), (0.36, 0.76)))


def _digit(p, name):
    """Bones under skin: narrower between the joints, whose backs stand out. Skin that follows two bones sinks in where
    they bend, so that a knuckle is higher at rest than on a bent finger."""
    r, d = RADII[name], None
    back = out_of_back(name)
    for k in range(3):
        bone = f"LeftHand{name}{k + 1}"
        a, b = joint(bone), tip(bone)
        along = unit(b - a)
        if k == 2:
            b = b - 0.80 * r[3] * along
        waist = (0.47 if name == "Thumb" else 0.50 if k == 0 else 0.47) * (r[k] + r[k + 1])  # fleshy at the root
        piece = tube(p, [a, 0.5 * (a + b), b], [r[k], waist, r[k + 1]], 0.004)
        d = piece if d is None else union(d, piece, 0.0015)
        if k:
            across = np.cross(back, along)
            turn = np.stack([along, across, back], axis=1)
            height, size = _KNOBS[name == "Thumb"][k - 1]
            knob = ellipsoid(p, a + height * r[k] * back, (0.62 * r[k], 0.74 * r[k], size * r[k]), turn)
            d = union(d, knob, 0.0035)
        pad = 0.5 * (a + b) - 0.28 * r[k] * back  # flesh between the creases
        d = union(d, limb(p, pad - 0.005 * along, pad + 0.004 * along, 0.80 * r[k + 1], 0.80 * r[k + 1]), 0.003)
    return d


def out_of_back(name):
    """Out of a digit's back."""
    last = f"LeftHand{name}3"
    along = unit(tip(last) - joint(last))
    side = _THUMB if name != "Thumb" else unit(np.cross(_THUMB * 0.75 - _PALM * 0.65, along))
    return unit(np.cross(along, side)) * (-1 if name != "Thumb" else 1)


def creases(p):
    """Where skin folds at the fingers' joints, 0 to 1: wrinkles over the knuckles, a deep line below them."""
    out = np.zeros(len(p))
    for name in DIGITS:
        back, r = out_of_back(name), RADII[name]
        for k in (1, 2):
            bone = f"LeftHand{name}{k + 1}"
            v = p - joint(bone)
            near = np.linalg.norm(v, axis=1) < 2.2 * r[k]
            if not near.any():
                continue
            v = v[near]
            along = unit(unit(joint(bone) - joint(f"LeftHand{name}{k}")) + unit(tip(bone) - joint(bone)))
            s, up = v @ along, v @ back
            side = v @ np.cross(back, along)
            over = ramp(0.10 * r[k], 0.60 * r[k], up)
            wave = s + 0.0005 * np.sin(900 * side + 2 * k) - 14 * side * side
            lines = ((-0.0034, 0.6), (-0.0010, 1.0), (0.0016, 0.9), (0.0042, 0.5)) if k == 1 else ((-0.0012, 0.9), (0.0014, 0.7))
            line = sum(share * np.exp(-(((wave - at) / 0.00062) ** 2)) for at, share in lines)
            under = ramp(0.0, -0.5 * r[k], up) * np.exp(-((s / 0.0009) ** 2))
            out[near] = np.maximum(out[near], np.maximum(over * line, under))
    return out


def skin(p):
    """The hand and the fore arm without the skin's folds."""
    elbow = joint("LeftForeArm")
    d = limb(p, elbow - 0.02 * _ALONG, elbow + 0.09 * _ALONG, 0.040, 0.044)
    d = union(d, limb(p, elbow + 0.08 * _ALONG, _WRIST, 0.043, 0.0275, _PALM, 0.80), 0.05)
    d = union(d, limb(p, _WRIST - 0.03 * _ALONG, place(0.02, 0, 0), 0.0262, 0.0285, _PALM, 0.68), 0.03)
    palm = np.full(len(p), 9.0)
    for name, r in (("Index", 0.0140), ("Middle", 0.0136), ("Ring", 0.0130), ("Pinky", 0.0120)):
        knuckle = joint(f"LeftHand{name}1")
        root = place(0.012, 0.55 * ((knuckle - _WRIST) @ _THUMB), 0)
        palm = union(palm, limb(p, root, knuckle + 0.0015 * _PALM, 0.0152, r), 0.014)
    d = union(d, palm, 0.020)
    for name in FINGERS:  # knuckles, and the tendons that run to them
        knuckle, r = joint(f"LeftHand{name}1"), RADII[name][0]
        frame = np.stack([_ALONG, _THUMB, _PALM], axis=1)
        d = union(d, ellipsoid(p, knuckle - 0.0062 * _PALM, (0.0088, 0.72 * r, 1.02 * r), frame), 0.0050)
        root = place(0.020, 0.5 * ((knuckle - _WRIST) @ _THUMB), -0.0135)
        d = union(d, limb(p, root, knuckle - 0.0120 * _PALM, 0.0022, 0.0026), 0.0045)
    d = union(d, ellipsoid(p, place(0.036, 0.022, 0.012), (0.023, 0.021, 0.016)), 0.016)  # thenar
    d = union(d, limb(p, place(0.018, -0.022, 0.007), place(0.055, -0.027, 0.006), 0.0135, 0.0115), 0.015)
    d = union(d, limb(p, place(0.030, 0.030, 0.004), place(0.080, 0.030, 0.001), 0.011, 0.008), 0.014)  # web
    d = union(d, limb(p, place(0.047, 0.042, 0.019), place(0.080, 0.034, 0.004), 0.0122, 0.0100), 0.010)  # its flesh to the thumb
    lo, hi = bounds()
    return within(p, d, lo, hi, _with_digits)


def _with_digits(p, d):
    for name in FINGERS:
        d = union(d, _digit(p, name), 0.0050)
    return union(d, _digit(p, "Thumb"), 0.013)


def hand(p):
    d, (lo, hi) = skin(p), bounds()
    return within(p, d, lo, hi, lambda q, near: near + 0.00034 * creases(q))


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


def detail(p):
    """Where errors count more: folds and ends of the digits, what bends beside the guard; and less inside."""
    out = np.full(len(p), 0.55)
    for name in DIGITS:
        for k in (1, 2, 3):
            at = joint(f"LeftHand{name}{k}") + 0.4 * RADII[name][k - 1] * out_of_back(name)
            out += (0.6 if k == 1 else 1.5) * bump(p, at, 0.010)
        out += 0.8 * bump(p, tip(f"LeftHand{name}3"), 0.010)
    out = out + 1.0 * np.exp(-((guard.edge(p) / 0.004) ** 2))
    out_of_palm = (p - _WRIST) @ _PALM - 0.06 * np.maximum((p - _WRIST) @ _ALONG - 0.09, 0)
    out *= 1 - 0.25 * ramp(0.0, 0.006, out_of_palm) * ((p - _WRIST) @ _THUMB < 0.036)
    return np.where(guard.uncovered(p), out, 0.15)


def build():
    """The left hand, bare but for what its guard covers."""
    whole = sculpt("HandL", "Skin", below_elbow, *bounds(), 0.0012, 3350, 0.0085, detail)
    part = cut(whole, guard.kept(whole.points))
    # What is left under the guard at a bent finger's back goes well under it.
    back = (part.points - _WRIST) @ _PALM < -0.002
    part.points = part.points - (0.0018 * back * ramp(-0.0008, -0.0025, guard.edge(part.points)))[:, None] * part.normals
    return part


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
