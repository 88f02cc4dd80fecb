import numpy as np
from answers import agree, gravity, root

VARIED = [
    {"connectors.chain.length": 3.0},
    {"connectors.chain.to": {"fixed": [0.5, 1.0, 0.4]}, "connectors.chain.particles": 8},
]

LINKS = [4, 8, 16, 32, 64]


def continuum(scene):
    """The middle of a chain of even weight: y = a cosh((x - x0)/a) + y0 (Huygens, Leibniz, John Bernoulli)."""
    chain = scene["connectors"]["chain"]
    a, b, length = np.array(chain["from"]["fixed"]), np.array(chain["to"]["fixed"]), chain["length"]
    wide, high = np.hypot(b[0] - a[0], b[2] - a[2]), b[1] - a[1]
    size = root(lambda c: 2 * c * np.sinh(wide / (2 * c)) - np.sqrt(length**2 - high**2), 0.02 * wide, 1e3 * wide)
    low = wide / 2 - size * np.arctanh(high / length)  # of the lowest point, from the first end

    def along(x):  # the length from the first end
        return size * (np.sinh((x - low) / size) + np.sinh(low / size))

    agree(along(wide), length, 1e-9)
    x = root(lambda x: along(x) - length / 2, 0.0, wide)
    y = a[1] + size * (np.cosh((x - low) / size) - np.cosh(low / size))
    place = [a[0] + x / wide * (b[0] - a[0]), y, a[2] + x / wide * (b[2] - a[2])]
    return [(scene["duration"], f"chain.{(chain['particles'] - 1) // 2}.{axis}", value, 1e-6)
            for axis, value in zip("xyz", place)]


def answer(scene):
    chain, fall = scene["connectors"]["chain"], -gravity(scene)[1]
    n = chain["particles"] - 1
    l, weight = chain["length"] / n, chain["mass"] / (n + 1) * fall
    a, b = np.array(chain["from"]["fixed"]), np.array(chain["to"]["fixed"])
    across = np.array([b[0] - a[0], 0, b[2] - a[2]])
    wide, high = np.linalg.norm(across), b[1] - a[1]
    across /= wide

    def tangents(h, v):  # v: the vertical pull of the first link, upwards along the chain
        return (v + weight * np.arange(n)) / h

    def rise(h, v):
        s = tangents(h, v)
        return np.sum(l * s / np.hypot(1, s))

    def pull(h):  # the v at which the rise is right
        return root(lambda v: rise(h, v) - high, -1e4 * weight * n, 1e4 * weight * n)

    def width(h):
        return np.sum(l / np.hypot(1, tangents(h, pull(h))))

    h = root(lambda h: width(h) - wide, 1e-3 * weight, 1e3 * weight)
    v = pull(h)
    s = tangents(h, v)
    steps = l * (np.outer(1 / np.hypot(1, s), across) + np.outer(s / np.hypot(1, s), [0, 1, 0]))
    x = a + np.vstack([[0, 0, 0], np.cumsum(steps, axis=0)])
    agree(x[-1], b, 1e-9)
    # The second route: no small move of a knot changes the weight's energy; the links' forces balance.
    tensions = h * np.hypot(1, s)
    forces = tensions[:, None] * steps / l
    agree(forces[1:] - forces[:-1], np.outer(np.full(n - 1, weight), [0, 1, 0]), 1e-9)
    t, rows = scene["duration"], []
    for k in range(n + 1):
        rows += [(t, f"chain.{k}.{axis}", x[k][j], 1e-6) for j, axis in enumerate("xyz")]
    rows += [(t, f"chain.{k}-{k + 1}.tension", tensions[k], 1e-5 * tensions[k]) for k in range(n)]
    end = np.array([0, weight, 0])  # of the held particle itself
    rows += [(t, f"chain.0.hold.{axis}", (end - forces[0])[j], 1e-5 * tensions[0]) for j, axis in enumerate("xyz")]
    rows += [(t, f"chain.{n}.hold.{axis}", (end + forces[-1])[j], 1e-5 * tensions[-1]) for j, axis in enumerate("xyz")]
    return rows
