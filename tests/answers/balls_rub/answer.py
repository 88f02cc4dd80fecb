import numpy as np
from answers import agree

VARIED = [{"touching.balls.friction": 0.6, "touching.balls.static_friction": 0.6}, {"touching.balls.restitution": 0.0, "bodies.comes.spin": [0.0, 0.0, -50.0]}]
DRAWN = VARIED[1:]


def answer(scene):
    comes, pair, t = scene["bodies"]["comes"], scene["touching"]["balls"], scene["duration"]
    m, r, v, spin = comes["mass"], comes["shape"]["sphere"]["diameter"] / 2, comes["velocity"][0], comes["spin"][2]
    push = (1 + pair["restitution"]) * m * v / 2
    sticks = m * r * abs(spin) / 7
    rub = np.sign(spin) * (sticks if sticks <= pair["static_friction"] * push else pair["friction"] * push)
    inertia = 0.4 * m * r * r
    one, other = np.array([v - push / m, -rub / m, spin - r * rub / inertia]), np.array([push / m, rub / m, -r * rub / inertia])
    # Angular momentum about the point where they touch, of each, and what passes there after it.
    agree(inertia * one[2] - m * r * one[1], inertia * spin, 1e-12)
    agree(inertia * other[2] + m * r * other[1], 0, 1e-12)
    slips = (one[1] + r * one[2]) - (other[1] - r * other[2])
    assert abs(slips) < 1e-12 or abs(rub) < m * r * abs(spin) / 7 and slips * spin > 0
    rows = []
    for name, after in (("comes", one), ("waits", other)):
        rows += [(t, f"{name}.vx", after[0], 1e-6), (t, f"{name}.vy", after[1], 1e-4), (t, f"{name}.wz", after[2], 1e-2)]
    return rows
