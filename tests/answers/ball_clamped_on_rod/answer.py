import numpy as np
from answers import beam_stiffness, frames, swings

VARIED = [{"connectors.rod.bending_stiffness": 2.0}, {"bodies.ball.mass": 0.15}, {"connectors.rod.particles": 4}]


def answer(scene):
    rod, ball, times = scene["connectors"]["rod"], scene["bodies"]["ball"], frames(scene, 5)
    n, m, r = rod["particles"] - 1, ball["mass"], ball["shape"]["sphere"]["diameter"] / 2
    l, each = rod["length"] / n, rod["mass"] / (n + 1)
    # From the places of the particles and the clamp's angle to those of the ball: y_n = Y - r phi.
    turn = np.zeros((n + 2, n + 1))
    turn[1:n, : n - 1] = np.eye(n - 1)
    turn[n, n - 1:] = [1, -r]
    turn[n + 1, n] = 1
    stiffness = turn.T @ beam_stiffness(n, l, rod["bending_stiffness"], True, True) @ turn
    mass = turn.T @ np.diag([0.0] + [each] * n + [0.0]) @ turn + np.diag([0.0] * (n - 1) + [m, 0.4 * m * r * r])
    # The end's particle has the speed of the ball's point, the rest of the rod none.
    speed = np.zeros(n + 1)
    speed[n - 1] = ball["velocity"][1]
    rows, states = [], swings(mass, stiffness, np.zeros(n + 1), speed, times)
    size = np.max(np.abs(states))
    for t, u in zip(times, states):
        rows += [(t, f"rod.{k + 1}.y", u[k], 0.01 * size) for k in range(n - 1)]
        rows += [(t, "ball.y", u[n - 1], 0.01 * size), (t, "ball.qz", np.sin(u[n] / 2), 0.02 * abs(size / r))]
    return rows
