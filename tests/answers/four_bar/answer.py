import numpy as np
from answers import agree, frames, gravity, integrate, jacobi, elliptic_k

VARIED = [{"connectors.coupler.mass": 5.0}, {"connectors.left.mass": 1.7, "duration": 0.8}]


def answer(scene):
    l, fall, times = scene["connectors"]["left"]["length"], -gravity(scene)[1], frames(scene)
    start = np.arctan2(0.3, -0.4)  # from below
    # Every moving mass goes round at l: it is a pendulum of that length, whatever the masses.
    rate = np.sqrt(fall / l)
    k = np.sin(start / 2)
    y = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    rows = []
    for t, s in zip(times, y):
        theta = 2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0])
        agree(theta, s[0], 1e-9)
        at = l * np.array([np.sin(theta), -np.cos(theta)])
        rows += [(t, "left.1.x", at[0], 1e-5), (t, "left.1.y", at[1], 1e-5),
                 (t, "coupler.1.x", at[0] + 0.8, 1e-5), (t, "right.1.y", at[1], 1e-5)]
    return rows
