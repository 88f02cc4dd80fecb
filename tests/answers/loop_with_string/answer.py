import numpy as np
from answers import agree, event, gravity, integrate

VARIED = [{"connectors.string.start.spin": [0.0, 0.0, -7.5]}, {"connectors.string.to.point_mass": 5.0}]


def answer(scene):
    string, fall, end = scene["connectors"]["string"], -gravity(scene)[1], scene["duration"]
    l, pivot, spin = string["length"], np.array(string["from"]["fixed"]), string["start"]["spin"][2]
    f = lambda t, s: np.array([s[1], -fall / l * np.sin(s[0])])
    pull = lambda t, s: l * s[1] ** 2 + fall * np.cos(s[0])
    slack, s = event(f, [0, spin], 0.0, pull, 0.02, 2.0)
    # Energy and pull/m = 0 together: cos theta = -(w^2 l - 2 g)/(3 g).
    agree(np.cos(s[0]), -(spin**2 * l - 2 * fall) / (3 * fall), 1e-9)
    rows = []
    for t, at in zip((slack / 2, slack - 0.01), integrate(f, [0, spin], [slack / 2, slack - 0.01])):
        rows += [(t, "string.1.x", l * np.sin(at[0]), 2e-5), (t, "string.1.y", pivot[1] - l * np.cos(at[0]), 2e-5)]
    x, v = l * np.array([np.sin(s[0]), -np.cos(s[0])]), l * s[1] * np.array([np.cos(s[0]), np.sin(s[0])])
    for k in range(1, 30):
        t = slack + 0.02 * k
        y = x + v * (t - slack) - np.array([0, fall * (t - slack) ** 2 / 2])
        if t > end or np.hypot(*y) > l - 1e-3:
            break
        if k % 3 == 0:
            rows += [(t, "string.1.x", y[0], 2e-5), (t, "string.1.y", pivot[1] + y[1], 2e-5)]
    return rows
