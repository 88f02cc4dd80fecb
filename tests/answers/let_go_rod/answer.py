import numpy as np
from answers import agree, gravity, integrate

VARIED = [{"bodies.stick.mass": 30.0}]


def answer(scene):
    stick, cut, end = scene["bodies"]["stick"], scene["cuts"][0]["t"], scene["duration"]
    l, fall = stick["shape"]["cylinder"]["length"], -gravity(scene)[1]
    rate = 1.5 * fall / l  # without the cord's rest
    y = integrate(lambda t, s: np.array([s[1], -rate * np.cos(s[0])]), [0, 0], [end - cut])[0]
    agree(y[1] ** 2, -2 * rate * np.sin(y[0]), 1e-10)
    # The cord's rest on the end weighs two thirds of a thousandth of the stick or less.
    share = 3 * scene["connectors"]["right"]["mass"] / stick["mass"]
    return [(end, "stick.x", l / 2 * np.cos(y[0]), 1e-5 + share * abs(y[0]) * l),
            (end, "stick.y", l / 2 * np.sin(y[0]), 1e-5 + share * abs(y[0]) * l)]
