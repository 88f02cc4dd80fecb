import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.rope.axial_stiffness": 3000.0}, {"connectors.rope.to.point_mass": 1.0}]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    m, big, k = rope["from"]["point_mass"], rope["to"]["point_mass"], rope["axial_stiffness"] / rope["length"]
    rate = np.sqrt(k * (1 / m + 1 / big))
    mean = 2 * fall / (1 / m + 1 / big)
    y = integrate(lambda t, s: np.array([s[2], s[3], fall - k * (s[0] + s[1]) / m, fall - k * (s[0] + s[1]) / big]),
                  [0, 0, 0, 0], times)
    before, rows = rope["start"]["before"], []
    for t, state in zip(times, y):
        stretch = mean / k * (1 - np.cos(rate * t))
        # (M y - m x)'' = (M - m) g of both ways down.
        both = (big - m) * fall * t * t / 2
        down = np.array([(big * stretch - both) / (big + m), (m * stretch + both) / (big + m)])
        agree(down, state[:2], 1e-9)
        rows += [(t, "rope.0.y", 2.0 - before - down[0], 5e-5),
                 (t, "rope#2.1.y", 2.0 - (rope["length"] - before) - down[1], 5e-5)]
    return rows
