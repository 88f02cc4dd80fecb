import numpy as np
from answers import agree

VARIED = [{"touching.balls.restitution": 0.4}, {"bodies.ball.mass": 1.7}]


def answer(scene):
    cue, ball, e = scene["bodies"]["cue"], scene["bodies"]["ball"], scene["touching"]["balls"]["restitution"]
    m, n, d = cue["mass"], ball["mass"], cue["shape"]["sphere"]["diameter"]
    x, v, y = np.array(cue["position"]), np.array(cue["velocity"]), np.array(ball["position"])
    high = x[1] - y[1]
    meets = (y[0] - np.sqrt(d * d - high**2) - x[0]) / v[0]
    at = x + v * meets
    normal = (at - y) / d
    push = -(1 + e) * (v @ normal) * m * n / (m + n)
    after, other = v + push / m * normal, -push / n * normal
    agree(m * after + n * other, m * v, 1e-12)
    if e == 1 and m == n:
        agree(after @ other, 0, 1e-12)
    rows = []
    for t in (meets + 0.05, scene["duration"]):
        rows += [(t, f"cue.{a}", (at + after * (t - meets))[j], 1e-6) for j, a in enumerate("xy")]
        rows += [(t, f"ball.{a}", (y + other * (t - meets))[j], 1e-6) for j, a in enumerate("xy")]
    return rows
