import numpy as np
from answers import agree, between_keys, gravity, quadrature

VARIED = [{"connectors.rope.drag.along": 0.1}, {"air.density": 300.0, "connectors.rope.to.point_mass": 2.0}]


def answer(scene):
    rope, air, fall = scene["connectors"]["rope"], scene["air"], -gravity(scene)[1]
    keys, m = rope["from"]["winch"], rope["to"]["point_mass"]

    def pull(t):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        length = rope["length"] + out
        water = air["density"] / 2 * rope["diameter"] * length * rope["drag"]["along"] * speed**2
        return m * (fall - acceleration) + water / 2, water, -speed

    rows, whole = [], m * fall
    for t in (0.2, 0.4, 0.5, 0.6, 0.8):
        tension, water, _ = pull(t)
        # The work of the tension lifts the weight, moves it, and half of the water's.
        work = quadrature(lambda s: pull(s)[0] * pull(s)[2], 0, t)
        lost = quadrature(lambda s: pull(s)[1] / 2 * pull(s)[2], 0, t)
        out, speed, _ = between_keys(keys, "paid_out", t)
        agree(work, -m * fall * out + m * speed**2 / 2 + lost, 1e-9)
        rows += [(t, "rope.1.y", 2.0 - rope["length"] - out, 1e-6), (t, "rope.0-1.tension", tension, 1e-3 * whole),
                 (t, "rope.0.hold.y", tension + water / 2, 1e-3 * whole)]
    return rows
