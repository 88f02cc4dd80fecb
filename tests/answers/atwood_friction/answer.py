import numpy as np
from answers import agree, frames, gravity

VARIED = [{"pulleys.eye.friction": 0.05, "duration": 0.45}, {"pulleys.eye.friction": 0.6}, {"pulleys.eye": {"fixed": [0.0, 2.0, 0.0], "inertia": 0.3, "bearing": 0.1}}]


def answer(scene):
    rope, eye, fall, times = scene["connectors"]["rope"], scene["pulleys"]["eye"], -gravity(scene)[1], frames(scene)
    m, big = rope["from"]["point_mass"], rope["to"]["point_mass"]
    bearing, inertia = eye.get("bearing", 0), eye.get("inertia", 0)
    ratio = np.exp(eye.get("friction", 0) * np.pi) * (1 + bearing) / (1 - bearing)
    # M (g - a) - I a/2 = E (m (g + a) + I a/2)
    a = max(0.0, (big - ratio * m) * fall / (big + ratio * m + inertia * (1 + ratio) / 2))
    if a:
        tensions = np.array([m * (fall + a), big * (fall - a)])
        agree(tensions[1] - inertia * a / 2, ratio * (tensions[0] + inertia * a / 2), 1e-9)
    else:
        agree(min(big / m, ratio), big / m, 1e-12)
    rows = []
    for t in times:
        way = a * t * t / 2
        rows += [(t, "rope.0.y", 2.0 - rope["start"]["before"] + way, 1e-9),
                 (t, "rope#2.1.y", 2.0 - (rope["length"] - rope["start"]["before"]) - way, 1e-9)]
    return rows
