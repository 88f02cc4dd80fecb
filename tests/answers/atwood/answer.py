import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.rope.to.point_mass": 0.7}, {"gravity": [0.0, -1.62, 0.0]}, {"pulleys.eye.inertia": 0.8}]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    eye = scene["pulleys"]["eye"]
    m, big, inertia = rope["from"]["point_mass"], rope["to"]["point_mass"], eye.get("inertia", 0)
    a = (big - m) * fall / (big + m + inertia)
    before, top = rope["start"]["before"], eye["fixed"][1]
    # Newton's second law for each weight and the sheave.
    unknown = np.linalg.solve([[m, -1, 0], [big, 0, 1], [inertia, 1, -1]], [-m * fall, big * fall, 0])
    agree(unknown, [a, m * (fall + a), big * (fall - a)], 1e-9)
    rows = []
    for t in times:
        way = a * t * t / 2
        agree(integrate(lambda s, y: np.array([y[1], a]), [0, 0], [t])[0][0], way, 1e-12)
        rows += [(t, "rope.0.y", top - before + way, 1e-10), (t, "rope#2.1.y", top - (rope["length"] - before) - way, 1e-10),
                 (t, "eye.passed", way, 1e-10), (t, "rope.0-1.tension", m * (fall + a), 1e-5 * m * fall)]
    return rows
