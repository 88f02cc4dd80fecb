import numpy as np
from answers import agree, frames, gravity

VARIED = [{"bodies.ball.mass": 9.0}, {"gravity": [0.0, -3.7, 0.0]}]


def answer(scene):
    ball, fall, slope = scene["bodies"]["ball"], -gravity(scene)[1], 0.2
    r, m = ball["shape"]["sphere"]["diameter"] / 2, ball["mass"]
    inertia = 0.4 * m * r * r
    a = fall * np.sin(slope) * 5 / 7
    # Newton and Euler: m a = m g sin - F, I a/r = F r, with F below the friction's bound.
    solved = np.linalg.solve([[m, 1], [inertia / r, -r]], [m * fall * np.sin(slope), 0])
    agree(solved[0], a, 1e-12)
    assert solved[1] < scene["obstacles"]["slope"]["friction"] * m * fall * np.cos(slope)
    x0, rows = np.array(ball["position"]), []
    for t in frames(scene):
        x = x0 - a * t * t / 2 * np.array([np.cos(slope), np.sin(slope), 0])
        rows += [(t, "ball.x", x[0], 1e-5), (t, "ball.y", x[1], 1e-5), (t, "ball.wz", a * t / r, 1e-4)]
    return rows
