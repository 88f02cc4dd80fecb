import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"connectors.rope.from.point_mass": 2.2}, {"connectors.rope.start.direction": [1.0, -1.0, 0.0]}]


def answer(scene):
    rope, g, times = scene["connectors"]["rope"], gravity(scene), frames(scene, 5)
    big, m, before = rope["from"]["point_mass"], rope["to"]["point_mass"], rope["start"]["before"]
    left, eye = np.array(scene["pulleys"]["left"]["fixed"]), np.array(scene["pulleys"]["right"]["fixed"])
    r0 = rope["length"] - before - np.linalg.norm(eye - left)
    way = np.array(rope["start"]["direction"])
    angle = np.arctan2(way[0], -way[1])

    def polar(t, s):
        r, a, dr, da = s
        return np.array([dr, da, (m * r * da**2 - g[1] * (m * np.cos(a) - big)) / (m + big), (-2 * dr * da + g[1] * np.sin(a)) / r])

    def cartesian(t, s):  # the place from the eye, its speed; the tension T
        x, v = s[:2], s[2:]
        r = np.linalg.norm(x)
        u = x / r
        turn = (v @ v - (v @ u) ** 2) / r  # r'' = a.u + turn; M r'' = T - M g, m a = m g - T u
        tension = (g[1] * u[1] + turn - g[1]) / (1 / m + 1 / big)
        return np.concatenate([v, [-tension * u[0] / m, g[1] - tension * u[1] / m]])

    s = integrate(polar, [r0, angle, 0, 0], times)
    states = eye + np.array([s[:, 0] * np.sin(s[:, 1]), -s[:, 0] * np.cos(s[:, 1]), 0 * s[:, 0]]).T
    y = integrate(cartesian, [r0 * np.sin(angle), -r0 * np.cos(angle), 0, 0], times)
    agree(y[:, :2] + eye[:2], states[:, :2], 1e-8)
    rows = places(times, "rope#3.1", states, 2e-7)
    return rows + [(t, "rope.0.y", left[1] - before + (r - r0), 2e-7) for t, r in zip(times, s[:, 0])]
