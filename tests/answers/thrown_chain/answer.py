import numpy as np
from answers import agree, frames, gravity, Particles

VARIED = [{"connectors.chain.start.spin": [3.0, 0.0, -2.0]}, {"connectors.chain.particles": 4}]


def answer(scene):
    chain, g, times = scene["connectors"]["chain"], gravity(scene), frames(scene)
    n, mass = chain["particles"], chain["mass"]
    a, b = np.array(chain["start"]["points"])
    spin = np.array(chain["start"]["spin"])
    points = np.array([a + (b - a) * k / (n - 1) for k in range(n)])
    speeds = np.cross(spin, points - a)
    middle, speed = points.mean(axis=0), speeds.mean(axis=0)
    arm, sweep = (b - a) / 2, speeds[-1] - speed
    rate = np.linalg.norm(sweep) / np.linalg.norm(arm)
    each = mass / n
    kinetic = 0.5 * each * np.sum(speeds**2)
    total = kinetic - each * np.sum(points @ g)
    system = Particles(points, np.full(n, each), [(k, k + 1) for k in range(n - 1)], lambda t, x, v: each * np.ones((n, 1)) * g, speeds)
    x, _ = system.run(times)
    rows = []
    for i, t in enumerate(times):
        end = middle + speed * t + g * t * t / 2 + np.cos(rate * t) * arm + np.sin(rate * t) * sweep / rate
        agree(x[i, -1], end, 1e-8)
        rows += [(t, f"chain.{n - 1}.{axis}", end[j], 5e-6) for j, axis in enumerate("xyz")]
        rows += [(t, f"momentum.{axis}", (mass * (speed + g * t))[j], 1e-6 * mass) for j, axis in enumerate("xyz")]
        rows += [(t, "energy", total, 1e-6 * abs(kinetic))]
    return rows
