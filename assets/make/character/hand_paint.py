"""The colours of hands: skin's own, and the shade that lies between the fingers of a closed hand."""
import numpy as np

import occlusion
from character import hands
from character.strain import pose
from character.weights import dense_of
from mesh import Part
from sdf import bump, ramp, rotation
from skeleton import DIGITS, FINGERS, hand_frame, joint, tip, unit

_WRIST, _ALONG, _THUMB, _PALM = hand_frame()
# How a hand is closed that is empty, and one that holds a stick: flexion of a finger's joints, degrees; and turns of the
# thumb's, about the axes along the hand, to the thumb and out of the palm, degrees.
_FIST = ((82, 95, 65), ((53, -12, 1), (14, -17, -20), (14, -18, -20)))
_GRIP = ((78, 60, 48), ((54, 9, 27), (10, -12, -15), (16, -20, -23)))
_ASIDE = 7, 0, -8, -18  # degrees by which fingers lean to the middle one, to lie side by side
_STICK = 0.074, 0.0315, 0.014  # its middle: m along the hand and out of the palm; radius


def _turns(flexion, thumb):
    """Turns of the left hand's digits, bone -> matrix."""
    hinge = np.cross(_ALONG, _PALM)
    out = {}
    for name, aside in zip(FINGERS, _ASIDE):
        lean = rotation(np.cross(_ALONG, _THUMB), -np.radians(aside))
        for k, angle in enumerate(flexion):
            bent = rotation(hinge, np.radians(angle))
            out[f"LeftHand{name}{k + 1}"] = bent @ lean if k == 0 else lean.T @ bent @ lean
    for k, (a, b, c) in enumerate(thumb):
        v = np.radians(a * _ALONG + b * _THUMB + c * _PALM)
        angle = np.linalg.norm(v)
        out[f"LeftHandThumb{k + 1}"] = rotation(v / angle, angle)
    return out


def _posed(part, bones):
    dense = dense_of(part)
    moved = np.einsum("nb,bij->nij", dense, bones)
    points = np.einsum("nij,nj->ni", moved[:, :, :3], part.points) + moved[:, :, 3]
    normals = np.einsum("nij,nj->ni", moved[:, :, :3], part.normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    return Part(part.name, part.material, points, normals, part.triangles)


def _stick():
    along, out, radius = _STICK
    axis = np.cos(0.244) * _THUMB + np.sin(0.244) * _ALONG
    u = unit(np.cross(axis, _PALM))
    t, f = np.meshgrid(np.linspace(-0.15, 0.15, 60), np.linspace(0, 2 * np.pi, 41), indexing="ij")
    middle = hands.place(along, 0, out)
    points = middle + np.multiply.outer(t, axis) + radius * (np.multiply.outer(np.cos(f), u) + np.multiply.outer(np.sin(f), np.cross(axis, u)))
    quads = [(41 * i + k, 41 * i + k + 1, 41 * i + k + 42, 41 * i + k + 41) for i in range(59) for k in range(40)]
    triangles = np.array([x for a, b, c, d in quads for x in ((a, b, c), (a, c, d))])
    points = points.reshape(-1, 3)
    return Part("Stick", "Wood", points, (points - middle) / np.linalg.norm(points - middle, axis=1, keepdims=True), triangles)


def shade(by_name):
    """Darkens both hands by how they are closed: the left one is empty, the right one holds a stick."""
    left = [by_name[kind + "L"] for kind in ("Hand", "Nails", "Guard")]
    for end, digits, held in (("L", _FIST, []), ("R", _GRIP, [_stick()])):
        bones = pose(_turns(*digits))
        posed = [_posed(part, bones) for part in left]  # the right hand is its image
        occlusion.bake(posed + held, lambda part: 0.85, 0.16, 0.0010, 0.045)
        for part, dark in zip(left, posed):
            seen = dark.colors[:, :1]
            # Light that has been in skin is red, and so are its shades.
            by_name[part.name[:-1] + end].colors *= seen ** np.array([0.85, 1.10, 1.16]) if part.material == "Skin" else seen


def paint(part, side):
    """Redder over the knuckles and at the ends, paler inside, dark in the folds."""
    q = part.points * np.array([side, 1.0, 1.0])
    part.tint(np.full(len(q), 1.0), (0.93, 0.90, 0.89))
    for name in DIGITS:
        back = hands.out_of_back(name)
        for k in (1, 2, 3):
            at = joint(f"LeftHand{name}{k}") + 0.8 * hands.RADII[name][k - 1] * back
            part.tint((0.55, 0.60, 0.45)[k - 1] * bump(q, at, (0.010, 0.0085, 0.0070)[k - 1]), (0.93, 0.66, 0.60))
        end = tip(f"LeftHand{name}3")
        part.tint(0.45 * bump(q, end, 0.012), (0.98, 0.74, 0.68))
    part.tint(0.75 * hands.creases(q), (0.50, 0.33, 0.29))
