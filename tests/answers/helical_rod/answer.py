import numpy as np
from answers import agree, bend_moment, bends_energy, forces_of_energy, root, tensions_at_rest, unit

VARIED = [{"connectors.rod.rest_twist": -1.0}, {"connectors.rod.rest_twist": 0.0}, {"connectors.rod.bending_stiffness": 0.2}]
TURN, RADIUS = 0.5, 0.1  # rad from bead to bead about the axis z; m


def turned(v, axis, angle):
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))


def helix(scene):
    """The places, the twisting moment, force and couple along the axis, and the directions of both clamps."""
    rod = scene["connectors"]["rod"]
    n, ei = rod["particles"] - 1, rod["bending_stiffness"]
    l, m = rod["length"] / n, -rod["twisting_stiffness"] * rod.get("rest_twist", 0.0)
    rise = np.sqrt(l * l - (2 * RADIUS * np.sin(TURN / 2)) ** 2)
    k = np.arange(-1, n + 2)
    x = np.array([RADIUS * np.cos(TURN * k), RADIUS * np.sin(TURN * k), rise * k]).T
    t = np.diff(x, axis=0) / l
    angle = np.arccos(t[0] @ t[1])
    bends = bend_moment(ei, l, angle)[0] * unit(np.cross(t[0], t[1])) + m * (t[0] + t[1]) / (1 + t[0] @ t[1])
    f, couple = bends[1] / RADIUS, bends[2]  # at the bead (RADIUS, 0, 0)
    agree(bends[0], 0, 1e-12)

    def clamp(at, way, side):
        """The direction of a clamp whose half bend carries the moment; side: 1 at the first end, -1 at the last."""
        across = at - m * way
        size = np.linalg.norm(across)
        a = root(lambda a: np.hypot(bend_moment(ei, l / 2, a)[0], m * np.tan(a / 2)) - size, 0.0, 1.5)
        normal = turned(across / size, way, -side * np.arctan2(m * np.tan(a / 2), bend_moment(ei, l / 2, a)[0]))
        return turned(way, normal, -side * a)

    x, t = x[1:-1], t[1:-1]
    moments = np.array([[0, 0, couple]] * (n + 1)) - np.cross(x, [0, 0, f])
    return x, m, f, couple, moments, clamp(moments[0], t[0], 1), clamp(moments[-1], t[-1], -1)


def prepared(scene):
    """The rod starts as the helix, its clamps hold it so."""
    x, _, _, _, _, first, last = helix(scene)
    rod = scene["connectors"]["rod"]
    rod["from"] = {"fixed": x[0].tolist(), "clamp": first.tolist()}
    rod["to"] = {"fixed": x[-1].tolist(), "clamp": last.tolist()}
    rod["start"] = {"points": x.tolist()}
    return scene


def answer(scene):
    x, m, f, _, moments, first, last = helix(scene)
    rod, t = scene["connectors"]["rod"], scene["duration"]
    n, l = rod["particles"] - 1, rod["length"] / (rod["particles"] - 1)

    def frame(x):
        """The end of a vector that is carried along the links from the first clamp to the last."""
        ways = [first, *(np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1)[:, None]), last]
        v = unit(np.cross(first, [0.3, 0.4, 0.5]))
        for a, b in zip(ways, ways[1:]):
            v = turned(v, unit(np.cross(a, b)), np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
        return v

    before = frame(x)

    def energy(x):
        now = frame(x)
        angle = np.arctan2(np.cross(before, now) @ last, before @ now)
        # The twist grows as the carried frame turns back; m is that of the twist at rest.
        return bends_energy(x, l, rod["bending_stiffness"], first, last) - m * angle

    _, holds, left = tensions_at_rest(x, forces_of_energy(energy, x, 1e-6), (0, n))
    size = max(abs(f), 1e-3)
    agree(left, 0, 1e-5 * size)
    agree(holds[n], [0, 0, f], 1e-5 * size)
    rows = [(t, f"rod.{k}.{axis}", x[k][j], 1e-6) for k in range(1, n) for j, axis in enumerate("xyz")]
    for k, side in ((0, -1), (n, 1)):
        rows += [(t, f"rod.{k}.hold.{axis}", side * f * (axis == "z"), 1e-4 * size) for axis in "xyz"]
        rows += [(t, f"rod.{k}.moment.{axis}", side * moments[k][j], 1e-4 * np.linalg.norm(moments[k])) for j, axis in enumerate("xyz")]
    return rows
