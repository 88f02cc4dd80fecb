import numpy as np
from answers import agree, frames, gravity, integrate, Particles, places, unit

VARIED = [{"connectors.rod.start.spin": [0.0, -5.0, 0.0]}, {"connectors.rod.start.direction": [0.2, -1.0, 0.0]}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene, 5)
    l, pivot = rod["length"], np.array(rod["from"]["fixed"])
    mass = rod["mass"] / 2 + rod["to"]["point_mass"]
    d = unit(rod["start"]["direction"])
    theta, turn = np.arctan2(d[0], -d[1]), rod["start"]["spin"][1]
    area = np.sin(theta) ** 2 * turn

    def f(t, s):  # theta, its rate, the angle round
        return np.array([s[1], area**2 * np.cos(s[0]) / np.sin(s[0]) ** 3 + g[1] / l * np.sin(s[0]),
                         area / np.sin(s[0]) ** 2])

    s = integrate(f, [theta, 0, 0], times)
    states = pivot + l * np.array([np.sin(s[:, 0]) * np.cos(s[:, 2]), -np.cos(s[:, 0]),
                                   -np.sin(s[:, 0]) * np.sin(s[:, 2])]).T
    spin = np.array(rod["start"]["spin"])
    system = Particles([pivot, pivot + l * d], [np.inf, mass], [(0, 1)],
                       lambda t, x, v: np.array([[0], [mass]]) * g, [[0, 0, 0], np.cross(spin, l * d)])
    agree(system.run(times)[0][:, 1], states, 1e-8)
    return places(times, "rod.1", states, 5e-6)
