import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"connectors.rope.start.spin": [0.0, 8.0, 0.0]}, {"connectors.rope.from.point_mass": 1.0}]


def answer(scene):
    rope, g, times = scene["connectors"]["rope"], gravity(scene), frames(scene, 5)
    big, m, before = rope["from"]["point_mass"], rope["to"]["point_mass"], rope["start"]["before"]
    left, eye = np.array(scene["pulleys"]["left"]["fixed"]), np.array(scene["pulleys"]["hole"]["fixed"])
    r0 = rope["length"] - before - np.linalg.norm(eye - left)
    turn = rope["start"]["spin"][1]

    def cartesian(t, s):
        x, v = s[:3], s[3:]
        r = np.linalg.norm(x)
        u = x / r
        bend = (v @ v - (v @ u) ** 2) / r
        tension = (g @ u + bend - g[1]) / (1 / m + 1 / big)
        return np.concatenate([v, g - tension * u / m])

    def spherical(t, s):  # r, the angle from below, its rates, the angle round
        r, a, dr, da, _ = s
        round_ = r0**2 * turn / (r * np.sin(a)) ** 2
        felt = r * (da**2 + np.sin(a) ** 2 * round_**2)
        return np.array([dr, da, (m * felt - g[1] * (m * np.cos(a) - big)) / (m + big),
                         (-2 * dr * da + g[1] * np.sin(a)) / r + np.sin(a) * np.cos(a) * round_**2, round_])

    y = integrate(cartesian, [r0, 0, 0, 0, 0, -r0 * turn], times)
    s = integrate(spherical, [r0, np.pi / 2, 0, 0, 0], times)
    states = eye + np.array([s[:, 0] * np.sin(s[:, 1]) * np.cos(s[:, 4]), -s[:, 0] * np.cos(s[:, 1]),
                             -s[:, 0] * np.sin(s[:, 1]) * np.sin(s[:, 4])]).T
    agree(y[:, :3] + eye, states, 1e-7)
    rows = places(times, "rope#3.1", states, 1e-5)
    return rows + [(t, "rope.0.y", left[1] - before + (r - r0), 1e-5) for t, r in zip(times, s[:, 0])]
