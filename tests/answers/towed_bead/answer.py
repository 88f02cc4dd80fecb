import numpy as np
from answers import agree, between_keys, gravity, quadrature

VARIED = [{"obstacles.floor.friction": 0.9}, {"connectors.rope.to.point_mass": 3.0}]


def answer(scene):
    rope, fall, mu = scene["connectors"]["rope"], -gravity(scene)[1], scene["obstacles"]["floor"]["friction"]
    keys, m, rows = rope["from"]["winch"], rope["to"]["point_mass"], []
    for t in (0.1, 0.3, 0.5, 0.7, 0.9):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        pull = m * (mu * fall - acceleration)
        # The work of the pull is the heat of friction and the motion gained.
        work = quadrature(lambda s: m * (mu * fall - between_keys(keys, "paid_out", s)[2]) * -between_keys(keys, "paid_out", s)[1], 0, t)
        agree(work, -mu * m * fall * out + m * speed**2 / 2, 1e-10)
        rows += [(t, "rope.1.x", rope["length"] + out, 1e-7), (t, "rope.1.y", 0.02, 1e-7)]
        rows += [(t, "rope.0-1.tension", pull, 2e-4 * pull), (t, "floor.contact.y", -m * fall, 1e-4 * m * fall)]
    return rows
