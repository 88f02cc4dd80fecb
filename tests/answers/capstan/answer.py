import numpy as np
from answers import agree, gravity

VARIED = [{"connectors.rope.to.point_mass": 1.3}, {"obstacles.post.friction": 0.5, "connectors.rope.to.point_mass": 2.3},
          {"connectors.rope.from.point_mass": 1.0}]
HANGS = 2  # links on either side


def prepared(scene):
    """The rope lies on the post, whose circle of beads its chords are of; HANGS links hang on either side."""
    rope, n = scene["connectors"]["rope"], scene["connectors"]["rope"]["particles"] - 1
    l, arc = rope["length"] / n, n - 2 * HANGS
    r = l / (2 * np.sin(np.pi / (2 * arc)))
    scene["obstacles"]["post"]["shape"]["cylinder"]["diameter"] = float(2 * (r - rope["radius"]))
    points = [[-r, -l * (HANGS - k), 0.0] for k in range(HANGS)]
    points += [[-r * np.cos(np.pi * k / arc), r * np.sin(np.pi * k / arc), 0.0] for k in range(arc + 1)]
    points += [[r, -l * (k + 1), 0.0] for k in range(HANGS)]
    rope["start"] = {"points": np.array(points).tolist()}
    return scene


def answer(scene):
    rope, mu, fall, t = scene["connectors"]["rope"], scene["obstacles"]["post"]["friction"], -gravity(scene)[1], scene["duration"]
    n = rope["particles"] - 1
    arc, bead = n - 2 * HANGS, rope["mass"] / (n + 1) * fall
    half = np.pi / arc / 2
    low, high = (rope[end]["point_mass"] * fall + bead * HANGS for end in ("from", "to"))
    tension, ratio = low, 1.0
    for k in range(arc + 1):
        # At a bead, along and across its tangent: T' cos b - T cos a + w_t = mu (T sin a + T' sin b + w_n).
        a, b = (0 if k == 0 else half), (0 if k == arc else half)
        angle = np.pi * (1 - k / arc)
        gain = (np.cos(a) + mu * np.sin(a)) / (np.cos(b) - mu * np.sin(b))
        tension = tension * gain + bead * (mu * np.sin(angle) - np.cos(angle)) / (np.cos(b) - mu * np.sin(b))
        ratio *= gain
    agree(np.log(ratio), mu * np.pi, 0.02 * mu * np.pi)
    assert abs(high / tension - 1) > 1e-3 and high > low / ratio
    whole = rope["mass"] * fall + (rope["from"]["point_mass"] + rope["to"]["point_mass"]) * fall
    x, rows = np.array(rope["start"]["points"]), []
    if high < tension:
        rows += [(t, f"rope.{k}.{axis}", x[k][j], 1e-8) for k in range(0, n + 1, 4) for j, axis in enumerate("xy")]
        return rows + [(t, "post.contact.y", -whole, 1e-4 * whole), (t, "post.contact.x", 0.0, 5e-5 * whole)]
    way = (high - tension) / (high + ratio * low) * fall * t * t / 2
    return [(t, f"rope.{n}.y", x[n][1] - way, 0.1 * way), (t, "rope.0.y", x[0][1] + way, 0.1 * way)]
