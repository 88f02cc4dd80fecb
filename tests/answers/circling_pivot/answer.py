import numpy as np
from answers import agree, frames, gravity, integrate, Particles, places

VARIED = [{"paths.hand.circle.frequency": 3.0}, {"paths.hand.circle.ramp": 0.2, "connectors.rod.length": 1.2}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene, 6)
    circle, l = scene["paths"]["hand"]["circle"], rod["length"]
    centre, radius = np.array(circle["centre"]), circle["start"][0] - circle["centre"][0]
    top, ramp = 2 * np.pi * circle["frequency"], circle["ramp"]

    def angle(t):  # and its first two derivatives
        s = min(t / ramp, 1.0)
        full = top * (ramp * (s**3 - s**4 / 2) + max(t - ramp, 0.0))
        return full, top * s * s * (3 - 2 * s), top / ramp * 6 * s * (1 - s)

    def pivot(t):
        a, da, dda = angle(t)
        outward, onward = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0])
        return centre + radius * outward, radius * (dda * onward - da**2 * outward)

    def f(t, s):
        felt = g - pivot(t)[1]
        return np.array([s[1], (felt[0] * np.cos(s[0]) + felt[1] * np.sin(s[0])) / l])

    # Stop at the ramp's end, where the acceleration has a corner.
    stops = sorted(set(times) | {ramp})
    s = integrate(f, [0, 0], stops)
    s = s[[stops.index(t) for t in times]]
    states = [pivot(t)[0] + l * np.array([np.sin(a), -np.cos(a), 0]) for t, a in zip(times, s[:, 0])]
    system = Particles([[0, 0, 0], [0, -l, 0]], [np.inf, 1.0], [(0, 1)],
                       lambda t, x, v: np.array([[0], [1]]) * (g - pivot(t)[1]))
    x = system.run(stops)[0][:, 1][[stops.index(t) for t in times]]
    agree([pivot(t)[0] + at for t, at in zip(times, x)], states, 1e-7)
    return places(times, "rod.1", states, 5e-6)
