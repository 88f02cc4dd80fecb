import numpy as np
from answers import frames, gravity, swings

VARIED = [{"connectors.rope.taper": [0.5, 1.0]}, {"connectors.rope.axial_stiffness": 200.0, "connectors.rope.particles": 10}]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    n = rope["particles"] - 1
    l, taper = rope["length"] / n, rope["taper"]
    squared = np.interp((np.arange(n) + 0.5) / n, np.linspace(0, 1, len(taper)), taper) ** 2
    links = rope["mass"] * squared / np.sum(squared)
    stiffness = np.zeros((n + 1, n + 1))
    for k in range(n):
        stiffness[k:k + 2, k:k + 2] += rope["axial_stiffness"] * squared[k] / l * np.array([[1, -1], [-1, 1]])
    stiffness, each = stiffness[1:, 1:], (np.append(links, 0) + np.append(0, links))[1:] / 2
    rest = np.linalg.solve(stiffness, each * fall)
    rows = []
    for t, u in zip(times, swings(np.diag(each), stiffness, -rest, np.zeros(n), times)):
        rows += [(t, f"rope.{k + 1}.y", 1 - l * (k + 1) - rest[k] - u[k], 2e-5) for k in range(n)]
    return rows
