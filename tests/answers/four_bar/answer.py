import numpy as np
from answers import frames, gravity, pendulum_angles

VARIED = [{"connectors.coupler.mass": 5.0}, {"connectors.left.mass": 1.7, "duration": 0.8}]


def answer(scene):
    l, fall, times = scene["connectors"]["left"]["length"], -gravity(scene)[1], frames(scene)
    start = np.arctan2(0.3, -0.4)  # from below
    # Every moving mass goes round at l: it is a pendulum of that length, whatever the masses.
    rate = np.sqrt(fall / l)
    rows = []
    for t, theta in zip(times, pendulum_angles(start, rate, times)):
        at = l * np.array([np.sin(theta), -np.cos(theta)])
        rows += [(t, "left.1.x", at[0], 1e-5), (t, "left.1.y", at[1], 1e-5),
                 (t, "coupler.1.x", at[0] + 0.8, 1e-5), (t, "right.1.y", at[1], 1e-5)]
    return rows
