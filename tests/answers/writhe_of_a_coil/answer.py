import numpy as np
from answers import agree, quadrature

VARIED = [{"connectors.coil.mass": 9.0}]


def solid_angle(a, b, c, d):
    """Of the directions from which segment ab is seen to cross cd, with its sign."""
    r12, r34, r13, r14, r23, r24 = b - a, d - c, c - a, d - a, c - b, d - b
    n = [np.cross(r13, r14), np.cross(r14, r24), np.cross(r24, r23), np.cross(r23, r13)]
    size = [np.linalg.norm(k) for k in n]
    if min(size) < 1e-12:
        return 0.0
    n = [k / s for k, s in zip(n, size)]
    angle = sum(np.arcsin(np.clip(n[k] @ n[(k + 1) % 4], -1, 1)) for k in range(4))
    return angle * np.sign(np.cross(r34, r12) @ r13)


def double_integral(a, b, c, d):
    def inner(s):
        x = a + s * (b - a)
        return quadrature(lambda u: np.cross(b - a, d - c) @ (x - (c + u * (d - c))) / np.linalg.norm(x - (c + u * (d - c))) ** 3, 0, 1, 12)
    return quadrature(inner, 0, 1, 12)


def answer(scene):
    x = np.array(scene["connectors"]["coil"]["start"]["points"])
    n, writhe, other = len(x) - 1, 0.0, 0.0
    for i in range(n):
        for j in range(i + 2, n):
            writhe += solid_angle(x[i], x[i + 1], x[j], x[j + 1]) / (2 * np.pi)
            other += double_integral(x[i], x[i + 1], x[j], x[j + 1]) / (2 * np.pi)
    agree(writhe, other, 1e-4)
    return [(t, "coil.writhe", writhe, 1e-6) for t in (0.0, 0.2, 0.4)]
