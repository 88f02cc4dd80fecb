import numpy as np
from answers import Rest, agree, bends_energy, forces_of_energy, gravity, in_space, tensions_at_rest

VARIED = [{"connectors.rod.bending_stiffness": 0.3}, {"paths.hand.keys": [{"t": 0.0, "position": [0.0, 0.5455813207414516, 0.0]}, {"t": 1.0, "position": [0.0, 0.5, 0.0]}]}]


def answer(scene):
    rod, fall, t = scene["connectors"]["rod"], -gravity(scene)[1], scene["duration"]
    n, ei, radius = rod["particles"] - 1, rod["bending_stiffness"], rod["radius"]
    way = np.array(rod["from"]["clamp"])
    l, weights, slant = rod["length"] / n, np.full(n + 1, rod["mass"] / (n + 1) * fall), np.arctan2(way[1], way[0])
    low = scene["paths"]["hand"]["keys"][-1]["position"][1]
    places, floor, _ = Rest(l, weights, ei, start=(0.0, low), clamp=slant, floor=radius, supports=[n]).find(np.full(n, slant + 0.1), [n])
    x = in_space(places)
    forces = np.outer(weights, [0.0, -1.0, 0.0]) + forces_of_energy(lambda x: bends_energy(x, l, ei, way), x, 1e-7)
    forces[n, 1] += floor[n]
    agree(tensions_at_rest(x, forces, (0,))[2], 0, 1e-5 * floor[n])
    return [(t, f"rod.{k}.{axis}", x[k][j], 2e-5) for k in range(n + 1) for j, axis in enumerate("xy")] + [
        (t, "floor.contact.y", -floor[n], 1e-3 * floor[n]), (t, "floor.contact.x", 0.0, 1e-3 * floor[n])]
