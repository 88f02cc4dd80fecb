"""The rest skeleton of the martial artist: three joints per finger; an eye, its upper lid, a brow and a corner of the
mouth on each side, and the jaw; and those of the cloth that hangs: tails of the belt, columns of the skirt and cuffs.

glTF axes: y up, z forward, x to the character's left; metres. The arms hang 40 degrees below the
horizontal, palms down and inward. Other parts of the project pose these joints by name and measure
grips against these positions, so a change here is a change of interface.
"""
import numpy as np

SIDES = (("Left", 1.0), ("Right", -1.0))
FINGERS = ("Index", "Middle", "Ring", "Pinky")
DIGITS = ("Thumb",) + FINGERS

# Per finger: knuckle in the hand's frame (along, to the thumb, to the palm), phalanx lengths, and the
# spread towards the thumb side.
_KNUCKLES = {
    "Index": ((0.094, 0.0285, 0.000), (0.043, 0.026, 0.021), 0.10),
    "Middle": ((0.097, 0.0068, 0.0025), (0.047, 0.030, 0.022), 0.02),
    "Ring": ((0.092, -0.0150, 0.001), (0.043, 0.028, 0.022), -0.07),
    "Pinky": ((0.083, -0.0355, -0.003), (0.034, 0.021, 0.019), -0.17),
}
_THUMB = (
    (0.046, (0.72, 0.62, 0.42)),
    (0.034, (0.84, 0.46, 0.30)),
    (0.028, (0.92, 0.33, 0.22)),
)


def vec(*xyz):
    return np.array(xyz, float)


def unit(v):
    v = np.asarray(v, float)
    return v / np.linalg.norm(v)


# The middle line of a tail of the belt: where it leaves the knot, bends and ends.
TAILS = {
    "Left": ((0.012, 1.008, 0.152), (0.048, 0.881, 0.172), (0.078, 0.736, 0.180)),
    "Right": ((-0.012, 1.008, 0.152), (-0.040, 0.895, 0.172), (-0.064, 0.764, 0.180)),
}
# Columns of the skirt, which has a front and a back panel: superellipses that its cloth is on, from the belt to the hem:
# height, half widths in x and z, and the centre's z. Column k is at the angle (k + 0.5) 360 degrees / columns from the
# left side to the back.
SKIRT_COLUMNS, SKIRT_POWER = 12, 2.5
SKIRT = ((0.985, 0.181, 0.129, -0.010), (0.865, 0.217, 0.163, -0.012), (0.735, 0.236, 0.181, -0.010))
# Columns of a cuff: how far up the fore arm from the wrist they begin and end, and their distance from its line.
CUFF_COLUMNS, CUFF, CUFF_RADIUS = 6, (0.180, 0.060), 0.064
EYE = vec(0.0315, 1.6515, 0.0665)  # centre of the left eye ball
# Where the left brow and the left corner of the mouth are. Their joints are as far back as the skull is round, so that
# what turns about them slides over it.
BROW, MOUTH = vec(0.0300, 1.6780, 0.080), vec(0.0240, 1.5895, 0.081)
JAW, CHIN = vec(0, 1.6120, -0.006), vec(0, 1.5570, 0.085)


class Skeleton:
    """Joints in order (parents first): `names`, `parent[name]`, `head[name]`, `tail[name]`."""

    def __init__(self):
        self.names, self.parent, self.head, self.tail = [], {}, {}, {}

    def add(self, name, parent, position):
        self.names.append(name)
        self.parent[name] = parent
        self.head[name] = np.asarray(position, float)

    def chain(self, stem, parent, points):
        """Joints stem1, stem2 and so on at the points; the last one is where the last bone ends."""
        for k, point in enumerate(points):
            self.add(f"{stem}{k + 1}", parent if k == 0 else f"{stem}{k}", point)
        self.tail[f"{stem}{len(points)}"] = points[-1]

    def index(self, name):
        return self.names.index(name)

    def children(self, name):
        return [n for n in self.names if self.parent[n] == name]


def hand_frame():
    """The left hand at rest: wrist, and unit vectors along the hand, to the thumb, out of the palm."""
    shoulder = vec(0.182, 1.418, -0.022)
    elbow = shoulder + 0.285 * unit(vec(0.77, -0.64, 0.0))
    along = unit(vec(0.75, -0.63, 0.20))
    wrist = elbow + 0.262 * along
    thumb = unit(vec(0, 0, 1) - along * along[2])
    return wrist, along, thumb, unit(np.cross(along, thumb))


def _left_arm():
    """(name, parent, position) of the left arm's joints, and the tips of its fingers."""
    shoulder = vec(0.182, 1.418, -0.022)
    elbow = shoulder + 0.285 * unit(vec(0.77, -0.64, 0.0))
    wrist, along, thumb, palm = hand_frame()
    joints = [
        ("Shoulder", "Chest", vec(0.03, 1.425, 0.0)),
        ("Arm", "Shoulder", shoulder),
        ("ForeArm", "Arm", elbow),
        ("Hand", "ForeArm", wrist),
        ("Elbow", "Arm", elbow),  # takes half the fore arm's turn
    ]
    tips = {"Elbow": elbow - vec(0, 0, 0.035)}
    for finger in FINGERS:
        (a, b, c), lengths, spread = _KNUCKLES[finger]
        p = wrist + a * along + b * thumb + c * palm
        direction, parent = unit(along + spread * thumb + 0.06 * palm), "Hand"
        for k, length in enumerate(lengths):
            joints.append((f"Hand{finger}{k + 1}", parent, p))
            parent = f"Hand{finger}{k + 1}"
            p = p + length * direction
            direction = unit(direction + 0.12 * palm)
        tips[parent] = p
    p, parent = wrist + 0.022 * along + 0.024 * thumb + 0.010 * palm, "Hand"
    for k, (length, (a, b, c)) in enumerate(_THUMB):
        joints.append((f"HandThumb{k + 1}", parent, p))
        parent = f"HandThumb{k + 1}"
        p = p + length * unit(a * along + b * thumb + c * palm)
    tips[parent] = p
    return joints, tips


def letters(count):
    return [chr(ord("A") + k) for k in range(count)]


def around(columns):
    """The angle of each column, rad."""
    return (np.arange(columns) + 0.5) * 2 * np.pi / columns


def skirt_point(ring, angle):
    y, half_x, half_z, centre_z = ring
    c, s = np.cos(angle), np.sin(angle)
    r = (abs(c) ** SKIRT_POWER + abs(s) ** SKIRT_POWER) ** (-1 / SKIRT_POWER)
    return vec(r * c * half_x, y, centre_z - r * s * half_z)


def skirt_columns():
    """Stems of the columns' names, in their order: the back panel, then the front one, each a chain of neighbours."""
    half = SKIRT_COLUMNS // 2
    return [f"Skirt{panel}{letter}" for panel in ("Back", "Front") for letter in letters(half)]


def cuff_frame():
    """The left fore arm: wrist, and unit vectors down to the hand, forward and across both."""
    wrist = hand_frame()[0]
    elbow = vec(0.182, 1.418, -0.022) + 0.285 * unit(vec(0.77, -0.64, 0.0))
    down = unit(wrist - elbow)
    forward = unit(vec(0, 0, 1) - down * down[2])
    return wrist, down, forward, np.cross(down, forward)


def _add_hanging(s):
    """Joints of what hangs: a chain of them each, named by a stem and numbers from 1."""
    for side, (knot, bend, end) in TAILS.items():
        s.chain(side + "Tail", "Hips", [vec(*knot), vec(*bend), vec(*end)])
    for name, angle in zip(skirt_columns(), around(SKIRT_COLUMNS)):
        s.chain(name, "Hips", [skirt_point(ring, angle) for ring in SKIRT])
    wrist, down, forward, across = cuff_frame()
    for side, sign in SIDES:
        for letter, angle in zip(letters(CUFF_COLUMNS), around(CUFF_COLUMNS)):
            out = CUFF_RADIUS * (np.cos(angle) * forward + np.sin(angle) * across)
            s.chain(side + "Cuff" + letter, side + "ForeArm", [vec(sign, 1, 1) * (wrist - up * down + out) for up in CUFF])


def build():
    s = Skeleton()
    s.add("Hips", None, (0, 0.965, 0))
    s.add("Spine", "Hips", (0, 1.065, 0.004))
    s.add("Spine1", "Spine", (0, 1.18, -0.004))
    s.add("Chest", "Spine1", (0, 1.30, -0.012))
    s.add("Neck", "Chest", (0, 1.472, -0.022))
    s.add("Head", "Neck", (0, 1.560, -0.004))
    s.tail["Head"] = vec(0, 1.775, 0)
    arm, arm_tips = _left_arm()
    leg = [
        ("UpLeg", "Hips", vec(0.092, 0.925, 0.0)),
        ("Leg", "UpLeg", vec(0.105, 0.495, 0.012)),
        ("Foot", "Leg", vec(0.112, 0.082, -0.018)),
        ("ToeBase", "Foot", vec(0.128, 0.022, 0.118)),
    ]
    centre = {"Chest", "Hips"}
    for side, sign in SIDES:
        flip = vec(sign, 1, 1)
        for name, parent, p in arm + leg:
            s.add(side + name, parent if parent in centre else side + parent, flip * p)
        for name, p in arm_tips.items():
            s.tail[side + name] = flip * p
        s.tail[side + "ToeBase"] = flip * vec(0.140, 0.016, 0.195)
    for side, sign in SIDES:
        for name in ("Eye", "Lid"):
            s.add(side + name, "Head", vec(sign, 1, 1) * EYE)
            s.tail[side + name] = s.head[side + name] + vec(0, 0, 0.014)
    _add_hanging(s)
    for side, sign in SIDES:
        for name, place in (("Brow", BROW), ("Mouth", MOUTH)):
            s.add(side + name, "Head", vec(sign, 1, 0) * place)
            s.tail[side + name] = vec(sign, 1, 1) * place
    s.add("Jaw", "Head", JAW)
    s.tail["Jaw"] = CHIN
    onward = {"Hips": "Spine", "Chest": "Neck"}
    for side, _ in SIDES:
        onward[side + "Hand"] = side + "HandMiddle1"
    for name in s.names:
        if name not in s.tail:
            s.tail[name] = s.head[onward.get(name) or s.children(name)[0]]
    return s


REST = build()


def joint(name):
    """Rest position of a joint, m."""
    return REST.head[name]


def tip(name):
    """Where the bone that starts at a joint ends, m."""
    return REST.tail[name]
