import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"obstacles.slope.friction": 0.0}, {"obstacles.slope.friction": 0.55}, {"obstacles.slope.friction": 0.45}]


def answer(scene):
    stick, fall, mu = scene["bodies"]["stick"], -gravity(scene)[1], scene["obstacles"]["slope"]["friction"]
    slope, times = np.arctan(0.5), frames(scene)
    a = max(0.0, fall * (np.sin(slope) - mu * np.cos(slope)))
    energy = integrate(lambda t, y: np.array([np.sqrt(2 * a * max(y[0], 0.0))]), [a * 1e-4**2 / 2], times, 1e-4)[:, 0]
    x0, rows = np.array(stick["position"]), []
    for t, way in zip(times, energy):
        agree(way, a * t * t / 2, 1e-7)  # the speed by the work of weight and friction
        x = x0 - a * t * t / 2 * np.array([np.cos(slope), np.sin(slope), 0])
        rows += [(t, "stick.x", x[0], 1e-9), (t, "stick.y", x[1], 1e-9), (t, "stick.wz", 0.0, 1e-7)]
    weight = stick["mass"] * fall
    rows.append((times[-1], "slope.contact.y", -weight * (np.cos(slope) ** 2 * (1 + min(mu, 0.5) / 2)), 1e-4 * weight))
    return rows
