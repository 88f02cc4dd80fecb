import numpy as np
from answers import agree, elliptic_k, frames, gravity, integrate, jacobi, places

VARIED = [{"bodies.stick.mass": 4.0}]


def answer(scene):
    stick, times, h = scene["bodies"]["stick"], frames(scene), 0.3
    size = stick["shape"]["cylinder"]
    inertia = (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    start, rate = np.pi / 2, np.sqrt(-gravity(scene)[1] * h / (inertia + h * h))
    k = np.sin(start / 2)
    ode = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    states = []
    for t, state in zip(times, ode):
        theta = 2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0])
        agree(theta, state[0], 1e-9)
        states.append(np.array([0, 1, 0]) + h * np.array([np.sin(theta), -np.cos(theta), 0]))
    return places(times, "stick", states, 2e-4)
