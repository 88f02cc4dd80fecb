import numpy as np
from answers import Rest, agree, bends_energy, forces_of_energy, gravity, in_space, tensions_at_rest

VARIED = [{"connectors.rod.bending_stiffness": 2.0}, {"connectors.rod.start.points": [[-1.2001, 0.01, 0.0], [0.2999, 0.01, 0.0]]}]
LINKS = [30, 60, 120]


def at_edge(scene):
    """The bead at the edge, and the length over it."""
    rod = scene["connectors"]["rod"]
    l = rod["length"] / (rod["particles"] - 1)
    bead = int(np.floor(-rod["start"]["points"][0][0] / l))
    return bead, rod["length"] - bead * l


def prepared(scene):
    """A bead lies 0.1 mm before the edge."""
    rod = scene["connectors"]["rod"]
    bead, _ = at_edge(scene)
    x = -1e-4 - bead * rod["length"] / (rod["particles"] - 1)
    rod["start"] = {"points": [[x, 0.01, 0.0], [x + rod["length"], 0.01, 0.0]]}
    return scene


def continuum(scene):
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    sinks = 0.24285 * rod["mass"] / rod["length"] * fall * at_edge(scene)[1] ** 4 / rod["bending_stiffness"]
    return [(scene["duration"], f"rod.{rod['particles'] - 1}.y", rod["radius"] - sinks, 0.02 * sinks)]


def answer(scene):
    rod, fall, t = scene["connectors"]["rod"], -gravity(scene)[1], scene["duration"]
    n, ei, length, radius = rod["particles"] - 1, rod["bending_stiffness"], rod["length"], rod["radius"]
    l, weights, (bead, over) = length / n, np.full(n + 1, rod["mass"] / (n + 1) * fall), at_edge(scene)
    lifts = bead - int(np.sqrt(2) * over / l)
    q = np.append(np.zeros(n), radius)
    places, pressed, _ = Rest(l, weights, ei, floor=radius, supports=range(bead + 1)).find(q, [*range(lifts + 1), bead])
    x = in_space(places)
    forces = np.outer(weights, [0.0, -1.0, 0.0]) + forces_of_energy(lambda x: bends_energy(x, l, ei), x)
    for k, force in pressed.items():
        forces[k, 1] += force
    agree(tensions_at_rest(x, forces, ())[2], 0, 1e-6 * np.sum(weights))
    agree(sum(pressed.values()), np.sum(weights), 1e-9)
    sinks = radius - continuum(scene)[0][2]
    agree(radius - x[n][1], sinks, 3 * l / over * sinks)
    assert abs(max(k for k in pressed if k < bead) * l - (bead * l - np.sqrt(2) * over)) < 2 * l
    rows = [(t, f"rod.{k}.y", x[k][1], 2e-6) for k in range(n + 1)]
    return rows + [(t, "table.contact.y", -np.sum(weights), 1e-4 * np.sum(weights)), (t, "table.contact.x", 0.0, 1e-4 * np.sum(weights))]
