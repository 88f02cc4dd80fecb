import numpy as np
from answers import agree, between_keys, frames, gravity, integrate

VARIED = [{"paths.axle.axle.keys": [{"t": 0.0, "angle": 0.0}, {"t": 1.2, "angle": -1.5}]}, {"connectors.rod.mass": 4.0}]


def answer(scene):
    rod, times, bound = scene["connectors"]["rod"], frames(scene, 5), scene["obstacles"]["table"]["friction"] * -gravity(scene)[1]
    keys, n = scene["paths"]["axle"]["axle"]["keys"], rod["particles"]
    a, b = np.array(rod["start"]["points"])
    for t in np.linspace(0, 1.2, 50):
        _, rate, acceleration = between_keys(keys, "angle", t)
        assert np.hypot(rate**2, acceleration) * max(abs(a[0]), abs(b[0])) < 0.9 * bound
    turned = integrate(lambda t, s: between_keys(keys, "angle", t)[1] * np.array([-s[1], s[0]]), [1.0, 0.0], times)
    rows = []
    for t, way in zip(times, turned):
        angle = between_keys(keys, "angle", t)[0]
        agree(way, [np.cos(angle), np.sin(angle)], 1e-9)
        for k in range(n):
            r = a[0] + (b[0] - a[0]) * k / (n - 1)
            rows += [(t, f"rod.{k}.x", r * np.cos(angle), 1e-5), (t, f"rod.{k}.z", -r * np.sin(angle), 1e-5), (t, f"rod.{k}.y", 0.01, 1e-7)]
    return rows
