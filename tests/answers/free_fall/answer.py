import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"gravity": [0.3, -1.62, 0.1], "duration": 2.0}, {"bodies.ball.velocity": [-4.0, 0.0, 9.0]}]


def answer(scene):
    ball, g, times = scene["bodies"]["ball"], gravity(scene), frames(scene)
    x, v = np.array(ball["position"]), np.array(ball["velocity"])
    states = np.array([x + v * t + g * t * t / 2 for t in times])
    y = integrate(lambda t, y: np.concatenate([y[3:], g]), np.concatenate([x, v]), times)
    agree(states, y[:, :3], 1e-10)
    rows = places(times, "ball", states, 1e-9)
    return rows + [(t, "ball.vy", v[1] + g[1] * t, 1e-9) for t in times]
