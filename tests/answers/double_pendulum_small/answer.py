import numpy as np
from answers import agree, frames, gravity

VARIED = [{"connectors.rod.length": 3.0}, {"connectors.rod.start.direction": [0.0, -1.0, 0.01]}]


def answer(scene):
    rod, times = scene["connectors"]["rod"], frames(scene)
    l, fall = rod["length"] / 2, -gravity(scene)[1]
    d = np.array(rod["start"]["direction"], float)
    slope = d[[0, 2]] / np.linalg.norm(d)
    # m x'' = -K x of the places across, K in units of m g/l: tensions are 2 m g and m g.
    stiffness = fall / l * np.array([[3.0, -1.0], [-1.0, 1.0]])
    squares, ways = np.linalg.eigh(stiffness)
    agree(squares, np.array([2 - np.sqrt(2), 2 + np.sqrt(2)]) * fall / l, 1e-10)
    shares = ways.T @ np.array([l, 2 * l])
    tolerance = 1e-5 * (rod["length"] if np.max(np.abs(slope)) > 0.015 else 0.3 * rod["length"])
    rows = []
    for t in times:
        x = ways @ (shares * np.cos(np.sqrt(squares) * t))
        for k in (0, 1):
            rows += [(t, f"rod.{k + 1}.{axis}", x[k] * s, tolerance) for axis, s in zip("xz", slope)]
    return rows
