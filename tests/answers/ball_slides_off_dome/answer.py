import numpy as np
from answers import agree, event, gravity, integrate, quadrature

VARIED = [{"bodies.ball.mass": 3.0}, {"bodies.ball.position": [0.44, 0.33, 0.0]}]


def prepared(scene):
    """The ball touches the dome."""
    place = np.array(scene["bodies"]["ball"]["position"])
    r = (scene["bodies"]["ball"]["shape"]["sphere"]["diameter"] + scene["obstacles"]["dome"]["shape"]["sphere"]["diameter"]) / 2
    scene["bodies"]["ball"]["position"] = (place * r / np.linalg.norm(place)).tolist()
    return scene


def answer(scene):
    ball, fall, end = scene["bodies"]["ball"], -gravity(scene)[1], scene["duration"]
    r = (ball["shape"]["sphere"]["diameter"] + scene["obstacles"]["dome"]["shape"]["sphere"]["diameter"]) / 2
    a0 = np.arctan2(*ball["position"][:2])
    leaves = np.arccos(2 / 3 * np.cos(a0))
    f = lambda t, s: np.array([s[1], fall / r * np.sin(s[0])])
    # What the dome bears: m (g cos a - r w^2).
    t1, state = event(f, np.array([a0, 0.0]), 0.0, lambda t, s: fall * np.cos(s[0]) - r * s[1] ** 2, 0.05, end)
    agree(state[0], leaves, 1e-7)
    agree(r * state[1] ** 2, 2 * fall * (np.cos(a0) - np.cos(leaves)), 1e-7)
    rows = []
    for t in (0.3 * t1, 0.6 * t1, 0.9 * t1):
        a = integrate(f, [a0, 0.0], [t])[0][0]
        rows += [(t, "ball.x", r * np.sin(a), 2e-5), (t, "ball.y", r * np.cos(a), 2e-5)]
    v = r * state[1] * np.array([np.cos(leaves), -np.sin(leaves)])
    for share in (0.3, 0.7, 1.0):
        s = share * (end - t1)
        rows += [(t1 + s, "ball.x", r * np.sin(leaves) + v[0] * s, 2e-5), (t1 + s, "ball.y", r * np.cos(leaves) + v[1] * s - fall * s * s / 2, 2e-5)]
    return rows
