import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"connectors.spring.axial_stiffness": 300.0}, {"connectors.spring.start.direction": [1.0, 0.0, 0.0]}]


def answer(scene):
    spring, g, times = scene["connectors"]["spring"], gravity(scene), frames(scene, 5)
    mass, l = spring["to"]["point_mass"] + spring["mass"] / 2, spring["length"]
    k, pivot = spring["axial_stiffness"] / l, np.array(spring["from"]["fixed"])
    way = np.array(spring["start"]["direction"])
    angle = np.arctan2(way[0], -way[1])

    def polar(t, s):
        r, a, dr, da = s
        return np.array([dr, da, r * da**2 - g[1] * np.cos(a) - k / mass * (r - l),
                         (g[1] * np.sin(a) - 2 * dr * da) / r])

    def cartesian(t, s):
        r = np.linalg.norm(s[:3])
        return np.concatenate([s[3:], g - k / mass * (r - l) / r * s[:3]])

    s = integrate(polar, [l, angle, 0, 0], times)
    states = pivot + np.array([s[:, 0] * np.sin(s[:, 1]), -s[:, 0] * np.cos(s[:, 1]), 0 * s[:, 0]]).T
    start = l * np.array([np.sin(angle), -np.cos(angle), 0])
    agree(pivot + integrate(cartesian, np.concatenate([start, [0, 0, 0]]), times)[:, :3], states, 1e-8)
    return places(times, "spring.1", states, 1e-5)
