import numpy as np
from answers import agree, between_keys, frames, gravity, integrate

VARIED = [{"bodies.ball.mass": 4.0}, {"obstacles.floor.friction": 0.9},
          {"paths.moves.keys": [{"t": 0.0, "position": [0.0, 0.0, 0.0]}, {"t": 1.0, "position": [-0.5, 0.0, 0.0]}]}]


def answer(scene):
    ball, floor, fall, times = scene["bodies"]["ball"], scene["obstacles"]["floor"], -gravity(scene)[1], frames(scene, 5)
    keys, r, m = scene["paths"]["moves"]["keys"], ball["shape"]["sphere"]["diameter"] / 2, ball["mass"]
    moves = lambda t: [value[0] for value in between_keys(keys, "position", t)]
    assert max(abs(moves(t)[2]) for t in np.linspace(0, 1, 99)) * 2 / 7 < 0.9 * floor["friction"] * fall

    def f(t, s):  # by the force F = m x'' that turns the ball as well: 2/5 m r^2 w' = F r, x' + r w = V
        force = moves(t)[2] / (1 / m + r * r / (0.4 * m * r * r))
        return np.array([s[1], force / m, force * r / (0.4 * m * r * r)])

    rows = []
    for t, state in zip(times, integrate(f, [0.0, 0.0, 0.0], times)):
        x, v, a = moves(t)
        agree(state, [2 / 7 * x, 2 / 7 * v, 5 / 7 * v / r], 1e-9)
        rows += [(t, "ball.x", 2 / 7 * x, 1e-6), (t, "ball.vx", 2 / 7 * v, 1e-5), (t, "ball.wz", 5 / 7 * v / r, 1e-4)]
        if t < times[-1]:
            rows.append((t, "floor.contact.x", -m * 2 / 7 * a, 1e-3 * m * fall))
    return rows
