import numpy as np
from answers import Rest, agree, gravity, in_space, root, tensions_at_rest

VARIED = [{"connectors.line.particles": 11}, {"connectors.line.length": 520.0}, {"connectors.line.to.fixed": [380.0, 200.0, 0.0]}]
LINKS = [10, 20, 40, 80]


def line_of(scene):
    """Number of links, weights (N) of the particles, places of both ends, height of beads that lie."""
    line, fall = scene["connectors"]["line"], -gravity(scene)[1]
    n = line["particles"] - 1
    return n, np.full(n + 1, line["mass"] * fall / (n + 1)), line["from"]["fixed"][:2], line["to"]["fixed"][:2], line["radius"]


def at_rest(scene):
    n, weights, anchor, fairlead, floor = line_of(scene)
    h, _, lies = forces_of_even_line(scene)
    l = scene["connectors"]["line"]["length"] / n
    above = np.maximum(0.0, l * (np.arange(n) + 0.5) - lies)
    guess = np.arctan(np.sum(weights) / (n * l) * above / h)
    return Rest(l, weights, start=anchor, end=fairlead, floor=floor).find(guess, range(1, int(lies / l) + 1))


def prepared(scene):
    """The line starts in its shape at rest."""
    scene["connectors"]["line"]["start"] = {"points": in_space(at_rest(scene)[0]).tolist()}
    return scene


def forces_of_even_line(scene):
    """The forces (N) of an inextensible line of even weight at the fairlead, and the length that lies:
    l = sqrt(h^2 + 2 h H/w) hangs above the floor."""
    line = scene["connectors"]["line"]
    _, weights, anchor, fairlead, _ = line_of(scene)
    w, high, wide = np.sum(weights) / line["length"], fairlead[1] - anchor[1], fairlead[0] - anchor[0]

    def misses(h):
        hangs = np.sqrt(high**2 + 2 * high * h / w)
        return line["length"] - hangs + h / w * np.arcsinh(w * hangs / h) - wide

    h = root(misses, 1e-3 * w * wide, 10 * w * wide)
    return h, w * np.sqrt(high**2 + 2 * high * h / w), line["length"] - np.sqrt(high**2 + 2 * high * h / w)


def continuum(scene):
    """The place at four fifths of the length of an even line."""
    n, weights, anchor, _, floor = line_of(scene)
    h, _, lies = forces_of_even_line(scene)
    length, t = scene["connectors"]["line"]["length"], scene["duration"]
    size, above = h / np.sum(weights) * length, 0.8 * length - lies
    x, y = anchor[0] + lies + size * np.arcsinh(above / size), floor + np.hypot(size, above) - size
    return [(t, f"line.{4 * n // 5}.x", x, 1e-2), (t, f"line.{4 * n // 5}.y", y, 1e-2)]


def answer(scene):
    n, weights, anchor, fairlead, floor = line_of(scene)
    places, pressed, end = at_rest(scene)
    # Other route: all beads are in balance in space, with tensions that pull.
    x = in_space(places)
    forces = np.outer(weights, [0.0, -1.0, 0.0])
    for k, force in pressed.items():
        forces[k, 1] += force
    tensions, holds, left = tensions_at_rest(x, forces, (0, n))
    agree(left, 0, 1e-7 * np.sum(weights))
    assert min(tensions) > 0 and min(pressed.values()) >= 0
    agree(holds[n][:2], end, 1e-7 * np.sum(weights))
    h, v, lies = forces_of_even_line(scene)
    agree(holds[n][:2], [h, v], 2 * weights[0])
    if (scene["connectors"]["line"]["length"], *np.subtract(fairlead, anchor)) == (500.0, 400.0, 200.0):
        # MoorPy's own test row, of a line that stretches by 3e-8.
        agree(np.array([h, v, lies]) / [96643.42815934, 237751.75535996, 202.81030580], 1, 1e-6)
    t, whole = scene["duration"], np.sum(weights)
    rows = [(t, f"line.{k}.{axis}", x[k][j], 1e-4) for k in range(n + 1) for j, axis in enumerate("xy")]
    rows += [(t, f"line.{k}-{k + 1}.tension", tensions[k], 1e-6 * whole) for k in range(n)]
    rows += [(t, f"line.{n}.hold.{axis}", holds[n][j], 1e-6 * whole) for j, axis in enumerate("xy")]
    return rows + [(t, "seabed.contact.y", -sum(pressed.values()), 1e-5 * whole)]
