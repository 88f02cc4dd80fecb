import numpy as np
from answers import agree, frames, gravity

VARIED = [{"pulleys.sheave.bearing": 0.3}, {"connectors.rope.to.point_mass": 3.0, "duration": 0.4}]


def answer(scene):
    rope, sheave, fall = scene["connectors"]["rope"], scene["pulleys"]["sheave"], -gravity(scene)[1]
    m, big, b, inertia = rope["from"]["point_mass"], rope["to"]["point_mass"], sheave["bearing"], sheave["inertia"]
    # M (g - a) - I a/2 = (1 + b)/(1 - b) (m (g + a) + I a/2)
    light, heavy = np.array([[m, m + inertia / 2], [big, -big - inertia / 2]])  # pulls at the sheave: g, a
    ratio = (1 + b) / (1 - b)
    a = max(0.0, (heavy[0] - ratio * light[0]) * fall / (ratio * light[1] - heavy[1]))
    rows, before = [], rope["start"]["before"]
    for t in frames(scene):
        way, speed = a * t * t / 2, a * t
        # The energy that the bearing takes along the way.
        pulls = (light + heavy) @ [fall, a]
        agree((big - m) * fall * way - b * pulls * way * (a > 0), (m + big + inertia) * speed**2 / 2, 1e-9)
        rows += [(t, "rope.0.y", 2.0 - before + way, 1e-8), (t, "rope#2.1.y", 2.0 - (rope["length"] - before) - way, 1e-8)]
    return rows
