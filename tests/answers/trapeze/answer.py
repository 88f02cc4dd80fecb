import numpy as np
from answers import agree, elliptic_k, frames, gravity, integrate, jacobi

VARIED = [{"gravity": [0.0, -2.0, 0.0]}, {"bodies.bar.mass": 0.01}]


def answer(scene):
    l, times = scene["connectors"]["left"]["length"], frames(scene)
    x, y = scene["bodies"]["bar"]["position"][:2]
    start, rate = np.arctan2(x, -y), np.sqrt(-gravity(scene)[1] / l)
    k = np.sin(start / 2)
    ode = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    rows = []
    for t, state in zip(times, ode):
        theta = 2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0])
        agree(theta, state[0], 1e-9)
        rows += [(t, "bar.x", l * np.sin(theta), 5e-6), (t, "bar.y", -l * np.cos(theta), 5e-6),
                 (t, "bar.qz", 0.0, 1e-6)]
    return rows
