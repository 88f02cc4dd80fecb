import numpy as np
from answers import Rest, agree, bends_energy, forces_of_energy, gravity, in_space, tensions_at_rest

VARIED = [{"obstacles.floor.friction": 0.0}, {"connectors.rod.bending_stiffness": 0.2}]


def answer(scene):
    rod, fall, t = scene["connectors"]["rod"], -gravity(scene)[1], scene["duration"]
    n, ei, radius, mu = rod["particles"] - 1, rod["bending_stiffness"], rod["radius"], scene["obstacles"]["floor"]["friction"]
    way = np.array(rod["from"]["clamp"])
    l, weights, slant = rod["length"] / n, np.full(n + 1, rod["mass"] / (n + 1) * fall), np.arctan2(way[1], way[0])
    top, low = (scene["paths"]["hand"]["keys"][k]["position"][1] for k in (0, -1))
    if mu:
        # The tip stays where it starts; the rod goes on from its sag under its weight.
        end, q = (rod["length"] * np.cos(slant), radius), np.full(n, slant) - 1e-3 * np.sin(np.pi * np.arange(n) / n)
        for height in top + (low - top) * np.linspace(0, 1, 60)[1:] ** 2:
            places, _, force = Rest(l, weights, ei, start=(0.0, height), clamp=slant, end=end).find(q)
            q = np.arctan2(np.diff(places[:, 1]), np.diff(places[:, 0]))
        along, pressed = force
        assert abs(along) < 0.9 * mu * pressed
    else:
        places, floor, _ = Rest(l, weights, ei, start=(0.0, low), clamp=slant, floor=radius, supports=[n]).find(np.full(n, slant + 0.1), [n])
        pressed, along = floor[n], 0.0
    x = in_space(places)
    forces = np.outer(weights, [0.0, -1.0, 0.0]) + forces_of_energy(lambda x: bends_energy(x, l, ei, way), x, 1e-7)
    forces[n] += [along, pressed, 0]
    agree(tensions_at_rest(x, forces, (0,))[2], 0, 1e-5 * pressed)
    return [(t, f"rod.{k}.{axis}", x[k][j], 2e-5) for k in range(n + 1) for j, axis in enumerate("xy")] + [
        (t, "floor.contact.y", -pressed, 1e-3 * pressed), (t, "floor.contact.x", -along, 1e-3 * pressed)]
