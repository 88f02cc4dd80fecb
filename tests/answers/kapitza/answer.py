import numpy as np
from answers import agree, frames, gravity, integrate, Particles, places, unit

VARIED = [{"paths.hand.circle.frequency": 25.0}, {"connectors.rod.start.direction": [-0.05, 1.0, 0.0]}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene, 5)
    circle, l = scene["paths"]["hand"]["circle"], rod["length"]
    radius, top, ramp = circle["start"][2], 2 * np.pi * circle["frequency"], circle["ramp"]

    def pivot(t):  # right-handed about x, from z towards -y
        s = min(t / ramp, 1.0)
        a = top * (ramp * (s**3 - s**4 / 2) + max(t - ramp, 0.0))
        da, dda = top * s * s * (3 - 2 * s), top / ramp * 6 * s * (1 - s)
        outward, onward = np.array([0, -np.sin(a), np.cos(a)]), np.array([0, -np.cos(a), -np.sin(a)])
        return radius * outward, radius * da * onward, radius * (dda * onward - da**2 * outward)

    d = unit(rod["start"]["direction"])
    stops = sorted(set(times) | {ramp})
    system = Particles([[0, 0, 0], l * d], [np.inf, 1.0], [(0, 1)],
                       lambda t, x, v: np.array([[0], [1]]) * (g - pivot(t)[2]))
    x = system.run(stops)[0][:, 1]

    def f(t, y):  # in the frame of space, the rod's direction from the places
        at, speed = y[:3], y[3:]
        arm, rate = at - pivot(t)[0], speed - pivot(t)[1]
        pull = ((g - pivot(t)[2]) @ arm + rate @ rate) / (arm @ arm)
        return np.concatenate([speed, g - pull * arm])

    y = integrate(f, np.concatenate([pivot(0)[0] + l * d, [0, 0, 0]]), stops[:3])
    states = np.array([pivot(t)[0] + at for t, at in zip(stops, x)])
    agree(states[:3], y[:, :3], 1e-7)
    return places(times, "rod.1", states[[stops.index(t) for t in times]], 1e-5)
