import numpy as np
from answers import frames, gravity, pendulum_angles

VARIED = [{"gravity": [0.0, -3.7, 0.0]}, {"connectors.beam.mass": 0.06}]


def answer(scene):
    l, fall, times = scene["connectors"]["a"]["length"], -gravity(scene)[1], frames(scene)
    start, rate = np.arctan2(0.24, -0.32), np.sqrt(-gravity(scene)[1] / scene["connectors"]["a"]["length"])
    rows = []
    for t, theta in zip(times, pendulum_angles(start, rate, times)):
        rows += [(t, "beam.2.x", 0.8 + l * np.sin(theta), 1e-4), (t, "beam.2.y", -l * np.cos(theta), 1e-4),
                 (t, "beam.1.x", 0.4 + l * np.sin(theta), 1e-4)]
    return rows
