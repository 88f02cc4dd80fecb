import numpy as np
from answers import agree, gravity, integrate, root

VARIED = [
    {"connectors.rod.to.point_mass": 0.01},
    {"connectors.rod.to.point_mass": 0.05},
    {"connectors.rod.to.point_mass": 0.1},
]

LINKS = [5, 10, 20, 40]


def tip(scene):
    """Where the end of the continuous rod with its own weight is, by shooting."""
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    ei, length, load = rod["bending_stiffness"], rod["length"], rod["to"]["point_mass"]

    def shoot(bend):
        def f(s, z):
            beyond = load + rod["mass"] * (1 - s / length)
            return np.array([z[1], beyond * fall / ei * np.cos(z[0]), np.cos(z[0]), np.sin(z[0])])
        return integrate(f, [0.0, bend, 0.0, 0.0], [length], 0.0, 1e-10)[0]

    return shoot(root(lambda b: shoot(b)[1], -(load + rod["mass"]) * fall / ei * length, 0.0))[2:]


def continuum(scene):
    end, rod = scene["connectors"]["rod"]["particles"] - 1, tip(scene)
    return [(scene["duration"], f"rod.{end}.{axis}", place, 1e-5) for axis, place in zip("xy", rod)]


def answer(scene):
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    n, ei, length = rod["particles"] - 1, rod["bending_stiffness"], rod["length"]
    l, each, load = length / n, rod["mass"] / (n + 1), rod["to"]["point_mass"]

    def moment(bend, s):
        return ei / s * 2 * np.tan(bend / 2) / np.cos(bend / 2) ** 2

    # Newton's method on the angles of the links: the moments of both bends and the weights balance.
    def rest(a):
        bend = np.diff(a, prepend=0.0)
        m = moment(bend, np.append(l / 2, np.full(n - 1, l)))
        weights = each * np.arange(n, 0, -1) + load
        return m - np.append(m[1:], 0.0) + weights * fall * l * np.cos(a)

    a = np.linspace(-0.1, -0.5, n)
    for _ in range(200):
        value, h = rest(a), 1e-7
        slope = np.array([(rest(a + h * e) - value) / h for e in np.eye(n)]).T
        step = np.linalg.solve(slope, -value)
        a = a + step * min(1.0, 0.3 / np.max(np.abs(step)))
    agree(rest(a), 0 * a, 1e-9)
    x, y = l * np.cumsum(np.cos(a)), l * np.cumsum(np.sin(a))

    agree([x[-1], y[-1]], tip(scene), length / n**2)
    t = scene["duration"]
    return [(t, f"rod.{k + 1}.{axis}", place[k], 2e-6 * length)
            for k in range(n) for axis, place in (("x", x), ("y", y))]
