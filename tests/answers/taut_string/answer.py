import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.string.to.fixed": [1.1, 0.0, 0.0]}, {"gravity": [0.0, 0.0, 0.05]}]


def answer(scene):
    string, times = scene["connectors"]["string"], frames(scene, 5)
    n, g = string["particles"] - 1, gravity(scene)
    each, wide = string["mass"] / (n + 1), string["to"]["fixed"][0]
    tension = string["axial_stiffness"] * (wide / string["length"] - 1)
    j, k = np.arange(1, n), np.arange(1, n)
    rates = 2 * np.sqrt(tension * n / (each * wide)) * np.sin(j * np.pi / (2 * n))
    ways = np.sqrt(2 / n) * np.sin(np.outer(k, j) * np.pi / n)
    agree(ways.T @ ways, np.eye(n - 1), 1e-12)
    matrix = tension * n / (each * wide) * (2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1))
    axis, pull = ("y", g[1]) if g[1] else ("z", g[2])
    other = integrate(lambda t, y: np.concatenate([y[n - 1:], pull - matrix @ y[:n - 1]]), np.zeros(2 * n - 2), times)
    rows = []
    for t, y in zip(times, other):
        x = ways @ ((ways.T @ np.full(n - 1, pull)) * (1 - np.cos(rates * t)) / rates**2)
        agree(x, y[:n - 1], 1e-10)
        rows += [(t, f"string.{i + 1}.{axis}", x[i], 1e-6) for i in range(n - 1)]
    return rows
