import numpy as np
from answers import agree

VARIED = [{"touching.balls.restitution": 0.5}, {"bodies.c.mass": 0.4}]


def answer(scene):
    names, e = ["a", "b", "c"], scene["touching"]["balls"]["restitution"]
    bodies = [scene["bodies"][name] for name in names]
    x = np.array([body["position"][0] for body in bodies])
    v = np.array([body.get("velocity", [0.0])[0] for body in bodies])
    m, d, t, end, rows = np.array([body["mass"] for body in bodies]), 0.05, 0.0, scene["duration"], []
    momentum = m @ v
    while True:  # from impact to impact
        wait = [(x[k + 1] - x[k] - d) / (v[k] - v[k + 1]) if v[k] > v[k + 1] + 1e-12 else np.inf for k in range(2)]
        k = int(np.argmin(wait))
        step = min(wait[k], end - t)
        rows += [(t + step / 2, f"{name}.x", at, 1e-6) for name, at in zip(names, x + v * step / 2)]
        x, t = x + v * step, t + step
        if t >= end:
            return rows
        mean = (m[k] * v[k] + m[k + 1] * v[k + 1]) / (m[k] + m[k + 1])
        v[k], v[k + 1] = mean - e * m[k + 1] * (v[k] - v[k + 1]) / (m[k] + m[k + 1]), mean + e * m[k] * (v[k] - v[k + 1]) / (m[k] + m[k + 1])
        agree(m @ v, momentum, 1e-12)
