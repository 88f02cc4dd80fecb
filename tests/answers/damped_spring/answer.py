import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.spring.axial_damping": 0.05}, {"connectors.spring.axial_damping": 4.0}]


def answer(scene):
    spring, fall, times = scene["connectors"]["spring"], -gravity(scene)[1], frames(scene, 5)
    mass, l = spring["to"]["point_mass"] + spring["mass"] / 2, spring["length"]
    k, c = spring["axial_stiffness"] / l, spring["axial_damping"] / l
    sink = mass * fall / k
    half, square = c / (2 * mass), k / mass
    rate = np.sqrt(complex(square - half**2))
    y = integrate(lambda t, s: np.array([s[1], fall - (k * s[0] + c * s[1]) / mass]), [0, 0], times)
    rows = []
    for t, state in zip(times, y):
        swing = np.exp(-half * t) * (np.cos(rate * t) + half / rate * np.sin(rate * t))
        down = sink * (1 - swing.real)
        agree(down, state[0], 1e-9)
        rows.append((t, "spring.1.y", 1 - l - down, 1e-5))
    return rows
