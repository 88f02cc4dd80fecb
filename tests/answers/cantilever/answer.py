import numpy as np
from answers import agree, gravity, integrate, root

VARIED = [{"connectors.rod.bending_stiffness": 0.02, "connectors.rod.bending_damping": 0.004}, {"connectors.rod.particles": 17}]


def answer(scene):
    rod, fall = scene["connectors"]["rod"], -gravity(scene)[1]
    n, ei, length = rod["particles"] - 1, rod["bending_stiffness"], rod["length"]
    l, each = length / n, rod["mass"] / (n + 1)
    load = rod["to"].get("point_mass", 0.0)

    def slopes(first):  # from the moment at the clamp; the end's moment is zero
        angles = [2 * np.arctan(first / 2)]
        # balance about each knot: EI C/(s cos^2) terms, from the clamp outwards
        for k in range(1, n):
            last = angles[-1]
            bend = angles[0] if k == 1 else angles[-1] - angles[-2]
            s = l / 2 if k == 1 else l
            moment = ei / s * 2 * np.tan(bend / 2) / np.cos(bend / 2) ** 2
            moment += (each * (n - k + 1) + load) * fall * l * np.cos(last)
            turn = root(lambda b: ei / l * 2 * np.tan(b / 2) / np.cos(b / 2) ** 2 - moment, -2.5, 2.5)
            angles.append(last + turn)
        last = angles[-1] - angles[-2]
        rest = ei / l * 2 * np.tan(last / 2) / np.cos(last / 2) ** 2 + (each + load) * fall * l * np.cos(angles[-1])
        return np.array(angles), rest

    first = root(lambda c: slopes(c)[1], -8.0 / n, 0.0)
    angles = slopes(first)[0]
    x = l * np.cumsum(np.cos(angles))
    y = l * np.cumsum(np.sin(angles))
    # The continuous rod with weights at the same places: EI theta'' = (weight beyond) cos theta.
    def shoot(bend):
        z = np.array([0.0, bend, 0.0, 0.0])
        for k in range(n):
            shear = (each * (n - k) + load) * fall / ei
            z = integrate(lambda s, z: np.array([z[1], shear * np.cos(z[0]), np.cos(z[0]), np.sin(z[0])]),
                          z, [l], 0.0, 1e-9)[0]
        return z

    bend = root(lambda b: shoot(b)[1], -30.0 / length, 0.0)
    agree([x[-1], y[-1]], shoot(bend)[2:], 2 * length / n**2)
    t = scene["duration"]
    return [(t, f"rod.{k + 1}.{axis}", place[k], 2e-4 * length) for k in range(n) for axis, place in (("x", x), ("y", y))]
