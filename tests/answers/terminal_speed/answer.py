import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"air.density": 30.0}, {"connectors.rope.start.points": [[0.0, 2.0, 0.0], [0.0, 3.0, 0.0]]}]
DRAWN = [{"air.density": 30.0}, {"connectors.rope.mass": 1.0}]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    a, b = np.array(rope["start"]["points"])
    coefficient = rope["drag"]["across" if abs(b[1] - a[1]) < 0.5 else "along"]
    drag = scene["air"]["density"] * rope["length"] * rope["diameter"] * coefficient / 2
    links = rope["particles"] - 1
    top = np.sqrt(rope["mass"] * fall / drag)
    y = integrate(lambda t, s: np.array([s[1], fall - drag / rope["mass"] * s[1] ** 2]), [0, 0], times)
    rows = []
    for t, state in zip(times, y):
        speed, way = top * np.tanh(fall * t / top), top**2 / fall * np.log(np.cosh(fall * t / top))
        agree([way, speed], state, 1e-9)
        for k in range(links + 1):
            rows += [(t, f"rope.{k}.y", a[1] + (b[1] - a[1]) * k / links - way, 1e-7), (t, f"rope.{k}.vy", -speed, 1e-7)]
    return rows
