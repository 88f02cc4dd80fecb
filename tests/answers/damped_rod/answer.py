import numpy as np
from answers import agree, beam_stiffness, frames, gravity, integrate

VARIED = [{"connectors.rod.bending_damping": 0.002}, {"connectors.rod.to.point_mass": 0.05, "connectors.rod.particles": 5}]


def answer(scene):
    rod, pull, times = scene["connectors"]["rod"], gravity(scene)[1], frames(scene, 8)
    n = rod["particles"] - 1
    each = np.full(n, rod["mass"] / (n + 1))
    each[-1] += rod["to"]["point_mass"]
    share = rod["bending_damping"] / rod["bending_stiffness"]
    stiffness = beam_stiffness(n, rod["length"] / n, rod["bending_stiffness"])[1:n + 1, 1:n + 1]
    states = integrate(lambda t, y: np.append(y[n:], pull - stiffness @ (y[:n] + share * y[n:]) / each), np.zeros(2 * n), times, 0.0, 1e-10)
    squares, ways = np.linalg.eigh(stiffness / np.sqrt(np.outer(each, each)))
    rests = pull * (ways.T @ np.sqrt(each)) / squares
    root = np.sqrt((share * squares / 2) ** 2 - squares + 0j)
    fast, slow = -share * squares / 2 - root, -share * squares / 2 + root
    rows, size = [], np.max(np.abs(states[:, :n]))
    for t, state in zip(times, states):
        swings = ((fast * np.exp(slow * t) - slow * np.exp(fast * t)) / (fast - slow)).real
        u = ways @ (rests * (1 - swings)) / np.sqrt(each)
        agree(u, state[:n], 1e-6 * size)
        rows += [(t, f"rod.{k + 1}.y", u[k], 2e-3 * size) for k in range(n)]
    return rows
