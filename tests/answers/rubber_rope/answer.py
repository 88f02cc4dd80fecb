import numpy as np
from answers import agree, frames, gravity, integrate, quadrature, root

VARIED = [{"connectors.rope.to.point_mass": 0.4}, {"connectors.rope.particles": 4}]

LINKS = [4, 8, 16, 32]


def continuum(scene):
    """The end of a heavy elastic bar with a weight: ways sin(b s/L) with b tan b = bar's mass/weight's."""
    rope, fall, made = scene["connectors"]["rope"], -gravity(scene)[1], scene["connectors"]["rope"]["material"]
    area, length, load = np.pi * made["diameter"] ** 2 / 4, rope["length"], rope["to"]["point_mass"]
    line, ea = made["density"] * area, made["youngs_modulus"] * area
    rest = lambda s: fall / ea * (line * (length * s - s * s / 2) + load * s)
    end, sums = np.zeros(len(frames(scene))), 0.0
    for k in range(60):
        b = root(lambda b: b * np.sin(b) - line * length / load * np.cos(b), k * np.pi, (k + 0.5) * np.pi)
        way = lambda s: np.sin(b * s / length)
        size = quadrature(lambda s: line * way(s) ** 2, 0, length, 300) + load * np.sin(b) ** 2
        share = (quadrature(lambda s: line * rest(s) * way(s), 0, length, 300) + load * rest(length) * np.sin(b)) / size * np.sin(b)
        sums += share
        end += share * np.cos(b / length * np.sqrt(ea / line) * np.array(frames(scene)))
    agree(sums, rest(length), 1e-3 * rest(length), "the sum of the ways and the rest")
    return [(t, f"rope.{rope['particles'] - 1}.y", 1 - length - rest(length) + e, 1e-5) for t, e in zip(frames(scene), end)]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    n, made = rope["particles"] - 1, rope["material"]
    area, l = np.pi * made["diameter"] ** 2 / 4, rope["length"] / n
    masses = np.full(n, made["density"] * area * l)
    masses[-1] = masses[-1] / 2 + rope["to"]["point_mass"]
    k = made["youngs_modulus"] * area / l
    matrix = k * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    matrix[-1, -1] = k
    scale = np.sqrt(masses)
    squares, ways = np.linalg.eigh(matrix / np.outer(scale, scale))
    rest = np.linalg.solve(matrix, masses * fall)
    y = integrate(lambda t, s: np.concatenate([s[n:], fall - matrix @ s[:n] / masses]), np.zeros(2 * n), times)
    rows = []
    for t, state in zip(times, y):
        down = rest - ways @ ((ways.T @ (scale * rest)) * np.cos(np.sqrt(squares) * t)) / scale
        agree(down, state[:n], 1e-8)
        rows += [(t, f"rope.{i + 1}.y", 1 - l * (i + 1) - down[i], 2e-5) for i in range(n)]
    return rows
