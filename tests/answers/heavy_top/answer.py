import numpy as np
from answers import agree, frames, gravity, integrate, places

VARIED = [{"bodies.top.spin": [51.96152422706632, 30.0, 0.0]}, {"bodies.top.mass": 5.0}]


def product(p, q):
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def answer(scene):
    top, fall, times = scene["bodies"]["top"], -gravity(scene)[1], frames(scene)
    m, size, h = top["mass"], top["shape"]["cylinder"], 0.1
    r = size["diameter"] / 2
    along = m * r * r / 2
    across = m * (3 * r * r + size["length"] ** 2) / 12 + m * h * h
    w3 = np.linalg.norm(top["spin"])
    lean = np.pi / 3
    # phi: round the vertical; its momentum A sin^2 phi' + C w3 cos stays.
    upright = along * w3 * np.cos(lean)

    def angles(t, s):
        a, da, _ = s
        round_ = (upright - along * w3 * np.cos(a)) / (across * np.sin(a) ** 2)
        return np.array([da, (across * round_**2 * np.sin(a) * np.cos(a) - along * w3 * round_ * np.sin(a)
                              + m * fall * h * np.sin(a)) / across, round_])

    s = integrate(angles, [lean, 0, 0], times)
    inertia = np.array([across, along, across])

    def euler(t, y):
        q, w = y[:4], y[4:]
        back = q * np.array([1, -1, -1, -1])
        weight = product(product(back, np.array([0, 0, -m * fall, 0])), q)[1:]
        torque = np.cross([0, h, 0], weight)
        return np.concatenate([0.5 * product(q, np.concatenate([[0], w])), (torque - np.cross(w, inertia * w)) / inertia])

    q0 = np.array(top["rotation"])
    y = integrate(euler, np.concatenate([q0, [0, w3, 0]]), times[:1])
    states = h * np.array([np.sin(s[:, 0]) * np.cos(s[:, 2]), np.cos(s[:, 0]), -np.sin(s[:, 0]) * np.sin(s[:, 2])]).T
    for q, at in zip(y[:, :4], states):
        agree(product(product(q, np.array([0, 0, h, 0])), q * np.array([1, -1, -1, -1]))[1:], at, 1e-7)
    return places(times, "top", states, 2e-5)
