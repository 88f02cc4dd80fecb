import numpy as np
from answers import agree, gravity, quadrature

VARIED = [{"bodies.stick.velocity": [-0.7, 0.0, 0.0]}, {"obstacles.floor.friction": 0.8}]


def answer(scene):
    stick, slowing = scene["bodies"]["stick"], -gravity(scene)[1] * scene["obstacles"]["floor"]["friction"]
    v, end = stick["velocity"][0], scene["duration"]
    stops = abs(v) / slowing
    agree(quadrature(lambda t: abs(v) - slowing * t, 0, stops), v * v / (2 * slowing), 1e-12)
    half = stops / 2
    rows = [(half, "stick.x", v * half - np.sign(v) * slowing * half**2 / 2, 1e-6)]
    for t in (max(stops + 0.05, end - 0.1), end):
        rows += [(t, "stick.x", np.sign(v) * v * v / (2 * slowing), 1e-5), (t, "stick.vx", 0.0, 1e-6)]
    return rows
