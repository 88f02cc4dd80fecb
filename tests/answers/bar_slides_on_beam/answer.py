import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"touching.both.friction": 0.0}, {"touching.both.friction": 0.7}, {"connectors.bar.mass": 2.0}]


def answer(scene):
    bar, mu, fall, times = scene["connectors"]["bar"], scene["touching"]["both"]["friction"], -gravity(scene)[1], frames(scene)
    a, slope = np.array(scene["connectors"]["beam"]["from"]["fixed"]), np.pi / 6
    agree(np.arctan2(a[1], -a[0]), slope, 1e-12)
    pull = max(0.0, fall * (np.sin(slope) - mu * np.cos(slope)))
    x0, m, rows = np.array(bar["start"]["points"][0]), bar["mass"], []
    for t, way in zip(times, integrate(lambda t, s: np.array([s[1], pull]), [0.0, 0.0], times)[:, 0]):
        agree(way, pull * t * t / 2, 1e-12)
        # The work of weight and friction is the bar's energy.
        agree(m * (fall * np.sin(slope) - mu * fall * np.cos(slope)) * way if pull else 0.0, m * (pull * t) ** 2 / 2, 1e-12)
        for k in (0, 1):
            rows += [(t, f"bar.{k}.x", x0[0] + way * np.cos(slope), 5e-6), (t, f"bar.{k}.y", x0[1] - way * np.sin(slope), 5e-6)]
        rows.append((t, "momentum.y", -m * pull * t * np.sin(slope), 1e-4 * m * fall * t))
    return rows
