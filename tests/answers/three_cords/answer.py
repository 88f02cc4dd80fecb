import numpy as np
from answers import agree, gravity, unit

VARIED = [{"connectors.weight.to.point_mass": 0.1}, {"gravity": [0.0, -20.0, 0.0]}]


def answer(scene):
    c, fall = scene["connectors"], -gravity(scene)[1]
    left, right, weight = c["left"], c["right"], c["weight"]
    knot = np.array(left["start"]["points"][1])
    ways = [unit(np.array(left["from"]["fixed"]) - knot), unit(np.array(right["to"]["fixed"]) - knot)]
    hung = weight["to"]["point_mass"] + weight["mass"]
    load = (hung + left["mass"] / 2 + right["mass"] / 2) * fall
    tensions = np.linalg.solve(np.array(ways).T[:2], [0, load])
    # The second route: the sine rule (Lami).
    a, b = np.arctan2(-ways[0][0], ways[0][1]), np.arctan2(ways[1][0], ways[1][1])
    agree(tensions, load * np.array([np.sin(b), np.sin(a)]) / np.sin(a + b), 1e-9)
    t, tolerance = scene["duration"], 1e-5 * load
    rows = [(t, "left.0-1.tension", tensions[0], tolerance), (t, "right.0-1.tension", tensions[1], tolerance),
            (t, "weight.0-1.tension", (hung - weight["mass"] / 3) * fall, tolerance)]
    return rows + [(t, "left.1.x", knot[0], 1e-6), (t, "left.1.y", knot[1], 1e-6)]
