import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"bodies.stick.mass": 3.0}, {"connectors.cord.mass": 1.0}]


def answer(scene):
    stick, cord, g, times = scene["bodies"]["stick"], scene["connectors"]["cord"], gravity(scene), frames(scene)
    m, size, h, l, bead = stick["mass"], stick["shape"]["cylinder"], 0.25, cord["length"], cord["mass"] / 2
    inertia = m * (3 * (size["diameter"] / 2) ** 2 + size["length"] ** 2) / 12
    way = np.array(cord["start"]["direction"])

    def lagrange(t, s):
        a, b, da, db = s
        cross = m * l * h
        matrix = [[(m + bead) * l * l, cross * np.cos(a - b)], [cross * np.cos(a - b), inertia + m * h * h]]
        right = [-cross * db**2 * np.sin(a - b) + (m + bead) * l * g[1] * np.sin(a),
                 cross * da**2 * np.sin(a - b) + m * h * g[1] * np.sin(b)]
        return np.concatenate([[da, db], np.linalg.solve(matrix, right)])

    def newton(t, s):  # unknowns: centre's acceleration, spin's, pull T, and the force of the bead on the stick
        a, b, da, db = s
        u, w = np.array([np.sin(a), -np.cos(a)]), np.array([np.sin(b), -np.cos(b)])
        dw = np.array([np.cos(b), np.sin(b)])
        rows, right = np.zeros((7, 7)), np.zeros(7)  # end's a (2), b'', T, F (2), a'' by geometry
        du = np.array([np.cos(a), np.sin(a)])
        for c in (0, 1):
            rows[c, c], rows[c, 3], rows[c, 4 + c] = bead, u[c], 1  # the bead: weight, pull, -F
            right[c] = bead * g[c]
            rows[2 + c, c], rows[2 + c, 2], rows[2 + c, 4 + c] = m, m * h * dw[c], -1
            right[2 + c] = m * (g[c] + h * db**2 * w[c])
            rows[5 + c, c], rows[5 + c, 6] = 1, -l * du[c]
            right[5 + c] = -l * da**2 * u[c]
        arm = -h * w
        rows[4, 2], rows[4, 4], rows[4, 5] = inertia, arm[1], -arm[0]
        x = np.linalg.solve(rows, right)
        return np.array([da, db, x[6], x[2]])

    start = [np.arctan2(way[0], -way[1]), 0, 0, 0]
    s = integrate(lagrange, start, times)
    agree(integrate(newton, start, times), s, 1e-7)
    rows = []
    for t, (a, b, da, db) in zip(times, s):
        end = np.array([0, 1, 0]) + l * np.array([np.sin(a), -np.cos(a), 0])
        rows += places([t], "stick", [end + h * np.array([np.sin(b), -np.cos(b), 0])], 2e-5, "xy")
        rows += [(t, "stick.wz", db, 1e-3)]
    return rows
