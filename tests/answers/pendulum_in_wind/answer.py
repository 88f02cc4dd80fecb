import numpy as np
from answers import agree, frames, gravity, integrate, Particles, places

VARIED = [{"air.wind": [-15.0, 0.0, 0.0]}, {"connectors.rod.start.direction": [1.0, -1.0, 0.0]}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene, 5)
    l, mass, pivot = rod["length"], rod["mass"] / 2, np.array(rod["from"]["fixed"])
    factor = 0.5 * scene["air"]["density"] * l * rod["diameter"]
    wind, way = np.array(scene["air"]["wind"]), np.array(rod["start"]["direction"])
    start = np.arctan2(way[0], -way[1])

    def f(t, s):
        across = l / 2 * s[1] - wind[0] * np.cos(s[0])
        push = -factor * rod["drag"]["across"] * abs(across) * across / 2
        return np.array([s[1], g[1] / l * np.sin(s[0]) + push / (mass * l)])

    def force(t, x, v):
        u = (x[1] - x[0]) / np.linalg.norm(x[1] - x[0])
        past = v[1] / 2 - wind
        along = (past @ u) * u
        drag = -factor * (rod["drag"]["across"] * np.linalg.norm(past - along) * (past - along)
                          + rod["drag"]["along"] * np.linalg.norm(along) * along)
        return np.array([[0, 0, 0], drag / 2 + mass * g])

    s = integrate(f, [start, 0], times)
    states = pivot + l * np.array([np.sin(s[:, 0]), -np.cos(s[:, 0]), 0 * s[:, 0]]).T
    system = Particles([pivot, pivot + l * np.array([np.sin(start), -np.cos(start), 0])], [np.inf, mass], [(0, 1)], force)
    agree(system.run(times)[0][:, 1], states, 1e-8)
    return places(times, "rod.1", states, 5e-6)
