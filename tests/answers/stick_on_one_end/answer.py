import numpy as np
from answers import agree, gravity

VARIED = [
    {"obstacles.floor.restitution": 0.0},
    {"obstacles.floor.restitution": 1.0, "bodies.stick.rotation": [0.76484218728448838, 0.0, 0.0, -0.64421768723769102]},
    {"bodies.stick.rotation": [0.99500416527802582, 0.0, 0.0, -0.099833416646828155], "bodies.stick.shape.cylinder.length": 0.3},
]


def answer(scene):
    stick, fall, e = scene["bodies"]["stick"], -gravity(scene)[1], scene["obstacles"]["floor"]["restitution"]
    m, size = stick["mass"], stick["shape"]["cylinder"]
    r, length = size["diameter"] / 2, size["length"]
    tilt = 2 * np.arctan2(stick["rotation"][3], stick["rotation"][0])  # of its axis from upright
    half = length / 2 - r  # to the middle of the cap
    inertia = m * (3 * r * r + length**2) / 12
    low = np.array([half * np.sin(tilt), -half * np.cos(tilt)])
    drop = stick["position"][1] + low[1] - r
    hits, speed = np.sqrt(2 * drop / fall), np.sqrt(2 * drop * fall)
    push = (1 + e) * speed / (1 / m + low[0] ** 2 / inertia)
    v, w = -speed + push / m, low[0] * push / inertia
    agree(v + w * low[0], e * speed, 1e-12)
    if e == 1:
        agree(m * v * v + inertia * w * w, m * speed**2, 1e-9)
    t = hits + 1e-3  # so that programs with a step can have seen the impact
    rows = [(t, "stick.vy", v - 1e-3 * fall, 1e-6 * speed), (t, "stick.wz", w, 1e-6 * abs(w)), (t, "stick.vx", 0.0, 1e-9)]
    if e > 0:
        t = hits + 0.01
        rows += [(t, "stick.y", stick["position"][1] - drop + v * 0.01 - fall * 0.01**2 / 2, 1e-7), (t, "stick.wz", w, 1e-6 * abs(w))]
    return rows
