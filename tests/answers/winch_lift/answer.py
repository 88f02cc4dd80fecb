import numpy as np
from answers import agree, between_keys, gravity

VARIED = [{"connectors.rope.to.point_mass": 0.1}, {"connectors.rope.particles": 2}]


def answer(scene):
    rope, fall = scene["connectors"]["rope"], -gravity(scene)[1]
    keys, top, load = rope["from"]["winch"], rope["from"]["fixed"][1], rope["to"]["point_mass"]
    n = rope["particles"]
    each = rope["mass"] / n  # half of an end's particle flows, half stays with the end
    density = each / (rope["length"] / (n - 1))

    def momentum(t):  # of all that hangs
        out, speed, _ = between_keys(keys, "paid_out", t)
        return -(load + each / 2 + density * (rope["length"] + out)) * speed

    rows = []
    for t in (0.25, 0.5, 0.75, 1.0):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        length = rope["length"] + out
        hung = load + each / 2 + density * length
        pull = hung * (fall - acceleration)
        # The second route: momentum changes by the pull, the weight and what leaves at the drum.
        h = 1e-4
        change = (momentum(t + h) - momentum(t - h)) / (2 * h)
        agree(change, pull - hung * fall - density * speed**2, 1e-6 * hung * fall)
        rows += [(t, f"rope.{n - 1}.y", top - length, 1e-9), (t, "rope.length", length, 1e-9),
                 (t, "rope.from.tension", pull, 1e-9 * hung * fall)]
    return rows
