import numpy as np
from answers import frames, gravity, pendulum_angles, places

VARIED = [{"bodies.stick.mass": 4.0}]


def answer(scene):
    stick, times, h = scene["bodies"]["stick"], frames(scene), 0.3
    size = stick["shape"]["cylinder"]
    inertia = (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    start, rate = np.pi / 2, np.sqrt(-gravity(scene)[1] * h / (inertia + h * h))
    states = []
    for theta in pendulum_angles(start, rate, times):
        states.append(np.array([0, 1, 0]) + h * np.array([np.sin(theta), -np.cos(theta), 0]))
    return places(times, "stick", states, 2e-4)
