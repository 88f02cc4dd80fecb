import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"bodies.lower.mass": 2.0}, {"bodies.upper.shape.cylinder.diameter": 0.2}]


def answer(scene):
    g, times = gravity(scene), frames(scene)
    upper, lower = scene["bodies"]["upper"], scene["bodies"]["lower"]
    m, n, h, k = upper["mass"], lower["mass"], 0.25, 0.2
    i, j = [b["mass"] * (3 * (b["shape"]["cylinder"]["diameter"] / 2) ** 2 + b["shape"]["cylinder"]["length"] ** 2) / 12 for b in (upper, lower)]

    def lagrange(t, s):  # angles from below
        a, b, da, db = s
        cross = n * 2 * h * k
        matrix = [[i + m * h * h + 4 * n * h * h, cross * np.cos(a - b)], [cross * np.cos(a - b), j + n * k * k]]
        right = [-cross * db**2 * np.sin(a - b) + (m + 2 * n) * h * g[1] * np.sin(a),
                 cross * da**2 * np.sin(a - b) + n * k * g[1] * np.sin(b)]
        return np.concatenate([[da, db], np.linalg.solve(matrix, right)])

    def newton(t, s):  # the hinges' forces F (top) and G (middle, on the lower one) as unknowns
        a, b, da, db = s
        u, w = np.array([np.sin(a), -np.cos(a)]), np.array([np.sin(b), -np.cos(b)])
        du, dw = np.array([np.cos(a), np.sin(a)]), np.array([np.cos(b), np.sin(b)])
        # unknowns: a'', b'', Fx, Fy, Gx, Gy
        rows, right = np.zeros((6, 6)), np.zeros(6)
        for c in (0, 1):
            rows[c, 0], rows[c, 2 + c], rows[c, 4 + c] = m * h * du[c], -1, 1
            right[c] = m * g[c] + m * h * da**2 * u[c]
            rows[2 + c, 0], rows[2 + c, 1], rows[2 + c, 4 + c] = n * 2 * h * du[c], n * k * dw[c], -1
            right[2 + c] = n * g[c] + n * (2 * h * da**2 * u[c] + k * db**2 * w[c])
        turn = lambda arm: np.array([-arm[1], arm[0]])  # the torque of a force f: turn(arm) . f
        rows[4, 0] = i
        rows[4, 2:4], rows[4, 4:6] = -turn(-h * u), turn(h * u)
        rows[5, 1] = j
        rows[5, 4:6] = -turn(-k * w)
        solved = np.linalg.solve(rows, right)
        return np.array([da, db, solved[0], solved[1]])

    start = [np.pi / 2, 0, 0, 0]
    s = integrate(lagrange, start, times)
    agree(integrate(newton, start, times), s, 1e-7)
    rows = []
    for t, (a, b, da, db) in zip(times, s):
        u, w = np.array([np.sin(a), -np.cos(a), 0]), np.array([np.sin(b), -np.cos(b), 0])
        rows += places([t], "upper", [np.array([0, 1, 0]) + h * u], 2e-5, "xy")
        rows += places([t], "lower", [np.array([0, 1, 0]) + 2 * h * u + k * w], 2e-5, "xy")
        rows += [(t, "upper.wz", da, 1e-3), (t, "lower.wz", db, 1e-3)]
    return rows
