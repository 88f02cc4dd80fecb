import numpy as np
from answers import agree, frames, gravity, integrate, Particles

VARIED = [{"connectors.chain.to": {"free": True}}, {"connectors.chain.particles": 11}]


def answer(scene):
    chain, g, times = scene["connectors"]["chain"], gravity(scene), frames(scene)
    n, pivot = chain["particles"], np.array(chain["from"]["fixed"])
    l, masses = chain["length"] / (n - 1), np.full(n - 1, chain["mass"] / n)
    masses[-1] += chain["to"].get("point_mass", 0)
    below = np.cumsum(masses[::-1])[::-1]  # what hangs on each link
    shared = np.minimum.outer(below, below) * l

    def f(t, s):  # angles from below, and their rates
        a, da = s[:n - 1], s[n - 1:]
        apart = a[:, None] - a[None, :]
        right = -(shared * np.sin(apart)) @ da**2 + below * g[1] * np.sin(a)
        return np.concatenate([da, np.linalg.solve(shared * np.cos(apart), right)])

    s = integrate(f, np.concatenate([np.full(n - 1, np.pi / 2), np.zeros(n - 1)]), times)[:, :n - 1]
    x = np.array([pivot + l * np.array([np.cumsum(np.sin(a)), -np.cumsum(np.cos(a)), 0 * a]).T for a in s])
    weights = np.concatenate([[0], masses])
    system = Particles([pivot + [l * k, 0, 0] for k in range(n)], np.concatenate([[np.inf], masses]),
                       [(k, k + 1) for k in range(n - 1)], lambda t, x, v: weights[:, None] * g)
    agree(system.run(times)[0][:, 1:], x, 1e-6)
    return [(t, f"chain.{k + 1}.{axis}", x[i, k, j], 2e-5)
            for i, t in enumerate(times) for k in range(n - 1) for j, axis in enumerate("xy")]
