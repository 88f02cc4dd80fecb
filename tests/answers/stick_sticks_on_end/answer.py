import numpy as np
from answers import agree, gravity

VARIED = [{"bodies.stick.mass": 3.0}, {"bodies.stick.position": [0.0, 0.3, 0.0]}]


def answer(scene):
    stick, fall = scene["bodies"]["stick"], -gravity(scene)[1]
    m, size, h = stick["mass"], stick["shape"]["cylinder"], 0.25
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    lean = 2 * np.arctan2(0.38941834230865049, 0.92106099400288508)
    drop = stick["position"][1] - h * np.cos(lean)
    hits, speed = np.sqrt(2 * drop / fall), np.sqrt(2 * drop * fall)
    arm = np.array([-h * np.sin(lean), -h * np.cos(lean)])  # to the end, from the centre
    spin = m * speed * h * np.sin(lean) / (inertia + m * h * h)
    # The second route: two impulses that stop the end.
    # unknowns: w, jx, jy with v = (0, -speed) + j/m and v + w x arm = 0
    rows = np.array([[-arm[1], 1 / m, 0], [arm[0], 0, 1 / m], [inertia, arm[1], -arm[0]]])
    w, jx, jy = np.linalg.solve(rows, [0, speed, 0])
    agree(abs(w), spin, 1e-9)
    t = hits + 1e-6
    return [(t, "stick.wz", w, 1e-3 * abs(w)), (t, "stick.vx", jx / m, 1e-3 * speed), (t, "stick.vy", -speed + jy / m, 1e-3 * speed)]
