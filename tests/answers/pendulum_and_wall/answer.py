import numpy as np
from answers import agree, elliptic_k, gravity, integrate, jacobi

VARIED = [{"obstacles.wall.restitution": 0.95}, {"connectors.rod.start.direction": [0.3, -1.0, 0.0]}]


def answer(scene):
    rod, e = scene["connectors"]["rod"], scene["obstacles"]["wall"]["restitution"]
    l, fall, end = rod["length"], -gravity(scene)[1], scene["duration"]
    way, rate = np.array(rod["start"]["direction"]), np.sqrt(-gravity(scene)[1] / rod["length"])
    start, rows = np.arctan2(way[0], -way[1]), []
    k = np.sin(start / 2)
    t = elliptic_k(k * k) / rate  # of the first impact
    spin = 2 * k * rate
    f = lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])])
    agree(integrate(f, [start, 0], [t])[0], [0, -spin], 1e-9)
    while True:
        k *= e
        rise = elliptic_k(k * k) / rate
        for share in (0.4, 1.5):
            s = share * rise
            if t + s > end:
                return rows
            theta = 2 * np.arcsin(k * jacobi(rate * s, k * k)[0])
            agree(integrate(f, [0, 2 * k * rate], [s])[0][0], theta, 1e-9)
            rows += [(t + s, "rod.1.x", l * np.sin(theta), 2e-5), (t + s, "rod.1.y", 1 - l * np.cos(theta), 2e-5)]
        t += 2 * rise
