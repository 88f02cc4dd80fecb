import numpy as np
from answers import agree, frames, integrate, jacobi

VARIED = [{"bodies.box.spin": [1.0, 5.0, 2.0]}, {"bodies.box.shape.box.size": [0.2, 0.1, 0.35]}]


def product(p, q):
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]],
                           p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def answer(scene):
    box = scene["bodies"]["box"]
    a, b, c = box["shape"]["box"]["size"]
    inertia = box["mass"] / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    spin, times = np.array(box["spin"]), frames(scene, 6)

    def f(t, y):  # quaternion, spin in the body's axes
        w = y[4:]
        return np.concatenate([0.5 * product(y[:4], np.concatenate([[0], w])),
                               -np.cross(w, inertia * w) / inertia])

    y = integrate(f, np.concatenate([[1, 0, 0, 0], spin]), times)
    momentum, energy = inertia * spin, 0.5 * inertia @ spin**2
    rows = []
    for t, state in zip(times, y):
        q, w = state[:4], state[4:]
        turned = product(product(q, np.concatenate([[0], inertia * w])),
                         q * np.array([1, -1, -1, -1]))[1:]
        agree(turned, momentum, 1e-9)  # angular momentum stays in space
        world = product(product(q, np.concatenate([[0], w])), q * np.array([1, -1, -1, -1]))[1:]
        rows += [(t, f"box.q{axis}", value, 1e-5) for axis, value in zip("wxyz", q)]
        rows += [(t, f"box.w{axis}", value, 1e-4) for axis, value in zip("xyz", world)]
        rows += [(t, "kinetic_energy", energy, 1e-6 * energy)]
    # The second route: the period of the spin from Jacobi's functions, in the body's axes.
    order = np.argsort(inertia)
    i1, i2, i3 = inertia[order]
    m2, e2 = momentum @ momentum, 2 * energy
    if m2 > e2 * i2:
        rate = np.sqrt((i3 - i2) * (m2 - e2 * i1) / (i1 * i2 * i3))
        k2 = (i2 - i1) * (e2 * i3 - m2) / ((i3 - i2) * (m2 - e2 * i1))
        largest = np.sqrt((e2 * i3 - m2) / (i2 * (i3 - i2)))
    else:
        rate = np.sqrt((i1 - i2) * (m2 - e2 * i3) / (i1 * i2 * i3))
        k2 = (i2 - i3) * (e2 * i1 - m2) / ((i1 - i2) * (m2 - e2 * i3))
        largest = np.sqrt((e2 * i1 - m2) / (i2 * (i1 - i2)))
    middle = y[:, 4:][:, order[1]]
    start = spin[order[1]]
    # sn(u0) = start/largest; the sign of the rate follows from Euler's equation.
    def sn(u):
        return largest * jacobi(u, k2)[0]
    slope = f(0, np.concatenate([[1, 0, 0, 0], spin]))[4:][order[1]]
    from answers import elliptic_k, root
    quarter = elliptic_k(k2)
    u0 = root(lambda u: sn(u) - start, -quarter, quarter)
    turn = rate if slope > 0 else -rate
    agree([sn(u0 + turn * t) for t in times], middle, 1e-8)
    return rows
