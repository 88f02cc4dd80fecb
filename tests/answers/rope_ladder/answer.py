import numpy as np
from answers import agree, gravity

VARIED = [{"nets.ladder.mass": 4.0}, {"nets.ladder.cells": [1, 6]}]


def answer(scene):
    ladder, t = scene["nets"]["ladder"], scene["duration"]
    weight = ladder["mass"] * -gravity(scene)[1]
    # The second route: moments about one corner; the centre of mass is in the middle.
    wide = ladder["size"][0]
    agree(weight * wide / 2 / wide, weight / 2, 1e-12)
    rows = [(t, f"ladder#{k}.0.hold.y", weight / 2, 2e-5 * weight) for k in (1, 2)]
    return rows + [(t, "kinetic_energy", 0.0, 1e-10), (t, "ladder#1.1.x", 0.0, 1e-7)]
