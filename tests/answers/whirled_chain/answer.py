import numpy as np
from answers import agree, frames, Particles

VARIED = [{"connectors.chain.start.spin": [0.0, -40.0, 0.0]}, {"connectors.chain.particles": 3}]


def answer(scene):
    chain, times = scene["connectors"]["chain"], frames(scene)
    n, spin = chain["particles"], np.array(chain["start"]["spin"])
    masses = np.full(n, chain["mass"] / n)
    masses[-1] += chain["to"]["point_mass"]
    r, rate = np.linspace(0, chain["length"], n), np.linalg.norm(spin)
    tension = [rate**2 * np.sum((masses * r)[k + 1:]) for k in range(n - 1)]
    side = np.cross(spin / rate, [1, 0, 0])
    heavy = masses.copy()
    heavy[0] = np.inf
    system = Particles(np.outer(r, [1, 0, 0]), heavy, [(k, k + 1) for k in range(n - 1)],
                       lambda t, x, v: np.zeros_like(x), np.outer(r * rate, side))
    agree(system.accelerations(0, system.x, system.v)[1], tension, 1e-9 * tension[0])
    rows = []
    for t in times:
        way = np.cos(rate * t) * np.array([1, 0, 0]) + np.sin(rate * t) * side
        rows += [(t, f"chain.{n - 1}.{axis}", r[-1] * way[j], 5e-6) for j, axis in enumerate("xyz")]
        rows += [(t, f"chain.{k}-{k + 1}.tension", tension[k], 1e-5 * tension[0]) for k in range(n - 1)]
        rows += [(t, f"chain.0.hold.{axis}", -tension[0] * way[j], 1e-4 * tension[0]) for j, axis in enumerate("xyz")]
    return rows
