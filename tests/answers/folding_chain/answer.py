import numpy as np
from answers import agree, gravity, pendulum_angles, quadrature, root

VARIED = [{"connectors.chain.radius": 0.03}, {"connectors.chain.mass": 5.0}]


def answer(scene):
    chain, fall = scene["connectors"]["chain"], -gravity(scene)[1]
    l, rate = chain["length"] / 3, np.sqrt(fall / (chain["length"] / 3))
    beyond = np.arcsin((l - 2 * chain["radius"]) / (2 * l))  # past upright, where the ends touch
    angle = lambda t: pendulum_angles(np.pi / 2, rate, [t])[0]
    meets = root(lambda t: angle(t) + beyond, 0.2, 0.7)
    # The time by the energy, with the angle from level as u^2.
    agree(quadrature(lambda u: 2 * u / np.sqrt(2 * rate**2 * np.sin(u * u)) if u else 0.0, 0, np.sqrt(np.pi / 2 + beyond), 400), meets, 1e-4)
    rows = []
    for t in (0.25, 0.45, meets + 0.15, meets + 0.4, scene["duration"]):
        a = angle(t) if t < meets else -pendulum_angles(beyond, rate, [t - meets])[0]
        rows += [(t, "chain.0.x", -l / 2 - l * np.sin(a), 5e-5), (t, "chain.0.y", -l * np.cos(a), 5e-5),
                 (t, "chain.3.x", l / 2 + l * np.sin(a), 5e-5), (t, "chain.3.y", -l * np.cos(a), 5e-5)]
    return rows
