import numpy as np
from answers import agree, frames, gravity, integrate, Particles, places

VARIED = [{"connectors.rod.to.point_mass": 2.0}, {"gravity": [0.0, -3.7, 0.0], "connectors.rod.mass": 0.1}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene)
    l, each, pivot = rod["length"] / 2, rod["mass"] / 3, np.array(rod["from"]["fixed"])
    m1, m2, fall = each, each + rod["to"]["point_mass"], -g[1]

    def f(t, s):  # the angles from below, and their rates
        a, b, da, db = s
        matrix = np.array([[(m1 + m2) * l, m2 * l * np.cos(a - b)], [l * np.cos(a - b), l]])
        right = [-m2 * l * db**2 * np.sin(a - b) - (m1 + m2) * fall * np.sin(a),
                 l * da**2 * np.sin(a - b) - fall * np.sin(b)]
        return np.concatenate([[da, db], np.linalg.solve(matrix, right)])

    s = integrate(f, [np.pi / 2, 0, 0, 0], times)
    knee = pivot + l * np.array([np.sin(s[:, 0]), -np.cos(s[:, 0]), 0 * s[:, 0]]).T
    end = knee + l * np.array([np.sin(s[:, 1]), -np.cos(s[:, 1]), 0 * s[:, 1]]).T
    masses = np.array([np.inf, m1, m2])
    system = Particles([pivot, pivot + [l, 0, 0], pivot + [l, -l, 0]], masses, [(0, 1), (1, 2)],
                       lambda t, x, v: np.array([[0], [m1], [m2]]) * g)
    x = system.run(times)[0]
    agree(x[:, 1], knee, 1e-7)
    agree(x[:, 2], end, 1e-7)
    return places(times, "rod.1", knee, 1e-5, "xy") + places(times, "rod.2", end, 1e-5, "xy")
