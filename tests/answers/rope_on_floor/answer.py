import numpy as np
from answers import agree, gravity

VARIED = [{"connectors.rope.mass": 7.0}, {"obstacles.floor.friction": 0.0}]


def answer(scene):
    rope, fall, t = scene["connectors"]["rope"], -gravity(scene)[1], scene["duration"]
    n = rope["particles"]
    weight = rope["mass"] * fall
    agree(np.sum(np.full(n, rope["mass"] / n) * fall), weight, 1e-9)
    rows = [(t, "floor.contact.y", -weight, 1e-5 * weight), (t, "rope.contact.y", weight, 1e-5 * weight),
            (t, "floor.contact.x", 0.0, 1e-5 * weight), (t, "kinetic_energy", 0.0, 1e-12 * weight)]
    return rows + [(t, f"rope.{k}.y", rope["radius"], 1e-8) for k in range(n)]
