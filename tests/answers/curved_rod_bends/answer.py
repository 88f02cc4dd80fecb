import numpy as np
from answers import Rest, agree, bends_energy, forces_of_energy, gravity, in_space, integrate, root, tensions_at_rest

VARIED = [{"connectors.rod.rest_curvature": [0.0, 0.0, -1.5]}, {"connectors.rod.mass": 0.03}]
LINKS = [6, 12, 24]


def continuum(scene):
    """The end of the continuous rod, by shooting: EI (theta' - k) is the moment, (EI (theta' - k))' = w (L - s) cos."""
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    ei, length, curved = rod["bending_stiffness"], rod["length"], rod["rest_curvature"][2]
    w = rod["mass"] / length * fall

    def shoot(moment):
        def f(s, z):
            return np.array([z[1] / ei + curved, w * (length - s) * np.cos(z[0]), np.cos(z[0]), np.sin(z[0])])
        return integrate(f, [0.0, moment, 0.0, 0.0], [length], 0.0, 1e-10)[0]

    tip = shoot(root(lambda m: shoot(m)[1], -w * length**2, w * length**2))[2:]
    return [(scene["duration"], f"rod.{rod['particles'] - 1}.{axis}", place, 1e-5) for axis, place in zip("xy", tip)]


def answer(scene):
    rod, fall, t = scene["connectors"]["rod"], -gravity(scene)[1], scene["duration"]
    n, ei, length, curved = rod["particles"] - 1, rod["bending_stiffness"], rod["length"], rod["rest_curvature"][2]
    l, weights = length / n, np.full(n + 1, rod["mass"] / (n + 1) * fall)
    q = np.zeros(n)
    for share in np.linspace(0, 1, 6):  # the weight grows
        chain = Rest(l, weights * max(share, 0.01), ei, curved, start=(0.0, 0.0), clamp=0.0)
        places = chain.find(q)[0]
        q = np.arctan2(np.diff(places[:, 1]), np.diff(places[:, 0]))
        q = np.unwrap(q)
    x = in_space(places)
    forces = forces_of_energy(lambda x: bends_energy(x, l, ei, np.array([1.0, 0, 0]), rest=np.array([0, 0, curved])), x)
    agree(tensions_at_rest(x, forces + np.outer(weights, [0.0, -1.0, 0.0]), (0,))[2], 0, 1e-6 * np.sum(weights))
    agree([row[2] for row in continuum(scene)], places[-1], 1.5 * length / n)
    return [(t, f"rod.{k}.{axis}", x[k][j], 1e-5) for k in range(n + 1) for j, axis in enumerate("xy")]
