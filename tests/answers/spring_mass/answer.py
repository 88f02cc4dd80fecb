import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.spring.axial_stiffness": 2000.0}, {"connectors.spring.to.point_mass": 0.05}]


def answer(scene):
    spring, fall, times = scene["connectors"]["spring"], -gravity(scene)[1], frames(scene, 5)
    mass, l = spring["to"]["point_mass"] + spring["mass"] / 2, spring["length"]
    k = spring["axial_stiffness"] / l
    rate = np.sqrt(k / mass)
    y = integrate(lambda t, s: np.array([s[1], fall - k / mass * s[0]]), [0, 0], times)
    rows = []
    for t, state in zip(times, y):
        down = mass * fall / k * (1 - np.cos(rate * t))
        agree(down, state[0], 1e-9)
        rows += [(t, "spring.1.y", 1 - l - down, 1e-5),
                 (t, "spring.0-1.tension", k * down, 1e-3 * mass * fall),
                 (t, "elastic_energy", k * down**2 / 2, 1e-3 * (mass * fall) ** 2 / k)]
    return rows
