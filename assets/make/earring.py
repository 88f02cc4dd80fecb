"""An earring's drop: jade in a brass cap.

A ball about the origin, drawn out upwards; at y = +0.0115, in the cap's top, the chain is attached.
"""
import numpy as np

from lathe import arc, revolve

RADIUS, TOP = 0.0070, 0.0115
_SHOULDER = np.radians(38)  # where the ball turns into the neck
_NECK, _NECK_TOP = 0.0021, 0.0088


def _stone():
    ball = arc((0.0, 0.0), RADIUS, -np.pi / 2, _SHOULDER, 22)
    r, y = ball[-1]
    t = np.linspace(0, 1, 9)[1:]
    # Leaves the ball along its tangent and ends upright.
    c, s = np.cos(_SHOULDER), np.sin(_SHOULDER)
    bend = (r - s * 0.0042, y + c * 0.0042)
    neck = [((1 - u) ** 2 * r + 2 * u * (1 - u) * bend[0] + u * u * _NECK, (1 - u) ** 2 * y + 2 * u * (1 - u) * bend[1] + u * u * _NECK_TOP) for u in t]
    return revolve("Stone", "Jade", ball + neck, 32)


def _cap():
    rim = [(_NECK, _NECK_TOP - 0.0012), (_NECK + 0.0007, _NECK_TOP - 0.0010), (_NECK + 0.0008, _NECK_TOP - 0.0003)]
    dome = [(_NECK + 0.0004, _NECK_TOP + 0.0004), (_NECK + 0.0001, _NECK_TOP + 0.0012), (0.0012, TOP - 0.0006), (0.0006, TOP - 0.0001), (0.0, TOP)]
    return revolve("Cap", "Brass", rim + dome, 24)


def drop():
    return [_stone(), _cap()]
