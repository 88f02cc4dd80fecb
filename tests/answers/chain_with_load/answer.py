import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.chain.to.point_mass": 200.0, "method.tolerance": 1e-3}, {"connectors.chain.to.point_mass": 0.02}, {"gravity": [0.0, -1.62, 0.0]}]


def answer(scene):
    chain, times = scene["connectors"]["chain"], frames(scene)
    n, fall = chain["particles"] - 1, -gravity(scene)[1]
    l, masses = chain["length"] / n, np.full(n, chain["mass"] / (n + 1))
    masses[-1] += chain["to"]["point_mass"]
    d = np.array(chain["start"]["direction"])
    tension = fall * np.cumsum(masses[::-1])[::-1] / l
    stiffness = np.diag(tension + np.append(tension[1:], 0)) - np.diag(tension[1:], 1) - np.diag(tension[1:], -1)
    scale = np.sqrt(masses)
    squares, ways = np.linalg.eigh(stiffness / np.outer(scale, scale))
    start = d[0] / np.linalg.norm(d) * l * np.arange(1, n + 1)
    shares = ways.T @ (scale * start)
    x = np.array([ways @ (shares * np.cos(np.sqrt(squares) * t)) / scale for t in times])
    other = integrate(lambda t, y: np.concatenate([y[n:], -(stiffness @ y[:n]) / masses]),
                      np.concatenate([start, 0 * start]), times)
    agree(other[:, :n], x, 1e-8)
    return [(t, f"chain.{k}.x", x[i, k - 1], 2e-5) for i, t in enumerate(times) for k in (n // 2, n)]
