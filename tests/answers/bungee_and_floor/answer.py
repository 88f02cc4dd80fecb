import numpy as np
from answers import agree, event, gravity, integrate

VARIED = [{"connectors.string.axial_stiffness": 9.0}, {"obstacles.floor.restitution": 0.3}]


def answer(scene):
    string, fall, e = scene["connectors"]["string"], -gravity(scene)[1], scene["obstacles"]["floor"]["restitution"]
    m, l, low = string["to"]["point_mass"] + string["mass"] / 2, string["length"], string["radius"]
    k = string["axial_stiffness"] / l
    # Height y: free above 1 - l, the spring below.
    y0 = 0.8
    taut = np.sqrt(2 * (y0 - (1 - l)) / fall)
    spring = lambda t, s: np.array([s[1], -fall + k / m * (1 - l - s[0])])
    hit, s = event(spring, [1 - l, -fall * taut], taut, lambda t, s: s[0] - low, 0.02, 3.0)
    energy = 0.5 * m * s[1] ** 2 + m * fall * low + 0.5 * k * (1 - l - low) ** 2
    agree(energy, m * fall * y0, 1e-9)
    rows = [(taut / 2, "string.1.y", y0 - fall * taut**2 / 8, 1e-6)]
    middle = 0.5 * (taut + hit)
    rows += [(middle, "string.1.y", integrate(spring, [1 - l, -fall * taut], [middle], taut)[0][0], 3e-5)]
    # Back up by the closed form of the spring about its rest height.
    rate, rest = np.sqrt(k / m), 1 - l - m * fall / k
    speed = -e * s[1]
    for t in (hit + 0.03, hit + 0.06):
        up = rest + (low - rest) * np.cos(rate * (t - hit)) + speed / rate * np.sin(rate * (t - hit))
        agree(up, integrate(spring, [low, speed], [t], hit)[0][0], 1e-8)
        if low < up < 1 - l and t < scene["duration"]:
            rows += [(t, "string.1.y", up, 3e-5)]
    return rows
