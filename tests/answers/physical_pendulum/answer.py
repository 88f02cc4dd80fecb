import numpy as np
from answers import frames, gravity, pendulum_angles, places

VARIED = [{"bodies.stick.hangs": [1.0, 2.0, 0.0]}, {"bodies.stick.shape.cylinder.diameter": 0.3}]


def answer(scene):
    stick, times = scene["bodies"]["stick"], frames(scene)
    size, h = stick["shape"]["cylinder"], scene["connectors"]["joint"]["to"]["point"][1]
    inertia = (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    x, y = stick["hangs"][:2]
    start, rate = np.arctan2(x, -y), np.sqrt(-gravity(scene)[1] * h / (inertia + h * h))
    states = []
    for theta in pendulum_angles(start, rate, times):
        states.append(np.array([0, 1, 0]) + h * np.array([np.sin(theta), -np.cos(theta), 0]))
    return places(times, "stick", states, 1e-7)
