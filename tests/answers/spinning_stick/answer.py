import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"bodies.stick.spin": [0.0, 0.0, -31.0]}, {"bodies.stick.shape.cylinder.length": 0.05}]


def answer(scene):
    stick, g, times = scene["bodies"]["stick"], gravity(scene), frames(scene)
    rate = stick["spin"][2]
    y = integrate(lambda t, q: 0.5 * rate * np.array([-q[1], q[0]]), [1.0, 0.0], times)
    rows = []
    for t, q in zip(times, y):
        agree([np.cos(rate * t / 2), np.sin(rate * t / 2)], q, 1e-9)
        rows += [(t, "stick.qw", q[0], 1e-6), (t, "stick.qz", q[1], 1e-6), (t, "stick.wz", rate, 1e-6)]
    x = [np.array(stick["position"]) + np.array(stick["velocity"]) * t + g * t * t / 2 for t in times]
    return rows + places(times, "stick", x, 1e-6)
