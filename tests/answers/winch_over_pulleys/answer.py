import numpy as np
from answers import agree, between_keys, gravity, quadrature

VARIED = [{"connectors.rope.to.point_mass": 0.2}, {"gravity": [0.0, -20.0, 0.0]}]


def answer(scene):
    rope, fall, m = scene["connectors"]["rope"], -gravity(scene)[1], scene["connectors"]["rope"]["to"]["point_mass"]
    foot, tip = [np.array(scene["pulleys"][name]["fixed"]) for name in ("foot", "tip")]
    hangs = rope["length"] - (foot[1] - rope["from"]["fixed"][1]) - np.linalg.norm(tip - foot)
    keys, rows = rope["from"]["winch"], []
    for t in (0.3, 0.5, 0.7, 1.0):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        pull = m * (fall - acceleration)
        work = quadrature(lambda s: -between_keys(keys, "paid_out", s)[1] * m * (fall - between_keys(keys, "paid_out", s)[2]), 0.1, min(t, 0.9))
        agree(work, m * speed**2 / 2 - m * fall * out, 1e-9)
        rows += [(t, "rope#3.1.y", tip[1] - hangs - out, 1e-7), (t, "rope#3.0-1.tension", pull, 1e-5 * pull), (t, "rope.0-1.tension", pull, 1e-5 * pull)]
    return rows
