"""The character: its parts, their weights and their colours."""
import numpy as np

import occlusion
import skeleton
from character import belt, brows, eyes, face, guard, hand_paint, hands, hanging, head, headband, hood, jacket, jacket_shape, mask, nails, sewing, skirt, tabi, trousers, wraps
from character.strain import both, ease, pose, untangle
from character.weights import BodyHeat, dense_of, nearby, rigid, sides, spread, strongest
from mesh import mirror, sculpt, smoothing
from nets import evaluate
from sdf import intersect, limb, mirrored, ramp, rotation
from skeleton import REST, joint, unit

_TRUNK = ["Hips", "Spine", "Spine1", "Chest", "Neck"]
_THROAT = ["Spine1", "Chest", "Neck", "Head"] + sides("Shoulder")
_BONES = {
    "Hood": _THROAT,
    "Mask": _THROAT,
    "Jacket": _TRUNK + sides("Shoulder", "Arm", "ForeArm", "UpLeg"),
    "Trousers": ["Hips"] + sides("UpLeg", "Leg"),
    "TabiL": ["LeftLeg", "LeftFoot", "LeftToeBase"],
    "TabiR": ["RightLeg", "RightFoot", "RightToeBase"],
    "SoleL": ["LeftFoot", "LeftToeBase"],
    "SoleR": ["RightFoot", "RightToeBase"],
}

_OF_HAND = ("Hand", "Nails", "Guard")


def _arms(above, forward, bent):
    """Both upper arms so far above the horizontal and forward of the side, the elbows bent; degrees. The shoulder
    blades take a third of the way up, as they do."""
    up, ahead, flexed = np.radians((above + 40, forward, bent))
    hinge = unit(np.cross(joint("LeftForeArm") - joint("LeftArm"), (0, 0, 1)))
    turns = {
        "Shoulder": [((0, 0, 1), up / 3)],
        "Arm": [((0, 0, 1), up * 2 / 3), ((0, 1, 0), -ahead)],
        "ForeArm": [(hinge, flexed)],
        "Elbow": [(hinge, flexed / 2)],
    }
    return pose(both(turns))


def _trunk(left, forward):
    """The three joints of the spine turned so far each, degrees."""
    turn = rotation("y", np.radians(left)) @ rotation("x", np.radians(forward))
    return pose({bone: turn for bone in ("Spine", "Spine1", "Chest")})


# The poses worn by the jacket: arms from the sides to straight up, a turned and bent trunk.
_WORN = [_arms(*a) for a in ((0, 0, 0), (0, 60, 130), (45, 0, 0), (45, 60, 60), (90, 0, 0), (-75, 10, 90))]
_WORN += [_trunk(10, 8), _trunk(-10, 8)]
_RAISED = [_arms(*a) for a in ((45, 0, 0), (60, 60, 0), (90, 0, 0))]


def _clothed(p):
    """The body with its clothes, roughly: where heat flows."""
    q = mirrored(p)
    d = np.minimum(jacket_shape.smooth(p), trousers.smooth(p))
    d = intersect(d, skirt.HEM - 0.02 - p[:, 1], 0.01)
    d = np.minimum(d, np.minimum(trousers.smooth(p), hood.scalp(p)))
    d = np.minimum(d, limb(q, joint("LeftForeArm"), joint("LeftHand"), 0.045, 0.032))
    d = np.minimum(d, limb(q, joint("LeftHand"), joint("LeftHandMiddle1"), 0.03, 0.03))
    return np.minimum(d, tabi.foot(q))


def _bare(p):
    """The skin goes on a little under hood and mask, so that no sight passes where they meet."""
    return (hood.opening(p) < 0.020) & (mask.edge(p) > -0.020) & (p[:, 2] > 0)


def _parts():
    """All parts but the eyes, unweighted."""

    def outside(*covers):
        """Shown: less than so deep inside each (field, depth)."""
        return lambda p: np.all([evaluate(cover, p) > -depth for cover, depth in covers], axis=0)

    hand, nail, cover = hands.build(), nails.build(), guard.build()
    shins = wraps.build()
    sock = sculpt("TabiL", "Tabi", tabi.tabi, (0.03, -0.01, -0.13), (0.24, 0.29, 0.24), 0.0024, 570, 0.025)
    sole = sculpt("SoleL", "TabiSole", tabi.sole, (0.03, -0.01, -0.13), (0.24, 0.02, 0.24), 0.0022, 150, 0.025)
    return [
        sculpt("Head", "Skin", lambda p: np.minimum(head.head(p), hood.filling(p)), (-0.095, 1.60, 0.0), (0.095, 1.73, 0.125), 0.0013, 2200, 0.012, head.detail, _bare),
        sculpt(
            "Hood", "Gi", hood.hood, (-0.11, 1.44, -0.145), (0.11, 1.80, 0.115), 0.0019, 1780, 0.02,
            hood.detail, lambda p: hood.shown(p) & outside((mask.cover, 0.004))(p),
        ),
        mask.build(),
        sculpt("Headband", "Band", headband.band, (-0.115, 1.52, -0.18), (0.115, 1.77, 0.125), 0.0022, 620, 0.025),
        *(side for part in (hand, nail, cover) for side in (part, mirror(part, part.name[:-1] + "R"))),
        sock,
        mirror(sock, "TabiR"),
        sole,
        mirror(sole, "SoleR"),
        sculpt("Jacket", "Gi", jacket.jacket, *jacket.BOUNDS, 0.0044, 4500, 0.040),
        sculpt(
            "Trousers", "GiDark", trousers.trousers, *trousers.BOUNDS, 0.0052, 1500, 0.045,
            None, lambda p: (evaluate(jacket_shape.smooth, p) > -0.02) | (p[:, 1] < 0.86),
        ),
        *shins,
        *(mirror(part, part.name[:-1] + "R") for part in shins),
        belt.build(),
    ]


def _weigh(part, heat):
    n = len(part.points)
    if part.name[:-1] in _OF_HAND:
        left = part if part.name.endswith("L") else mirror(part, part.name)
        dense = hands.weights(left.points, smoothing(part.triangles, n))
        if part.name.endswith("R"):
            dense = dense[:, [REST.index(_other_side(b)) for b in REST.names]]
    elif part.name[:-1] in ("Wraps", "Cords"):
        side = "Left" if part.name.endswith("L") else "Right"
        dense = heat.at(part.points, [side + bone for bone in ("UpLeg", "Leg")])
    elif part.name in _BONES:
        dense = heat.at(part.points, _BONES[part.name])
        if part.name == "Jacket":
            dense = _drape(part, dense)
        if part.name == "Trousers":
            dense = _part_legs(part, dense)
        if part.name.startswith("Tabi"):
            dense = _stand(part, dense)
        if part.name in ("Hood", "Mask"):  # the throat bends
            dense = _stiffen_face(part, dense)
        if part.name == "Mask":  # chin and cheeks move it; brows slide under the hood
            dense = face.weigh(part.points, dense)
    else:
        side = "Left" if part.name.endswith("L") else "Right"
        bone = {"Eye": side + "Eye", "Iris": side + "Eye", "Pupil": side + "Eye", "Glint": side + "Eye", "Lid": side + "Lid", "Lash": side + "Lid"}
        dense = rigid(n, bone.get(part.name[:-1], "Head"))
        if part.name in ("Head", "BrowL", "BrowR"):
            dense = face.weigh(part.points, dense)
    part.joints, part.weights = strongest(dense)


def _stiffen_face(part, dense):
    p = part.points
    t = np.clip((p[:, 1] + 0.35 * (p[:, 2] - 0.0) - 1.495) / 0.090, 0, 1)
    t = (t * t * (3 - 2 * t))[:, None]
    return dense * (1 - t) + rigid(len(p), "Head") * t


def _drape(part, dense):
    """The jacket's cloth follows the limbs widely, the trunk as the body does, and hangs at the wrists; its lining goes with its outside."""
    limb = np.array([b.startswith(("Left", "Right")) for b in REST.names])
    limbs = spread(dense[:, limb], part.triangles, part.points, jacket.give(part.points))
    arms = np.array(["Leg" not in b for b in np.array(REST.names)[limb]])
    held = ramp(1.050, 1.020, part.points[:, 1]) * (np.abs(part.points[:, 0]) < 0.25)  # by the belt
    limbs[:, arms] *= (1 - held)[:, None]
    own = jacket.below_elbow(part.points)[:, None]  # there the trunk has no part in it
    total = np.maximum(limbs.sum(axis=1, keepdims=True), 1e-6)
    limbs *= 1 + own * (1 - total) / total
    trunk = dense[:, ~limb] / np.maximum(dense[:, ~limb].sum(axis=1, keepdims=True), 1e-6)
    out = np.empty_like(dense)
    out[:, limb], out[:, ~limb] = limbs, trunk * (1 - limbs.sum(axis=1, keepdims=True))
    out = hanging.cuffs(part, _round_elbows(out))
    inside = jacket.lining(part.points)[:, None]
    outer = inside[:, 0] < 0.5

    def lined(dense):
        return (1 - inside) * dense + inside * nearby(part.points, part.points[outer], dense[outer])

    eased = ease(part.points, part.triangles, lined(out), _WORN)
    return lined(untangle(part.points, part.normals, part.triangles, eased, _RAISED))


def _round_elbows(dense):
    """Where upper arm and fore arm share the cloth, the bone between them takes it: an arc, not its chord."""
    dense = dense.copy()
    for side, _ in skeleton.SIDES:
        upper, lower, between = (REST.index(side + kind) for kind in ("Arm", "ForeArm", "Elbow"))
        both = dense[:, upper] + dense[:, lower]
        share = dense[:, lower] / np.maximum(both, 1e-9)
        taken = 4 * share * (1 - share)
        dense[:, between] = both * taken
        dense[:, upper] = np.where(share < 0.5, both * (1 - taken), 0)
        dense[:, lower] = np.where(share < 0.5, 0, both * (1 - taken))
    return dense


def _tuck(hand, sleeve):
    """The fore arm moves with the sleeve that covers it, so that it does not come through."""
    inside = ramp(0.055, 0.095, hands.depth(hand.points))[:, None]
    covered = nearby(hand.points, sleeve.points, hanging.without_cuffs(dense_of(sleeve)))
    hand.joints, hand.weights = strongest((1 - inside) * dense_of(hand) + inside * covered)


def _part_legs(part, dense):
    """Below the skirt a trouser leg follows its own leg alone."""
    p, dense = part.points, dense.copy()
    for sign, side in ((1, "Left"), (-1, "Right")):
        other = np.where(sign * p[:, 0] < 0, ramp(0.70, 0.85, p[:, 1]), 1.0)
        columns = [k for k, b in enumerate(REST.names) if b.startswith(side)]
        dense[:, columns] *= other[:, None]
    return dense / dense.sum(axis=1, keepdims=True)


def _stand(part, dense):
    """What is below the ankle stays on its sole, however the shin leans."""
    dense, shin = dense.copy(), [k for k, b in enumerate(REST.names) if b.endswith("Leg")]
    dense[:, shin] *= ramp(0.060, 0.125, part.points[:, 1])[:, None]
    return dense / dense.sum(axis=1, keepdims=True)


def _other_side(bone):
    for a, b in (("Left", "Right"), ("Right", "Left")):
        if bone.startswith(a):
            return b + bone[len(a) :]
    return bone


def _shading(part):
    """How much of the baked shading a part shows. A face has none of the blots that its hollows would make."""
    if part.name in ("Head", "BrowL", "BrowR"):
        eye = np.linalg.norm(mirrored(part.points) - skeleton.EYE, axis=1)  # the shut lid has no rim of shade
        return (1 - 0.5 * ramp(1.52, 1.56, part.points[:, 1])) * (1 - 0.7 * ramp(0.026, 0.020, eye))
    if part.name == "Jacket":  # light falls into the sleeves through their cloth; where arms hide it, they do so as they move
        return 0.7 - 0.4 * jacket.lining(part.points)
    if part.name.startswith("Cuff"):
        return 0.5
    if part.name[:-1] == "Guard":  # a sleeve that falls back lays it open
        return 0.5
    if part.name[:-1] in ("Hand", "Nails"):  # closed, they have another shade
        return 0.25
    return 1.0


def build(report=print):
    parts = _parts() + eyes.build()
    heat = BodyHeat(_clothed, (-0.80, -0.02, -0.26), (0.80, 1.86, 0.26))
    for part in parts:
        if part.name != "Belt":
            _weigh(part, heat)
    by_name = {part.name: part for part in parts}
    sheets = sewing.on_jacket(by_name["Jacket"], by_name["Belt"], heat)
    parts += sheets
    for name in ("HandL", "HandR", "GuardL", "GuardR"):
        _tuck(by_name[name], by_name["Jacket"])
    for part in parts:
        side = -1 if part.name.endswith("R") else 1
        if part.name == "Head":
            head.paint(part)
            part.tint(brows.under(mirrored(part.points)), (0.26, 0.19, 0.16))
            slit = np.minimum(-hood.opening(part.points), mask.edge(part.points))
            part.tint(0.85 * ramp(0.013, -0.001, slit), (0.34, 0.25, 0.23))  # cloth keeps the sky from what is beside it
        elif part.name[:-1] in ("Hand", "Guard"):
            {"Hand": hand_paint, "Guard": guard}[part.name[:-1]].paint(part, side)
        elif part.name in ("Jacket", "Trousers"):
            {"Jacket": jacket, "Trousers": trousers}[part.name].paint(part)
    occlusion.bake(parts, _shading)
    for part in parts:
        if part.name.startswith(("Jacket", "Cuff")):
            jacket.face_the_mouth(part)
    hand_paint.shade(by_name)
    parts = sewing.sewn(parts, by_name["Jacket"], sheets)
    unshaded = eyes.lids() + eyes.glints()  # the baked shading would take them for buried
    for part in unshaded:
        _weigh(part, heat)
    parts += unshaded
    for part in parts:
        report(f"  {part.name:10s} {len(part.points):6d} vertices {len(part.triangles):6d} triangles")
    return parts
