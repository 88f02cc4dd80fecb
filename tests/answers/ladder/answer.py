import numpy as np
from answers import agree, event, gravity, integrate

VARIED = [{"bodies.ladder.shape.cylinder.diameter": 0.3}, {"gravity": [0.0, -20.0, 0.0], "duration": 0.5}]


def answer(scene):
    ladder, fall = scene["bodies"]["ladder"], -gravity(scene)[1]
    m, size, h, r = ladder["mass"], ladder["shape"]["cylinder"], 0.4, 0.01
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    start, rate = np.arctan(0.5), m * fall * h / (inertia + m * h * h)
    # Turned by start to the left: the low end stands away from the wall.
    f = lambda t, s: np.array([s[1], rate * np.sin(s[0])])
    wall = lambda t, s: rate * np.sin(s[0]) * np.cos(s[0]) - np.sin(s[0]) * s[1] ** 2  # of x''/h
    leaves, s = event(f, [start, 0], 0.0, wall, 0.02, 3.0)
    agree(np.cos(s[0]), 2 / 3 * np.cos(start), 1e-9)
    agree(s[1] ** 2, 2 * rate * (np.cos(start) - np.cos(s[0])), 1e-9)
    rows = []
    for t in (leaves * 0.4, leaves * 0.7, leaves * 0.95):
        a, w = integrate(f, [start, 0], [t])[0]
        rows += [(t, "ladder.x", r + h * np.sin(a), 2e-5), (t, "ladder.y", r + h * np.cos(a), 2e-5), (t, "ladder.wz", w, 1e-3)]
    speed = h * np.cos(s[0]) * s[1]
    for t in (leaves + 0.02, leaves + 0.05):
        rows += [(t, "ladder.vx", speed, 1e-4), (t, "ladder.x", r + h * np.sin(s[0]) + speed * (t - leaves), 2e-5)]
    return rows
