import numpy as np
from answers import agree, gravity, integrate

VARIED = [{"bodies.rod.shape.cylinder.diameter": 0.2}, {"gravity": [0.0, -1.62, 0.0], "duration": 1.2}]


def answer(scene):
    rod, fall, end = scene["bodies"]["rod"], -gravity(scene)[1], scene["duration"]
    m, size, h = rod["mass"], rod["shape"]["cylinder"], 0.4
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12 + m * h * h
    rate = m * fall * h / inertia
    times = [0.0, end / 4, end / 2, end]
    y = integrate(lambda t, s: np.array([s[1], -rate * np.cos(s[0])]), [0, 0], times)
    rows = []
    for t, (a, w) in zip(times, y):
        agree(w * w, -2 * rate * np.sin(a), 1e-9)
        out, on = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        force = m * (h * (-rate * np.cos(a) * on - w * w * out) + [0, fall])
        rows += [(t, "hinge.0.hold.x", force[0], 1e-4 * m * fall), (t, "hinge.0.hold.y", force[1], 1e-4 * m * fall),
                 (t, "rod.wz", w, 1e-4), (t, "rod.x", h * out[0], 1e-5), (t, "rod.y", 1 + h * out[1], 1e-5)]
    return rows
