import numpy as np
from answers import agree, Particles, places

VARIED = [{"connectors.rod.to.point_mass": 2.0}, {"connectors.rod.start.spin": [0.0, 7.0, 0.0]}]


def answer(scene):
    rod, cut, end = scene["connectors"]["rod"], scene["cuts"][0]["t"], scene["duration"]
    x = np.linspace(*np.array(rod["start"]["points"]), 3)
    each = rod["mass"] / 3
    masses = np.array([each + rod["from"]["point_mass"], each, each + rod["to"]["point_mass"]])
    spin = np.array(rod["start"]["spin"])
    v = np.cross(spin, x - x[0])
    system = Particles(x, masses, [(0, 1), (1, 2)], lambda t, x, v: 0 * x, v)
    places_then, speeds = system.run([cut])
    x, v = places_then[0], speeds[0]
    rows = []
    # The particle at the cut becomes two of half its mass.
    for name, part, share in (("rod", [0, 1], [1, 0.5]), ("rod'", [1, 2], [0.5, 1])):
        m = masses[part] * share
        half = Particles(x[part], m, [(0, 1)], lambda t, x, v: 0 * x, v[part])
        times = [end - cut - 0.2, end - cut]
        later = half.run(times)[0]
        centre, speed = m @ x[part] / m.sum(), m @ v[part] / m.sum()
        for s, state in zip(times, later):
            arm, turn = x[part][1] - x[part][0], v[part][1] - v[part][0]
            rate = np.linalg.norm(turn) / np.linalg.norm(arm)
            now = arm * np.cos(rate * s) + turn / rate * np.sin(rate * s)
            middle = centre + speed * s
            ends = [middle - now * m[1] / m.sum(), middle + now * m[0] / m.sum()]
            agree(ends, state, 1e-8)
            rows += places([cut + s], f"{name}.0", [ends[0]], 3e-6) + places([cut + s], f"{name}.1", [ends[1]], 3e-6)
    return rows
