import numpy as np
from answers import agree, frames, gravity, integrate

VARIED = [{"connectors.rope.to.point_mass": 0.4}, {"connectors.rope.particles": 4}]


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
