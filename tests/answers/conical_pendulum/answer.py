import numpy as np
from answers import agree, frames, gravity, Particles, places

VARIED = [{"connectors.rod.to.point_mass": 40.0}, {"duration": 0.7, "connectors.rod.from.fixed": [1.0, 0.0, 2.0]}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene)
    l, mass, pivot = rod["length"], rod["mass"] / 2 + rod["to"]["point_mass"], np.array(rod["from"]["fixed"])
    sine, cosine = 0.6, 0.8
    rate = np.sqrt(-g[1] / (l * cosine))
    agree(rate, rod["start"]["spin"][1], 1e-13)
    states = [pivot + l * np.array([sine * np.cos(rate * t), -cosine, -sine * np.sin(rate * t)]) for t in times]
    start = pivot + l * np.array([sine, -cosine, 0])
    system = Particles([pivot, start], [np.inf, mass], [(0, 1)], lambda t, x, v: np.array([0, mass]).reshape(2, 1) * g,
                       [[0, 0, 0], [0, 0, -rate * l * sine]])
    agree(system.run(times)[0][:, 1], states, 1e-8)
    rows = places(times, "rod.1", states, 5e-6)
    return rows + [(t, "rod.0-1.tension", -mass * g[1] / cosine, -1e-4 * mass * g[1] / cosine) for t in times]
