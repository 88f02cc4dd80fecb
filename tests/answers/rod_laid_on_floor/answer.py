import numpy as np
from answers import Rest, agree, bends_energy, forces_of_energy, gravity, in_space, tensions_at_rest

VARIED = [{"connectors.rod.bending_stiffness": 0.015}, {"connectors.rod.particles": 26}]


def long_rod(scene):
    """The clamp's moment of a long heavy rod on a floor, sqrt(2 EI w H), at any slope."""
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    high = rod["from"]["fixed"][1] - rod["radius"]
    moment = np.sqrt(2 * rod["bending_stiffness"] * rod["mass"] / rod["length"] * fall * high)
    return moment


def answer(scene):
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    n, ei, length, radius = rod["particles"] - 1, rod["bending_stiffness"], rod["length"], rod["radius"]
    l, weights = length / n, np.full(n + 1, rod["mass"] / (n + 1) * fall)
    high = rod["from"]["fixed"][1]
    chain = Rest(l, weights, ei, start=(0.0, high), clamp=0.0, floor=radius)
    s = l * (np.arange(n) + 0.5)
    angles = np.where(s < 0.5 * length, -2 * high / length * np.sin(2 * np.pi * s / length) ** 2, 0.0)
    places, pressed, _ = chain.find(angles, range(n // 2, n + 1))
    x = in_space(places)
    forces = np.outer(weights, [0.0, -1.0, 0.0]) + forces_of_energy(lambda x: bends_energy(x, l, ei, np.array([1.0, 0, 0])), x, 1e-6)
    for k, force in pressed.items():
        forces[k, 1] += force
    tensions, holds, left = tensions_at_rest(x, forces, (0,))
    agree(left, 0, 1e-6 * np.sum(weights))
    angle = np.arctan2(*(x[1] - x[0])[1::-1])
    moment = 4 * ei / l * np.tan(angle / 2) / np.cos(angle / 2) ** 2
    agree(-moment, long_rod(scene), 0.2 * abs(moment))
    t, whole = scene["duration"], np.sum(weights)
    rows = [(t, f"rod.{k}.{axis}", x[k][j], 1e-5) for k in range(n + 1) for j, axis in enumerate("xy")]
    return rows + [(t, "rod.0.moment.z", -moment, 1e-4 * abs(moment)), (t, "floor.contact.y", -sum(pressed.values()), 1e-4 * whole)]
