"""The character: its parts, their weights and their colours."""
import numpy as np

import belt
import body
import eyes
import hair
import hands
import head
import jacket
import occlusion
import trousers
from mesh import keep, mirror, sculpt, smoothing
from nets import evaluate
from sdf import intersect, limb, mirrored, union
from skeleton import REST, joint, unit, vec
from weights import BodyHeat, rigid, sides, strongest

_TRUNK = ["Hips", "Spine", "Spine1", "Chest", "Neck"]
_BONES = {
    "Head": ["Spine1", "Chest", "Neck", "Head"] + sides("Shoulder"),
    "Jacket": _TRUNK + sides("Shoulder", "Arm", "ForeArm", "UpLeg"),
    "Trousers": ["Hips"] + sides("UpLeg", "Leg"),
    "Belt": ["Hips", "Spine"] + sides("UpLeg"),
    "FootL": ["LeftLeg", "LeftFoot", "LeftToeBase"],
    "FootR": ["RightLeg", "RightFoot", "RightToeBase"],
}


def _clothed(p):
    """The body with its clothes, roughly: where heat flows."""
    q = mirrored(p)
    d = np.minimum(jacket.smooth(p), trousers.smooth(p))
    d = intersect(d, jacket.HEM - 0.02 - p[:, 1], 0.01)
    d = np.minimum(d, np.minimum(trousers.smooth(p), head.head(p)))
    d = np.minimum(d, hair.hair(p))
    d = np.minimum(d, limb(q, joint("LeftForeArm"), joint("LeftHand"), 0.045, 0.032))
    d = np.minimum(d, limb(q, joint("LeftHand"), joint("LeftHandMiddle1"), 0.03, 0.03))
    return np.minimum(d, body.foot(q))


def _parts():
    """All parts but the eyes, unweighted."""
    face = sculpt("Head", "Skin", body.with_bust(head.head), (-0.105, 1.15, -0.13), (0.105, 1.80, 0.14), 0.0016, 11500, 0.016, head.detail)
    locks = sculpt("Hair", "Hair", hair.hair, (-0.11, 1.57, -0.14), (0.11, 1.84, 0.11), 0.0026, 3600, 0.02)
    cloth_band = sculpt("Headband", "Band", hair.band, (-0.105, 1.52, -0.18), (0.105, 1.76, 0.125), 0.0026, 2000, 0.02)
    hand = sculpt("HandL", "Skin", hands.below_elbow, *hands.bounds(), 0.0017, 5200, 0.008)
    foot = sculpt("FootL", "Skin", body.below_shin, (0.03, -0.01, -0.13), (0.24, 0.33, 0.24), 0.0026, 2200, 0.02)
    coat = sculpt("Jacket", "Gi", jacket.jacket, (-0.72, 0.70, -0.25), (0.72, 1.54, 0.24), 0.0050, 10500, 0.035)
    legs = sculpt("Trousers", "GiDark", trousers.trousers, (-0.27, 0.08, -0.19), (0.27, 1.0, 0.20), 0.0060, 4000, 0.04)
    sash = sculpt("Belt", "Belt", belt.belt, (-0.22, 0.70, -0.18), (0.22, 1.08, 0.21), 0.0028, 2400, 0.03)

    face = keep(face, (evaluate(hair.hair, face.points) > -0.002) & (evaluate(hair.band, face.points) > -0.002) & (evaluate(jacket.smooth, face.points) > -0.035))
    locks = keep(locks, (evaluate(hair.band, locks.points) > -0.003) & (evaluate(head.head, locks.points) > -0.004))
    legs = keep(legs, (evaluate(jacket.smooth, legs.points) > -0.02) | (legs.points[:, 1] < 0.86))
    return [face, locks, cloth_band, hand, mirror(hand, "HandR"), foot, mirror(foot, "FootR"), coat, legs, sash]


def _weigh(part, heat):
    n = len(part.points)
    if part.name.startswith("Hand") and part.name != "Headband":
        left = part if part.name.endswith("L") else mirror(part, part.name)
        dense = hands.weights(left.points, smoothing(part.triangles, n))
        if part.name.endswith("R"):
            dense = dense[:, [REST.index(_other_side(b)) for b in REST.names]]
    elif part.name in _BONES:
        dense = heat.at(part.points, _BONES[part.name])
        if part.name == "Head":  # the face stays rigid: only the throat bends
            dense = _stiffen_face(part, dense)
    else:
        dense = rigid(n, "Head")
    part.joints, part.weights = strongest(dense)


def _stiffen_face(part, dense):
    p = part.points
    t = np.clip((p[:, 1] + 0.35 * (p[:, 2] - 0.0) - 1.535) / 0.045, 0, 1)
    t = (t * t * (3 - 2 * t))[:, None]
    return dense * (1 - t) + rigid(len(p), "Head") * t


def _other_side(bone):
    for a, b in (("Left", "Right"), ("Right", "Left")):
        if bone.startswith(a):
            return b + bone[len(a) :]
    return bone


def build(report=print):
    parts = _parts() + eyes.build()
    heat = BodyHeat(_clothed, (-0.80, -0.02, -0.26), (0.80, 1.86, 0.26))
    for part in parts:
        _weigh(part, heat)
        side = -1 if part.name.endswith("R") else 1
        if part.name == "Head":
            head.paint(part)
        elif part.name in ("HandL", "HandR"):
            hands.paint(part, side)
        elif part.name in ("FootL", "FootR"):
            body.paint_foot(part, side)
    occlusion.bake(parts)
    for part in parts:
        report(f"  {part.name:10s} {len(part.points):6d} vertices {len(part.triangles):6d} triangles")
    return parts
