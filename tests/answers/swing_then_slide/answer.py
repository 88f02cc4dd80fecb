import numpy as np
from answers import agree, elliptic_k, gravity, integrate

VARIED = [{"connectors.cord.to.point_mass": 7.0}]


def answer(scene):
    cord, fall, caught, end = scene["connectors"]["cord"], -gravity(scene)[1], scene["pins"][0]["from"], scene["duration"]
    l, start = cord["length"], np.arctan2(0.6, 0.8)
    rate = np.sqrt(fall / l)
    swing = lambda r: lambda t, s: np.array([s[1], -r * r * np.sin(s[0])])
    a, w = integrate(swing(rate), [start, 0], [caught])[0]
    quarter = elliptic_k(np.sin(start / 2) ** 2) / rate
    agree(caught, quarter, 1e-2)  # near the lowest point
    agree(w * w, 2 * rate**2 * (np.cos(a) - np.cos(start)), 1e-9)
    pin = np.array([0, 1]) + l / 2 * np.array([np.sin(a), -np.cos(a)])
    times = [caught + 0.1, 0.5 * (caught + end), end]
    rows = []
    for t, s in zip(times, integrate(swing(np.sqrt(2) * rate), [a, 2 * w], times, caught)):
        at = pin + l / 2 * np.array([np.sin(s[0]), -np.cos(s[0])])
        rows += [(t, "cord.2.x", at[0], 2e-4), (t, "cord.2.y", at[1], 2e-4), (t, "cord.1.x", pin[0], 1e-4)]
    return rows
