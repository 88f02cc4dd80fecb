import numpy as np
from answers import agree, frames, gravity

VARIED = [{"bodies.stick.mass": 8.0}, {"gravity": [0.0, -1.62, 0.0]}]


def answer(scene):
    stick, fall, slope = scene["bodies"]["stick"], -gravity(scene)[1], 0.2
    m, r = stick["mass"], stick["shape"]["cylinder"]["diameter"] / 2
    a = fall * np.sin(slope) * 2 / 3
    agree(np.linalg.solve([[m, 1], [m * r / 2, -r]], [m * fall * np.sin(slope), 0])[0], a, 1e-12)
    x0, rows = np.array(stick["position"]), []
    for t in frames(scene):
        x = x0 - a * t * t / 2 * np.array([np.cos(slope), np.sin(slope), 0])
        rows += [(t, "stick.x", x[0], 1e-7), (t, "stick.y", x[1], 1e-7), (t, "stick.wz", a * t / r, 1e-5), (t, "stick.z", 0.0, 1e-6)]
    return rows
