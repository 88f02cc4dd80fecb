import numpy as np
from answers import agree, frames

VARIED = [{"connectors.ring.rest_twist": -17.0}, {"connectors.ring.rest_twist": 0.0}, {"connectors.ring.rest_twist": 26.0, "duration": 0.2}]
SHARE = 1e-3  # of the radius, by which the ring starts out of its plane


def polygon(scene, up, bent=(0.0, 0.0)):
    """A closed polygon of the ring's links: its beads are up cos(2 phi) out of the plane, its links turned by
    bent[0] cos(2 phi) + bent[1] sin(2 phi) in it. Opposite links are parallel, so that it closes."""
    ring = scene["connectors"]["ring"]
    n = ring["particles"] - 1
    l, phi = ring["length"] / n, 2 * np.pi * np.arange(n) / n
    middle = phi + np.pi / n
    rises = np.roll(up * np.cos(2 * phi), -1) - up * np.cos(2 * phi)
    heads = middle + np.pi / 2 + bent[0] * np.cos(2 * middle) + bent[1] * np.sin(2 * middle)
    flat = np.sqrt(l * l - rises**2)
    x = np.cumsum(np.array([flat * np.cos(heads), flat * np.sin(heads), rises]).T, axis=0)
    x = np.vstack([[0, 0, 0], x])[:-1]
    return x - np.mean(x, axis=0)


def prepared(scene):
    ring = scene["connectors"]["ring"]
    x = polygon(scene, SHARE * ring["length"] / (2 * np.pi))
    ring["start"] = {"points": [*x.tolist(), x[0].tolist()]}
    return scene


def energy(scene, x):
    """Of the bends, and of the uniform moment with the turn of a vector that is carried round."""
    ring = scene["connectors"]["ring"]
    l, edges = ring["length"] / len(x), np.roll(x, -1, axis=0) - x
    t = edges / l
    after = np.roll(t, -1, axis=0)
    c = 2 * np.cross(t, after) / (1 + np.sum(t * after, axis=1))[:, None]
    bends = ring["bending_stiffness"] * np.sum(c * c) / (2 * l)
    v = np.cross(t[0], [0.1, 0.2, 1.0])
    v = v / np.linalg.norm(v)
    start = v
    for a, b in zip(t, after):
        axis = np.cross(a, b)
        size = np.linalg.norm(axis)
        axis, angle = axis / size, np.arctan2(size, a @ b)
        v = v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))
    turned = np.arctan2(np.cross(start, v) @ t[0], start @ v)
    return bends + ring["twisting_stiffness"] * ring["rest_twist"] * turned


def answer(scene):
    ring, times = scene["connectors"]["ring"], frames(scene)
    n, radius = ring["particles"] - 1, ring["length"] / (2 * np.pi)
    size = SHARE * radius
    step = np.array([1e-2 * radius, 1e-2, 1e-2])
    at = lambda q: polygon(scene, q[0], q[1:])
    units = np.diag(step)
    ways = np.array([(at(e) - at(-e)) / (2 * h) for e, h in zip(units, step)])
    mass = ring["mass"] / n * np.einsum("ikd,jkd->ij", ways, ways)
    stiffness = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            d, e = units[i], units[j]
            stiffness[i, j] = (energy(scene, at(d + e)) - energy(scene, at(d - e)) - energy(scene, at(e - d)) + energy(scene, at(-d - e))) / (4 * step[i] * step[j])
    squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness))
    # The continuous ring of n = 2 waves: out of the plane K = k n^2 (n^2 - 1), in it k (n^2 - 1)^2 with the mass
    # 1 + 1/n^2, joined by k n (n^2 - 1) m R/EI.
    k = ring["bending_stiffness"] / (ring["mass"] / ring["length"] * radius**4)
    join = 6 * k * ring["twisting_stiffness"] * ring["rest_twist"] * radius / ring["bending_stiffness"]
    known = np.linalg.eigvals(np.linalg.solve(np.diag([1.0, 1.25]), [[12 * k, join], [join, 9 * k]]))
    for value in known:
        agree(np.min(np.abs(squares - value)), 0, 350 * k / n**2)
    flips = np.linalg.solve(mass, stiffness)
    values, shapes = np.linalg.eig(flips.astype(complex))
    share = np.linalg.solve(shapes, np.array([size, 0, 0], complex))
    rows = []
    for t in times:
        q = (shapes @ (share * np.cos(np.sqrt(values) * t))).real
        x = at(q)
        rows += [(t, f"ring.{k}.{axis}", x[k][j], 0.02 * max(size, np.max(np.abs(q)) * radius)) for k in range(0, n, 3) for j, axis in enumerate("xyz")]
    return rows
