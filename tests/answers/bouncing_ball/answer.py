import numpy as np
from answers import agree, gravity, event

VARIED = [{"obstacles.floor.restitution": 0.9}, {"bodies.ball.position": [0.0, 0.3, 0.0], "obstacles.floor.restitution": 0.5, "duration": 0.6}]


def answer(scene):
    ball, fall, e = scene["bodies"]["ball"], -gravity(scene)[1], scene["obstacles"]["floor"]["restitution"]
    height = ball["position"][1] - ball["shape"]["sphere"]["diameter"] / 2
    radius, end, rows = ball["shape"]["sphere"]["diameter"] / 2, scene["duration"], []
    f = lambda t, y: np.array([y[1], -fall])
    start, speed, y = np.sqrt(2 * height / fall), np.sqrt(2 * height * fall), np.array([height, 0.0])
    at, hit = event(f, y, 0.0, lambda t, s: s[0], 0.2, 9.0)
    agree([at, hit[1]], [start, -speed], 1e-9)
    for _ in range(5):
        speed *= e
        last = 2 * speed / fall
        if start + 0.8 * last > end:
            break
        for share in (0.3, 0.8):
            t = start + share * last
            rows += [(t, "ball.y", radius + speed * share * last - fall * (share * last) ** 2 / 2, 1e-6),
                     (t, "ball.x", ball["velocity"][0] * t, 1e-6)]
        at, hit = event(f, [1e-12, -hit[1] * e], at, lambda t, s: s[0], 0.4 * last, 9.0)
        agree(at, start + last, 1e-6)
        start += last
    return rows
