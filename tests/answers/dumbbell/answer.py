import numpy as np
from answers import agree, frames, gravity, Particles, places

VARIED = [{"connectors.rod.to.point_mass": 0.01}, {"connectors.rod.start.spin": [0.0, 3.0, 4.0]}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene)
    a, b = np.array(rod["start"]["points"])
    masses = np.array([rod["from"]["point_mass"], rod["to"]["point_mass"]]) + rod["mass"] / 2
    speed_b = np.cross(rod["start"]["spin"], b - a)
    middle, speed = (masses[0] * a + masses[1] * b) / masses.sum(), masses[1] * speed_b / masses.sum()
    l, side = np.linalg.norm(b - a), speed_b
    rate = np.linalg.norm(side) / l
    tension = masses.prod() / masses.sum() * l * rate**2
    system = Particles([a, b], masses, [(0, 1)], lambda t, x, v: masses[:, None] * g, [[0, 0, 0], speed_b])
    agree(system.accelerations(0, system.x, system.v)[1], [tension], 1e-9)
    x = system.run(times)[0]
    rows = []
    for i, t in enumerate(times):
        arm = (b - a) * np.cos(rate * t) + side / rate * np.sin(rate * t)
        centre = middle + speed * t + g * t * t / 2
        ends = [centre - arm * masses[1] / masses.sum(), centre + arm * masses[0] / masses.sum()]
        agree(x[i], ends, 1e-8)
        rows += places([t], "rod.0", [ends[0]], 3e-6) + places([t], "rod.1", [ends[1]], 3e-6)
        rows += [(t, "rod.0-1.tension", tension, 1e-5 * tension)]
    return rows
