import numpy as np
from answers import agree, elliptic_k, frames, gravity, integrate, jacobi

VARIED = [{"connectors.rod.length": 0.9}, {"connectors.rod.to.point_mass": 3.0}]


def answer(scene):
    rod, times = scene["connectors"]["rod"], frames(scene, 6)
    y, z = rod["start"]["direction"][1:]
    start, rate = np.arctan2(z, -y), np.sqrt(-gravity(scene)[1] / rod["length"])
    k = np.sin(start / 2)
    ode = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    rows = []
    for t, state in zip(times, ode):
        theta = 2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0])
        agree(theta, state[0], 1e-7)
        rows += [(t, "rod.1.z", rod["length"] * np.sin(theta), 1e-4),
                 (t, "rod.1.y", -rod["length"] * np.cos(theta), 1e-4)]
    return rows
