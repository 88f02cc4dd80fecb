import numpy as np
from answers import agree, gravity

VARIED = [{"obstacles.floor.friction": 0.6}, {"bodies.ball.velocity": [-1.0, 0.0, 0.0]}]


def answer(scene):
    ball, a = scene["bodies"]["ball"], -gravity(scene)[1] * scene["obstacles"]["floor"]["friction"]
    v, r, end = ball["velocity"][0], ball["shape"]["sphere"]["diameter"] / 2, scene["duration"]
    sign, speed = np.sign(v), abs(v)
    rolls = 2 * speed / (7 * a)
    # The angular momentum about a point of the floor stays: m v r = (m r^2 + I) w.
    agree(speed - a * rolls, speed * 5 / 7, 1e-12)
    agree((speed - a * rolls) * r * (1 + 0.4), speed * r, 1e-12)
    half, way = rolls / 2, speed * rolls - a * rolls**2 / 2
    rows = [(half, "ball.x", sign * (speed * half - a * half**2 / 2), 1e-6),
            (half, "ball.wz", -sign * 2.5 * a * half / r, 1e-4)]
    for t in (0.5 * (rolls + end), end):
        rows += [(t, "ball.x", sign * (way + speed * 5 / 7 * (t - rolls)), 2e-5),
                 (t, "ball.wz", -sign * speed * 5 / 7 / r, 1e-4)]
    return rows
