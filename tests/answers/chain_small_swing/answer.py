import numpy as np
from answers import agree, frames, gravity, root

VARIED = [{"connectors.chain.particles": 6}, {"connectors.chain.length": 0.3, "duration": 1.0}]

LINKS = [8, 16, 32, 64]


def bessel(order, x):
    """J of the order 0 or 1, by its integral, which the trapezoid rule has exactly for small x."""
    turns = 2 * np.pi * np.arange(256) / 256
    return np.mean(np.cos(order * turns - x * np.sin(turns)))


def continuum(scene):
    """The end of a hanging chain (Daniel Bernoulli, 1733): ways J0(j sqrt(z/L)) by the distance z from the end,
    with the zeros j of J0 and w = j/2 sqrt(g/L); the straight chain is sum 8/(j^3 J1(j)) of them."""
    chain = scene["connectors"]["chain"]
    length, d = chain["length"], np.array(chain["start"]["direction"])
    zeros = np.array([root(lambda x: bessel(0, x), (k - 0.5) * np.pi, (k + 0.0) * np.pi) for k in range(1, 31)])
    shares = np.array([8 / (j**3 * bessel(1, j)) for j in zeros])
    agree(np.sum(shares), 1, 1e-3)
    rates = zeros / 2 * np.sqrt(-gravity(scene)[1] / length)
    return [(t, f"chain.{chain['particles'] - 1}.x", length * d[0] / np.linalg.norm(d) * (shares @ np.cos(rates * t)), 1e-5)
            for t in frames(scene)]


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
