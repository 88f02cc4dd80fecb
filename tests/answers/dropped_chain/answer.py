import numpy as np
from answers import agree, gravity, integrate, frames

VARIED = [{"gravity": [1.0, -2.0, 3.0]}, {"connectors.chain.mass": 20.0}]


def answer(scene):
    chain, g, times = scene["connectors"]["chain"], gravity(scene), frames(scene, 2)
    n = chain["particles"]
    corners = np.array(chain["start"]["points"])
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    along = np.linspace(0, lengths[-1], n)
    points = np.array([np.interp(along, lengths, corners[:, j]) for j in range(3)]).T
    rows = []
    for t in times:
        agree(integrate(lambda s, y: np.concatenate([y[3:], g]), np.zeros(6), [t])[0][:3], g * t * t / 2, 1e-12)
        rows += [(t, f"chain.{k}.{axis}", points[k][j] + g[j] * t * t / 2, 1e-6) for k in range(n) for j, axis in enumerate("xyz")]
        rows += [(t, f"chain.{k}-{k + 1}.tension", 0.0, 1e-6 * chain["mass"] * np.linalg.norm(g)) for k in range(n - 1)]
    return rows
