import numpy as np
from answers import Rest, agree, bends_energy, elliptic_k, forces_of_energy, gravity, in_space, root, tensions_at_rest

VARIED = [{"connectors.column.to.point_mass": 0.045}, {"connectors.column.to.point_mass": 0.015}]
LINKS = [6, 12, 24]


def leans(scene):
    """sin^2 of half of the angle at the end of the continuous column: K = L sqrt(P/EI). 0: it stands."""
    column = scene["connectors"]["column"]
    load = (column["to"]["point_mass"] + column["mass"] / 2) * -gravity(scene)[1]
    quarter = column["length"] * np.sqrt(load / column["bending_stiffness"])
    return root(lambda m: elliptic_k(m) - quarter, 0.0, 1 - 1e-9) if quarter > np.pi / 2 else 0.0


def continuum(scene):
    """The place of the top, across: 2 sqrt(m EI/P)."""
    column = scene["connectors"]["column"]
    load = (column["to"]["point_mass"] + column["mass"] / 2) * -gravity(scene)[1]
    across = 2 * np.sqrt(leans(scene) * column["bending_stiffness"] / load)
    return [(scene["duration"], f"column.{column['particles'] - 1}.x", across, 1e-4)]


def answer(scene):
    column, fall, t = scene["connectors"]["column"], -gravity(scene)[1], scene["duration"]
    n, ei, length = column["particles"] - 1, column["bending_stiffness"], column["length"]
    l, weights = length / n, np.full(n + 1, column["mass"] / (n + 1) * fall)
    weights[-1] += column["to"]["point_mass"] * fall
    m = leans(scene)
    end = 2 * np.arcsin(np.sqrt(m)) if m else 0.0
    guess = np.pi / 2 - end * np.sin(np.pi / 2 * (np.arange(n) + 0.5) / n)
    places = Rest(l, weights, ei, start=(0.0, 0.0), clamp=np.pi / 2).find(guess)[0]
    agree(places[-1][0], continuum(scene)[0][2], 2 * length / n**2)
    x = in_space(places)
    forces = forces_of_energy(lambda x: bends_energy(x, l, ei, np.array([0, 1.0, 0])), x)
    agree(tensions_at_rest(x, forces + np.outer(weights, [0.0, -1.0, 0.0]), (0,))[2], 0, 1e-6 * np.sum(weights))
    return [(t, f"column.{k}.{axis}", x[k][j], 1e-5) for k in range(n + 1) for j, axis in enumerate("xy")]
