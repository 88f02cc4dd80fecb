import numpy as np
from answers import agree, between_keys, frames, integrate, quadrature

VARIED = [{"connectors.rope.start.spin": [0.0, 0.0, -6.0]}, {"connectors.rope.to.point_mass": 30.0}]


def answer(scene):
    rope, times = scene["connectors"]["rope"], frames(scene)
    keys, l, spin = rope["from"]["winch"], rope["length"], rope["start"]["spin"][2]

    def h(t):
        return l + between_keys(keys, "paid_out", t)[0]

    y = integrate(lambda t, s: spin * l * l / h(t) ** 2 * np.array([-s[1], s[0]]), [1.0, 0.0], times)
    rows = []
    for t, way in zip(times, y):
        angle = quadrature(lambda s: spin * l * l / h(s) ** 2, 0, t)
        agree(way, [np.cos(angle), np.sin(angle)], 1e-9)
        rows += [(t, "rope.1.x", h(t) * way[0], 3e-5), (t, "rope.1.y", h(t) * way[1], 3e-5)]
    return rows
