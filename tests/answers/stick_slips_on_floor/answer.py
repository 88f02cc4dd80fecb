import numpy as np
from answers import agree, gravity, integrate

VARIED = [{"bodies.stick.mass": 6.0}, {"bodies.stick.shape.cylinder.diameter": 0.2}]


def answer(scene):
    stick, fall, end = scene["bodies"]["stick"], -gravity(scene)[1], scene["duration"]
    m, size, h, r = stick["mass"], stick["shape"]["cylinder"], 0.25, 0.01
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    lean = 2 * np.arctan2(0.19611613513818404, 0.98058067569092011)
    agree(r + h * np.cos(lean), stick["position"][1], 1e-12)

    def f(t, s):  # height y = r + h cos a; Lagrange: (I + m h^2 sin^2) a'' + m h^2 sin cos a'^2 = m g h sin
        a, w = s
        return np.array([w, (m * fall * h * np.sin(a) - m * h * h * np.sin(a) * np.cos(a) * w * w) / (inertia + m * h * h * np.sin(a) ** 2)])

    times = [end * 0.3, end * 0.6, end * 0.9]
    rows = []
    for t, (a, w) in zip(times, integrate(f, [lean, 0], times)):
        agree(0.5 * (inertia + m * (h * np.sin(a)) ** 2) * w * w, m * fall * h * (np.cos(lean) - np.cos(a)), 1e-9)
        rows += [(t, "stick.y", r + h * np.cos(a), 2e-5), (t, "stick.wz", -w, 1e-3), (t, "stick.x", 0.0, 1e-6)]
    return rows
