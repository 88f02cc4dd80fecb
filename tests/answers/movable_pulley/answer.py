import numpy as np
from answers import agree, frames, gravity

VARIED = [{"connectors.rope.to.point_mass": 1.0}, {"bodies.block.mass": 9.0}]


def answer(scene):
    rope, block, fall, times = scene["connectors"]["rope"], scene["bodies"]["block"], -gravity(scene)[1], frames(scene)
    m, big = rope["to"]["point_mass"], block["mass"]
    up = (2 * m - big) * fall / (big + 4 * m)
    tension = np.linalg.solve([[big, -2], [2 * m, 1]], [-big * fall, m * fall])
    agree(tension[0], up, 1e-12)
    rest = rope["length"] - 2 * (2.0 - block["position"][1])
    rows = []
    for t in times:
        way = up * t * t / 2
        rows += [(t, "block.y", block["position"][1] + way, 2e-6), (t, "rope#3.1.y", 2.0 - rest - 2 * way, 4e-6),
                 (t, "block.x", 0.0, 1e-5)]
    return rows
