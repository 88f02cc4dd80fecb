import numpy as np
from answers import agree, gravity

VARIED = [{"pulleys.sheave.inertia": 1.5}, {"connectors.rope.from.point_mass": 0.9}]


def answer(scene):
    rope, fall, inertia = scene["connectors"]["rope"], -gravity(scene)[1], scene["pulleys"]["sheave"]["inertia"]
    m, big, end = rope["from"]["point_mass"], rope["to"]["point_mass"], scene["duration"]
    a = (big - m) * fall / (big + m + inertia)
    height = 2.0 - (rope["length"] - rope["start"]["before"])
    lands = np.sqrt(2 * height / a)
    speed = a * lands
    agree(0.5 * (m + big + inertia) * speed**2, (big - m) * fall * height, 1e-9)
    slows = m * fall / (m + inertia)
    rows, low = [], 2.0 - rope["start"]["before"]
    for t in (lands / 2, lands * 0.95):
        rows += [(t, "rope.0.y", low + a * t * t / 2, 1e-6), (t, "rope#2.1.y", height - a * t * t / 2, 1e-6)]
    for t in (lands + 0.03, lands + 0.07):
        if t < min(end, lands + speed / slows):
            s = t - lands
            rows += [(t, "rope.0.y", low + height + speed * s - slows * s * s / 2, 1e-5), (t, "rope#2.1.y", 0.0, 1e-6)]
    return rows
