import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"air.wind": [-12.0, 0.0, 0.0]}, {"connectors.spring.axial_stiffness": 100.0}]


def answer(scene):
    spring, g, times = scene["connectors"]["spring"], gravity(scene), frames(scene)
    l, m = spring["length"], spring["mass"] / 2 + spring["to"]["point_mass"]
    k, c, wind = spring["axial_stiffness"] / l, spring["axial_damping"] / l, scene["air"]["wind"][0]
    push, drag = 0.5 * scene["air"]["density"] * l * spring["diameter"] / 2, spring["drag"]

    def cartesian(t, s):
        x, v = s[:2], s[2:]
        r = np.linalg.norm(x)
        u = x / r
        past = v / 2 - [wind, 0]
        along = (past @ u) * u
        air = -push * (drag["across"] * np.linalg.norm(past - along) * (past - along) + drag["along"] * np.linalg.norm(along) * along)
        pull = k * (r - l) + c * (v @ u)
        return np.concatenate([v, g[:2] + (air - pull * u) / m])

    def polar(t, s):
        r, a, dr, da = s
        along, across = dr / 2 - wind * np.sin(a), r * da / 2 - wind * np.cos(a)
        pull = k * (r - l) + c * dr + push * drag["along"] * abs(along) * along
        return np.array([dr, da, r * da**2 - g[1] * np.cos(a) - pull / m,
                         (-2 * dr * da + g[1] * np.sin(a) - push * drag["across"] * abs(across) * across / m) / r])

    y = integrate(cartesian, [0, -l, 0, 0], times)
    s = integrate(polar, [l, 0, 0, 0], times)
    states = np.array([s[:, 0] * np.sin(s[:, 1]), 1 - s[:, 0] * np.cos(s[:, 1]), 0 * s[:, 0]]).T
    agree(y[:, :2] + [0, 1], states[:, :2], 1e-8)
    return places(times, "spring.1", states, 2e-5)
