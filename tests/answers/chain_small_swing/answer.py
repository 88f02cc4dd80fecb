import numpy as np
from answers import agree, frames, gravity

VARIED = [{"connectors.chain.particles": 6}, {"connectors.chain.length": 0.3, "duration": 1.0}]


def answer(scene):
    chain, times = scene["connectors"]["chain"], frames(scene)
    n, fall = chain["particles"] - 1, -gravity(scene)[1]
    l = chain["length"] / n
    d = np.array(chain["start"]["direction"])
    slope = d[0] / np.linalg.norm(d)
    tension = np.arange(n, 0, -1)  # of each link, in weights of a bead
    stiffness = np.diag(tension + np.append(tension[1:], 0)) - np.diag(tension[1:], 1) - np.diag(tension[1:], -1)
    squares, ways = np.linalg.eigh(stiffness * fall / l)
    zeros = np.sort(np.polynomial.laguerre.lagroots([0] * n + [1]))
    agree(squares, zeros * fall / l, 1e-9 * squares[-1])
    shares = ways.T @ (slope * l * np.arange(1, n + 1))
    rows = []
    for t in times:
        x = ways @ (shares * np.cos(np.sqrt(squares) * t))
        rows += [(t, f"chain.{k + 1}.x", x[k], 2e-5 * chain["length"]) for k in range(n)]
    return rows
