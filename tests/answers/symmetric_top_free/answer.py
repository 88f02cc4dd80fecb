import numpy as np
from answers import agree, frames, integrate

VARIED = [{"bodies.stick.spin": [0.0, 3.0, 7.0]}, {"bodies.stick.shape.cylinder.length": 0.4}]


def product(p, q):
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]],
                           p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def turn(axis, angle):
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.asarray(axis)])


def answer(scene):
    stick, times = scene["bodies"]["stick"], frames(scene)
    size = stick["shape"]["cylinder"]
    r, mass = size["diameter"] / 2, stick["mass"]
    along, across = mass * r * r / 2, mass * (3 * r * r + size["length"] ** 2) / 12
    inertia, spin = np.array([across, along, across]), np.array(stick["spin"])
    momentum = inertia * spin
    rate = np.linalg.norm(momentum) / across
    own = spin[1] - momentum[1] / across

    def f(t, y):
        return np.concatenate([0.5 * product(y[:4], np.concatenate([[0], y[4:]])),
                               -np.cross(y[4:], inertia * y[4:]) / inertia])

    y = integrate(f, np.concatenate([[1, 0, 0, 0], spin]), times)
    rows = []
    for t, state in zip(times, y):
        q = product(turn(momentum / np.linalg.norm(momentum), rate * t), turn([0, 1, 0], own * t))
        agree(abs(q @ state[:4]), 1, 1e-12)
        rows += [(t, f"stick.q{axis}", value, 1e-6) for axis, value in zip("wxyz", state[:4])]
    return rows
