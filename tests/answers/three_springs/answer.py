import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"connectors.first.to.point_mass": 1.5}, {"connectors.second.axial_stiffness": 150.0}]


def answer(scene):
    cords, times, g = list(scene["connectors"].values()), frames(scene), gravity(scene)
    m = cords[0]["to"]["point_mass"] + sum(cord["mass"] for cord in cords) / 2
    x0 = np.array(cords[0]["start"]["points"][1])
    holds = np.array([cord["from"]["fixed"] for cord in cords])
    ea, own = (np.array([cord[key] for cord in cords]) for key in ("axial_stiffness", "length"))

    def f(t, y):
        to = holds - y[:3]
        lengths = np.linalg.norm(to, axis=1)
        return np.append(y[3:], g + (ea * (lengths / own - 1) / lengths) @ to / m)

    def energy(y):
        lengths = np.linalg.norm(holds - y[:3], axis=1)
        return m * (y[3:] @ y[3:] / 2 - g @ y[:3]) + np.sum(ea * (lengths - own) ** 2 / (2 * own))

    start = np.append(x0, [0.0, 0.0, 0.0])
    states = integrate(f, start, times)
    for state in states:
        agree(energy(state), energy(start), 1e-9)
    return places(times, "first.1", states[:, :3], 1e-5)
