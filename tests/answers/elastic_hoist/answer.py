import numpy as np
from answers import agree, between_keys, frames, gravity, integrate

VARIED = [{"connectors.rope.axial_stiffness": 600.0}, {"connectors.rope.to.point_mass": 0.5}]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    keys, mass, ea = rope["from"]["winch"], rope["to"]["point_mass"], rope["axial_stiffness"]

    def h(t):
        return rope["length"] + between_keys(keys, "paid_out", t)[0]

    stops = sorted(set(times) | {0.8})
    length = integrate(lambda t, s: np.array([s[1], fall - ea / mass * (s[0] / h(t) - 1)]), [rope["length"], 0], stops)[:, 0]
    # The second route: the strain e = l/h - 1 as the unknown.
    def strain(t, s):
        out, speed, acceleration = between_keys(keys, "paid_out", t)
        own = rope["length"] + out
        right = fall - ea / mass * s[0] - acceleration * (1 + s[0]) - 2 * speed * s[1]
        return np.array([s[1], right / own])
    e = integrate(strain, [0, 0], stops)[:, 0]
    agree([h(t) * (1 + s) for t, s in zip(stops, e)], length, 1e-8)
    return [(t, "rope.1.y", 3.0 - length[stops.index(t)], 3e-5) for t in times]
