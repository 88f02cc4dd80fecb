import numpy as np
from answers import agree, gravity, integrate

VARIED = [{"touching.rods.restitution": 0.4}, {"connectors.falls.mass": 3.0}]


def answer(scene):
    fall, e, gap = -gravity(scene)[1], scene["touching"]["rods"]["restitution"], 0.32 - 0.02
    hits, speed = np.sqrt(2 * gap / fall), np.sqrt(2 * gap * fall)
    rows = [(hits / 2, "falls.0.y", 0.32 - fall * hits**2 / 8, 1e-7)]
    for share in (0.3, 0.8):
        s = share * 2 * e * speed / fall
        y = 0.02 + e * speed * s - fall * s * s / 2
        agree(integrate(lambda t, z: np.array([z[1], -fall]), [0.02, e * speed], [s])[0][0], y, 1e-9)
        if hits + s < scene["duration"]:
            rows += [(hits + s, f"falls.{k}.y", y, 1e-5) for k in (0, 1)]
    return rows
