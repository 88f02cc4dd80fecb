import numpy as np
from answers import agree, frames, integrate, places

VARIED = [{"connectors.spring.start.spin": [0.0, 0.0, -12.0]}, {"connectors.spring.to.point_mass": 5.0}]


def answer(scene):
    spring, times = scene["connectors"]["spring"], frames(scene, 5)
    l = spring["length"]
    k, rate = spring["axial_stiffness"] / l, spring["start"]["spin"][2]
    masses = np.array([spring["from"]["point_mass"], spring["to"]["point_mass"]]) + spring["mass"] / 2
    reduced, drift = masses.prod() / masses.sum(), masses[1] / masses.sum() * l * rate
    area = l**2 * rate
    s = integrate(lambda t, s: np.array([s[1], area**2 / s[0] ** 3 - k / reduced * (s[0] - l), area / s[0] ** 2]),
                  [l, 0, 0], times)

    def cartesian(t, y):
        x, v = y[:6].reshape(2, 3), y[6:]
        e = x[1] - x[0]
        pull = k * (np.linalg.norm(e) - l) / np.linalg.norm(e) * e
        return np.concatenate([v, pull / masses[0], -pull / masses[1]])

    other = integrate(cartesian, [0, 0, 0, l, 0, 0, 0, 0, 0, 0, l * rate, 0], times)
    rows = []
    for t, (r, _, a), y in zip(times, s, other):
        middle = np.array([masses[1] / masses.sum() * l, drift * t, 0])
        arm = r * np.array([np.cos(a), np.sin(a), 0])
        ends = [middle - masses[1] / masses.sum() * arm, middle + masses[0] / masses.sum() * arm]
        agree(y[:6].reshape(2, 3), ends, 1e-8)
        rows += places([t], "spring.0", [ends[0]], 1e-5, "xy") + places([t], "spring.1", [ends[1]], 1e-5, "xy")
    return rows
