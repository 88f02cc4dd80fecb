import numpy as np
from answers import agree, frames, gravity, integrate, Particles

VARIED = [{"connectors.rod.bending_stiffness": 0.3}, {"connectors.rod.particles": 4}]


def answer(scene):
    rod, g, times = scene["connectors"]["rod"], gravity(scene), frames(scene)
    n, ei = rod["particles"] - 1, rod["bending_stiffness"]
    l, masses = rod["length"] / n, np.full(n, rod["mass"] / (n + 1))
    masses[-1] += rod["to"]["point_mass"]
    below = np.cumsum(masses[::-1])[::-1]
    shared = np.minimum.outer(below, below) * l * l
    s = np.full(n, l)
    s[0] = l / 2

    def f(t, y):  # angles above level, and their rates
        a, da = y[:n], y[n:]
        apart = a[:, None] - a[None, :]
        bend = np.diff(a, prepend=0.0)
        moment = ei / s * 2 * np.tan(bend / 2) / np.cos(bend / 2) ** 2
        right = -(shared * np.sin(apart)) @ da**2 + below * l * g[1] * np.cos(a) - moment + np.append(moment[1:], 0)
        return np.concatenate([da, np.linalg.solve(shared * np.cos(apart), right)])

    a = integrate(f, np.zeros(2 * n), times)[:, :n]
    x = np.array([l * np.array([np.cumsum(np.cos(k)), np.cumsum(np.sin(k)), 0 * k]).T for k in a])
    heavy, weight = np.append(np.inf, masses), np.append(0, masses)

    def force(t, at, v):
        total = weight[:, None] * g
        edges = np.vstack([[[l, 0, 0]], np.diff(at, axis=0)])
        ways = edges / np.linalg.norm(edges, axis=1)[:, None]
        for k in range(n):  # the bend before link k; dE/d(way) = -4 EI/s way/(1 + c)^2
            u, w = ways[k], ways[k + 1]
            c = u @ w
            slope = 4 * ei / s[k] / (1 + c) ** 2
            along_w = slope * (u - c * w) / l
            total[k + 1] += along_w
            total[k] -= along_w
            if k > 0:
                along_u = slope * (w - c * u) / l
                total[k] += along_u
                total[k - 1] -= along_u
        return total

    system = Particles(l * np.outer(np.arange(n + 1), [1, 0, 0]), heavy, [(k, k + 1) for k in range(n)], force)
    agree(system.run(times[:2])[0][:, 1:], x[:2], 1e-6)
    return [(t, f"rod.{k + 1}.{axis}", x[i, k, j], 2e-5) for i, t in enumerate(times) for k in range(n) for j, axis in enumerate("xy")]
