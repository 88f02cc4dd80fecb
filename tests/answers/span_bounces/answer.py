import numpy as np
from answers import agree, gravity, integrate

VARIED = [{"connectors.cord.restitution": 0.9}, {"connectors.cord.to.point_mass": 9.0}]


def answer(scene):
    cord, fall = scene["connectors"]["cord"], -gravity(scene)[1]
    l, e = cord["length"], cord["restitution"]
    taut, speed = np.sqrt(2 * l / fall), np.sqrt(2 * l * fall)
    rows = [(taut / 2, "cord.2.y", 1 - fall * taut**2 / 8, 1e-7)]
    for s in (0.05, 0.15, 0.25):
        if taut + s < scene["duration"]:
            y = 1 - l + e * speed * s - fall * s * s / 2
            agree(integrate(lambda t, z: np.array([z[1], -fall]), [1 - l, e * speed], [s])[0][0], y, 1e-9)
            rows.append((taut + s, "cord.2.y", y, 1e-6))
    return rows
