import numpy as np
from answers import agree, elliptic_k, frames, gravity, integrate, jacobi, places

VARIED = [
    {"connectors.rod.length": 0.4, "connectors.rod.start.direction": [0.1, -1.0, 0.0]},
    {"gravity": [0.0, -1.62, 0.0], "connectors.rod.start.direction": [-1.0, 1.0, 0.0]},
]


def answer(scene):
    rod, times = scene["connectors"]["rod"], frames(scene)
    x, y = rod["start"]["direction"][:2]
    start, rate = np.arctan2(x, -y), np.sqrt(-gravity(scene)[1] / rod["length"])
    k = np.sin(start / 2)
    ode = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    states = []
    for t, state in zip(times, ode):
        theta = 2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0])
        agree(theta, state[0], 1e-9)
        states.append(np.array(rod["from"]["fixed"]) + rod["length"] * np.array([np.sin(theta), -np.cos(theta), 0]))
    return places(times, "rod.1", states, 1e-7)
