import numpy as np
from answers import agree, frames, gravity

VARIED = [{"connectors.rope.particles": 4}, {"connectors.rope.axial_stiffness": 400.0}]

LINKS = [4, 8, 16, 32, 64]


def continuum(scene):
    """The end of a bar that is let go under its weight: its ways sin((2 j - 1) pi s/2L), j = 1, 2, ..."""
    rope, fall = scene["connectors"]["rope"], -gravity(scene)[1]
    length, line, ea = rope["length"], rope["mass"] / rope["length"], rope["axial_stiffness"]
    odd = 2 * np.arange(1, 20001) - 1
    sizes = 16 * line * fall * length**2 / (ea * np.pi**3 * odd**3) * np.where(odd % 4 == 1, 1, -1)
    sink = line * fall * length**2 / (2 * ea)
    agree(np.sum(sizes), sink, 1e-9 * sink, "the sum of the ways and the rest")
    rates = odd * np.pi / (2 * length) * np.sqrt(ea / line)
    return [(t, f"rope.{rope['particles'] - 1}.y", 1 - length - sink + sizes @ np.cos(rates * t), 1e-5)
            for t in frames(scene)]


def answer(scene):
    rope, fall, times = scene["connectors"]["rope"], -gravity(scene)[1], frames(scene)
    n = rope["particles"] - 1
    l, each = rope["length"] / n, rope["mass"] / (n + 1)
    k = rope["axial_stiffness"] / l
    matrix = k / each * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    matrix[-1, -1] = k / each
    squares, ways = np.linalg.eigh(matrix)
    known = 2 * np.sqrt(k / each) * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))
    agree(np.sqrt(squares), known, 1e-9 * known[-1])
    rest = np.linalg.solve(matrix, np.full(n, fall))
    rows = []
    for t in times:
        down = rest - ways @ ((ways.T @ rest) * np.cos(known * t))
        rows += [(t, f"rope.{i + 1}.y", 1 - l * (i + 1) - down[i], 2e-5) for i in range(n)]
    return rows
