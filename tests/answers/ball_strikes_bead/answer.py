import numpy as np
from answers import Particles, agree

VARIED = [{"touching.all.restitution": 0.3}, {"bodies.ball.mass": 0.02, "touching.all.restitution": 0.9}]


def answer(scene):
    ball, rod, e = scene["bodies"]["ball"], scene["connectors"]["rod"], scene["touching"]["all"]["restitution"]
    big, m, l, v = ball["mass"], rod["mass"] / 2, rod["length"], ball["velocity"][0]
    hits = (-ball["position"][0] - ball["shape"]["sphere"]["diameter"] / 2 - rod["radius"]) / v
    impulse = (1 + e) * v / (1 / big + 1 / m)
    after, given = v - impulse / big, impulse / m
    agree(given - after, e * v, 1e-12)
    times = [hits + share * (scene["duration"] - hits) for share in (0.3, 0.6, 1.0)]
    free = Particles([[0, 0, 0], [0, l, 0]], [m, m], [(0, 1)], lambda t, x, v: 0 * x, [[given, 0, 0], [0, 0, 0]])
    rows = []
    for t, x in zip(times, free.run([t - hits for t in times])[0]):
        s = t - hits
        turned = given / l * s
        agree(x[0], [given * s / 2 + l / 2 * np.sin(turned), l / 2 * (1 - np.cos(turned)), 0], 1e-9)
        rows += [(t, f"rod.{k}.{axis}", x[k][j], 1e-5) for k in (0, 1) for j, axis in enumerate("xy")]
        rows += [(t, "ball.x", ball["position"][0] + v * hits + after * s, 1e-5), (t, "momentum.x", big * v, 1e-6 * big * v)]
    return rows
