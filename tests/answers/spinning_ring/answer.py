import numpy as np
from answers import agree, frames, Particles

VARIED = [{"connectors.ring.particles": 7}, {"connectors.ring.start.spin": [0.0, -30.0, 0.0]}]


def answer(scene):
    ring, times = scene["connectors"]["ring"], frames(scene)
    n, rate = ring["particles"] - 1, ring["start"]["spin"][1]
    l, each = ring["length"] / n, ring["mass"] / n
    radius = l / (2 * np.sin(np.pi / n))
    tension = each * radius * rate**2 / (2 * np.sin(np.pi / n))
    angles = 2 * np.pi * np.arange(n) / n
    points = radius * np.array([np.cos(angles), 0 * angles, -np.sin(angles)]).T
    system = Particles(points, np.full(n, each), [(k, (k + 1) % n) for k in range(n)],
                       lambda t, x, v: np.zeros_like(x), np.cross([0, rate, 0], points))
    agree(system.accelerations(0, system.x, system.v)[1], np.full(n, tension), 1e-9 * tension)
    # Where the polygon's first corner is, taut says in the first frame alone; distances do not depend on it.
    rows = []
    for t in times:
        rows += [(t, f"ring.{k}-{k + 1}.tension", tension, 1e-5 * tension) for k in range(n)]
        rows += [(t, "angular_momentum.y", ring["mass"] * radius**2 * rate, 1e-6 * ring["mass"] * radius**2 * abs(rate)),
                 (t, "kinetic_energy", ring["mass"] * (radius * rate) ** 2 / 2, 1e-6 * ring["mass"] * (radius * rate) ** 2),
                 (t, "ring.0.y", ring["start"]["circle"]["centre"][1], 5e-6)]
    return rows
