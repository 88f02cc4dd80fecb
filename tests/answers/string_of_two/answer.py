import numpy as np
from answers import agree

VARIED = [{"connectors.string.to.point_mass": 2.0}, {"connectors.string.length": 0.35}]


def answer(scene):
    string, end = scene["connectors"]["string"], scene["duration"]
    l, m = string["length"], np.array([string["from"]["point_mass"], string["to"]["point_mass"]]) + string["mass"] / 2
    x = np.array(string["start"]["points"])[:, :2]
    v = np.array([[0, 0], [0, string["start"]["spin"][2] * x[1, 0]]])  # across the string at first
    taut = np.sqrt(l * l - x[1, 0] ** 2) / v[1, 1]
    rows = [(taut * 0.8, "string.1.y", v[1, 1] * taut * 0.8, 1e-7), (taut * 0.8, "string.0.x", 0.0, 1e-7)]
    at = x + v * taut
    u = (at[1] - at[0]) / l
    agree(np.linalg.norm(at[1] - at[0]), l, 1e-12)
    impulse = m.prod() / m.sum() * (v[1] - v[0]) @ u
    v = v + np.outer([1, -1] / m, impulse * u)
    agree((v[1] - v[0]) @ u, 0, 1e-12)
    # Afterwards they turn about the centre of mass as a dumbbell.
    middle, speed = m @ at / m.sum(), m @ v / m.sum()
    arm, turn = at[1] - at[0], v[1] - v[0]
    rate = np.linalg.norm(turn) / l
    for t in (taut + 0.02, 0.5 * (taut + end), end):
        s = t - taut
        now = arm * np.cos(rate * s) + turn / rate * np.sin(rate * s)
        ends = [middle + speed * s - now * m[1] / m.sum(), middle + speed * s + now * m[0] / m.sum()]
        rows += [(t, f"string.{k}.{axis}", ends[k][j], 1e-5) for k in (0, 1) for j, axis in enumerate("xy")]
    return rows
