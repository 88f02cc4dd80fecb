import numpy as np
from answers import agree

VARIED = [{"touching.balls.restitution": 0.0}, {"touching.balls.restitution": 1.0, "bodies.right.mass": 50.0}]


def answer(scene):
    left, right, e = scene["bodies"]["left"], scene["bodies"]["right"], scene["touching"]["balls"]["restitution"]
    m, v = np.array([left["mass"], right["mass"]]), np.array([left["velocity"][0], right["velocity"][0]])
    x = np.array([left["position"][0], right["position"][0]])
    meets = (x[1] - x[0] - left["shape"]["sphere"]["diameter"]) / (v[0] - v[1])
    after = np.linalg.solve([m, [-1, 1]], [m @ v, e * (v[0] - v[1])])
    lost = 0.5 * m.prod() / m.sum() * (v[0] - v[1]) ** 2 * (1 - e * e)
    agree(0.5 * m @ v**2 - 0.5 * m @ after**2, lost, 1e-12)
    rows = []
    for k, name in enumerate(("left", "right")):
        rows += [(meets / 2, f"{name}.x", x[k] + v[k] * meets / 2, 1e-7)]
        for t in (meets + 0.1, scene["duration"]):
            rows += [(t, f"{name}.x", x[k] + v[k] * meets + after[k] * (t - meets), 1e-6),
                     (t, f"{name}.vx", after[k], 1e-6)]
    return rows
