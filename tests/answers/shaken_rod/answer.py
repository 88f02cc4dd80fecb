import numpy as np
from answers import agree, beam_stiffness, between_keys, frames, integrate, quadrature

VARIED = [{"connectors.rod.to.point_mass": 0.3}, {"connectors.rod.bending_stiffness": 1.0, "connectors.rod.particles": 8}]


def answer(scene):
    rod, keys, times = scene["connectors"]["rod"], scene["paths"]["hand"]["keys"], frames(scene, 8)
    n = rod["particles"] - 1
    each = np.full(n, rod["mass"] / (n + 1))
    each[-1] += rod["to"]["point_mass"]
    stiffness = beam_stiffness(n, rod["length"] / n, rod["bending_stiffness"])[1:n + 1, 1:n + 1]
    moved = lambda t: [value[1] for value in between_keys(keys, "position", t)] if t < keys[1]["t"] else [keys[1]["position"][1], 0, 0]
    stops = sorted({*times, keys[1]["t"]})
    states = integrate(lambda t, y: np.append(y[n:], -(stiffness @ y[:n]) / each - moved(t)[2]), np.zeros(2 * n), stops, 0.0, 1e-11)
    squares, ways = np.linalg.eigh(stiffness / np.sqrt(np.outer(each, each)))
    rates, pushed = np.sqrt(squares), ways.T @ np.sqrt(each)
    rows, size = [], np.max(np.abs(states[:, :n]))
    for t in times:
        end = min(t, keys[1]["t"])
        swing = [-quadrature(lambda s: moved(s * (1 - 1e-12))[2] * np.sin(w * (t - s)) / w, 0, end, 80) for w in rates]
        u = ways @ (pushed * swing) / np.sqrt(each)
        agree(u, states[stops.index(t)][:n], 2e-3 * size)
        rows += [(t, f"rod.{k + 1}.y", moved(t)[0] + u[k], 0.01 * size) for k in range(n)]
    return rows
