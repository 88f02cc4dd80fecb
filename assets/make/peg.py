"""A peg that catches a rope: a knob about the origin, on the end of a rod that runs back along -y."""
import numpy as np

from lathe import arc, revolve

KNOB, ROD, LENGTH = 0.020, 0.009, 3.0  # radii, and how far the rod runs: out of any room


def _knob():
    waist = np.arcsin(0.62)  # where the collar cuts the ball
    ball = arc((0.0, 0.0), KNOB, -waist, np.pi / 2, 24)
    r, y = ball[0]
    collar = [(ROD, y - 0.0100), (ROD + 0.0035, y - 0.0090), (ROD + 0.0035, y - 0.0030), (r, y)]
    return revolve("Knob", "Brass", collar + ball[1:], 40)


def _rod():
    return revolve("Rod", "Steel", [(0.0, -LENGTH), (ROD, -LENGTH), (ROD, -0.5 * KNOB), (0.0, -0.5 * KNOB)], 28)


def build():
    return [_knob(), _rod()]
