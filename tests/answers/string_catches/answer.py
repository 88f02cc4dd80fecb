import numpy as np
from answers import agree, gravity, integrate, root

VARIED = [{"connectors.string.start.points": [[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]]}, {"connectors.string.length": 0.5}]


def answer(scene):
    string, fall, end = scene["connectors"]["string"], -gravity(scene)[1], scene["duration"]
    l, pivot = string["length"], np.array(string["from"]["fixed"])
    at = np.array(string["start"]["points"][1]) - pivot
    catches = root(lambda t: np.hypot(at[0], at[1] - fall * t * t / 2) - l, 0, 1)
    # The second route: the square of the drop from Pythagoras.
    agree(catches, np.sqrt(2 * (at[1] + np.sqrt(l * l - at[0] ** 2)) / fall), 1e-9)
    x = np.array([at[0], at[1] - fall * catches**2 / 2])
    theta = np.arctan2(x[0], -x[1])
    across = -fall * catches * np.sin(theta)
    f = lambda t, s: np.array([s[1], -fall / l * np.sin(s[0])])
    times = [catches + 0.05, 0.5 * (catches + end), end]
    rows = [(catches * 0.9, "string.1.x", pivot[0] + at[0], 1e-6),
            (catches * 0.9, "string.1.y", pivot[1] + at[1] - fall * (0.9 * catches) ** 2 / 2, 1e-6)]
    for t, s in zip(times, integrate(f, [theta, across / l], times, catches)):
        agree(s[1] ** 2 / 2 - fall / l * np.cos(s[0]), (across / l) ** 2 / 2 - fall / l * np.cos(theta), 1e-9)
        rows += [(t, "string.1.x", pivot[0] + l * np.sin(s[0]), 2e-5), (t, "string.1.y", pivot[1] - l * np.cos(s[0]), 2e-5)]
    return rows
