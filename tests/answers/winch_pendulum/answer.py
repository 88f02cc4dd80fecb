import numpy as np
from answers import agree, between_keys, frames, gravity, integrate, places

VARIED = [
    {"connectors.rope.from.winch": [{"t": 0.0, "paid_out": 0.0}, {"t": 1.0, "paid_out": -0.4}], "duration": 1.0},
    {"connectors.rope.to.point_mass": 0.01},
]


def answer(scene):
    rope, g, times = scene["connectors"]["rope"], gravity(scene), frames(scene, 5)
    pivot, keys = np.array(rope["from"]["fixed"]), rope["from"]["winch"]
    each = rope["mass"] / 2  # of a particle: half of it flows, half stays with the end
    density = each / rope["length"]
    way = np.array(rope["start"]["direction"])
    angle = np.arctan2(way[0], -way[1])

    def paid(t):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        h = rope["length"] + out
        return h, speed, acceleration, rope["to"]["point_mass"] + each / 2 + density * h / 2

    def polar(t, s):
        h, dh, _, mass = paid(t)
        return np.array([s[1], (-2 * dh * s[1] + g[1] * np.sin(s[0]) - density / 2 * dh * h * s[1] / mass) / h])

    def cartesian(t, s):
        h, dh, ddh, mass = paid(t)
        x, v = s[:2], s[2:]
        free = g[:2] - density / 2 * dh * v / mass
        pull = (free @ x + v @ v - dh**2 - h * ddh) / h**2
        return np.concatenate([v, free - pull * x])

    s = integrate(polar, [angle, 0], times)
    h = np.array([paid(t)[0] for t in times])
    states = pivot + np.array([h * np.sin(s[:, 0]), -h * np.cos(s[:, 0]), 0 * h]).T
    start = rope["length"] * np.array([np.sin(angle), -np.cos(angle), 0, 0])
    agree(integrate(cartesian, start, times)[:, :2] + pivot[:2], states[:, :2], 1e-7)
    return places(times, "rope.1", states, 1e-5)
