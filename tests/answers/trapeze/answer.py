import numpy as np
from answers import frames, gravity, pendulum_angles

VARIED = [{"gravity": [0.0, -2.0, 0.0]}, {"bodies.bar.mass": 0.01}]


def answer(scene):
    l, times = scene["connectors"]["left"]["length"], frames(scene)
    x, y = scene["bodies"]["bar"]["position"][:2]
    start, rate = np.arctan2(x, -y), np.sqrt(-gravity(scene)[1] / l)
    rows = []
    for t, theta in zip(times, pendulum_angles(start, rate, times)):
        rows += [(t, "bar.x", l * np.sin(theta), 5e-6), (t, "bar.y", -l * np.cos(theta), 5e-6),
                 (t, "bar.qz", 0.0, 1e-6)]
    return rows
