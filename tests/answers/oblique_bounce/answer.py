import numpy as np
from answers import agree, gravity

VARIED = [{"obstacles.floor.friction": 0.9}, {"bodies.ball.spin": [0.0, 0.0, -80.0]}, {"obstacles.floor.restitution": 0.0}]


def answer(scene):
    ball, floor, g = scene["bodies"]["ball"], scene["obstacles"]["floor"], gravity(scene)
    m, r = ball["mass"], ball["shape"]["sphere"]["diameter"] / 2
    inertia, v, w = 0.4 * m * r * r, np.array(ball["velocity"]), np.array(ball["spin"])
    height = ball["position"][1] - r
    hits = (v[1] + np.sqrt(v[1] ** 2 - 2 * g[1] * height)) / -g[1]
    v = v + g * hits
    at = np.array(ball["position"]) + np.array(ball["velocity"]) * hits + g * hits**2 / 2
    arm, push = np.array([0, -r, 0]), -(1 + floor["restitution"]) * m * v[1]
    slides = v + np.cross(w, arm)
    slides[1] = 0
    stick = np.linalg.norm(slides) / (1 / m + r * r / inertia)
    agree(stick, 2 / 7 * m * np.linalg.norm(slides), 1e-12)
    impulse = np.array([0, push, 0]) - min(stick, floor["friction"] * push) * slides / np.linalg.norm(slides)
    before = 0.5 * m * v @ v + 0.5 * inertia * w @ w
    v, w = v + impulse / m, w + np.cross(arm, impulse) / inertia
    assert 0.5 * m * v @ v + 0.5 * inertia * w @ w <= before
    t = hits + 0.05
    if floor["restitution"] == 0:  # it stays on the floor, and slides or rolls on
        return [(hits + 1e-6, f"ball.w{axis}", w[j], 1e-3) for j, axis in enumerate("xyz")]
    x = at + v * 0.05 + g * 0.05**2 / 2
    rows = [(t, f"ball.{axis}", x[j], 1e-6) for j, axis in enumerate("xyz")]
    rows += [(t, f"ball.v{axis}", (v + g * 0.05)[j], 1e-5) for j, axis in enumerate("xyz")]
    return rows + [(t, f"ball.w{axis}", w[j], 1e-3) for j, axis in enumerate("xyz")]
