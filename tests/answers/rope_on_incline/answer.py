import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"obstacles.slope.friction": 0.1}, {"obstacles.slope.friction": 0.6}]


def answer(scene):
    rope, fall, mu, times = scene["connectors"]["rope"], -gravity(scene)[1], scene["obstacles"]["slope"]["friction"], frames(scene)
    slope, n = np.arctan(0.5), scene["connectors"]["rope"]["particles"]
    a = max(0.0, fall * (np.sin(slope) - mu * np.cos(slope)))
    x0, weight = np.array(rope["start"]["points"][0]), rope["mass"] * fall
    y = integrate(lambda t, s: np.array([s[1], a]), [0, 0], times)[:, 0]
    rows = []
    for t, way in zip(times, y):
        agree(way, a * t * t / 2, 1e-10)
        for k in (0, n - 1):
            s = rope["length"] * k / (n - 1) - way
            rows += [(t, f"rope.{k}.x", x0[0] + s * np.cos(slope), 1e-6), (t, f"rope.{k}.y", x0[1] + s * np.sin(slope), 1e-6)]
        if a:
            rows.append((t, "rope.3-4.tension", 0.0, 1e-4 * weight))
    return rows
