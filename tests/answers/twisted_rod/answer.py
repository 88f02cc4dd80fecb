import numpy as np
from answers import agree, between_keys

VARIED = [{"connectors.rod.twisting_stiffness": 0.003}, {"connectors.rod.particles": 5}]


def answer(scene):
    rod = scene["connectors"]["rod"]
    keys, n = rod["to"]["turn"], rod["particles"] - 1
    rows = []
    for t in (0.3, 0.5, 0.9, 1.0):
        angle = between_keys(keys, "angle", t)[0]
        moment = rod["twisting_stiffness"] * angle / rod["length"]
        springs = np.full(n, rod["twisting_stiffness"] * n / rod["length"])  # links in a row
        agree(angle / np.sum(1 / springs), moment, 1e-12)
        rows += [(t, f"rod.{n}.moment.x", moment, 1e-6 * rod["twisting_stiffness"] * 6),
                 (t, "rod.0.moment.x", -moment, 1e-6 * rod["twisting_stiffness"] * 6),
                 (t, f"rod.{n // 2}.y", 0.0, 1e-6),
                 (t, "elastic_energy", moment * angle / 2 + rod["axial_stiffness"] * rod["length"] / 2
                  * (rod["to"]["fixed"][0] / rod["length"] - 1) ** 2, 1e-4)]
    return rows
