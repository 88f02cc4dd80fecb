import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"bodies.bar.spin": [0.0, 0.5, 0.0]}, {"bodies.bar.mass": 20.0}]


def answer(scene):
    bar, fall, times = scene["bodies"]["bar"], -gravity(scene)[1], frames(scene)
    l, a, size, m = 0.5, 0.3, bar["shape"]["cylinder"], bar["mass"]
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    height = lambda p: -np.sqrt(l * l - 4 * a * a * np.sin(p / 2) ** 2)
    slope = lambda p: -a * a * np.sin(p) / height(p)  # dh/dp, height is negative
    bend = lambda p: -a * a * np.cos(p) / height(p) - slope(p) ** 2 / height(p)

    def f(t, s):  # (I + m h'^2) p'' + m h' h'' p'^2 + m g h' = 0
        p, dp = s
        return np.array([dp, -m * slope(p) * (bend(p) * dp**2 + fall) / (inertia + m * slope(p) ** 2)])

    rate = bar["spin"][1]
    rows = []
    for t, (p, dp) in zip(times, integrate(f, [0, rate], times)):
        energy = 0.5 * (inertia + m * slope(p) ** 2) * dp**2 + m * fall * (height(p) + l)
        agree(energy, 0.5 * inertia * rate**2, 1e-9 * inertia * rate**2 + 1e-11)
        rows += [(t, "bar.y", height(p), 2e-5), (t, "bar.wy", dp, 1e-3), (t, "bar.x", 0.0, 2e-5)]
    return rows
