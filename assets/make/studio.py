"""A photographer's cove: a floor that bends up into a wall, lit as by one lamp over its middle.

The floor's top is y = 0 around the origin; the wall stands at z = -2.4. Cameras look from the open side, +z.
"""
import numpy as np

from mesh import Part

_WIDE, _FRONT, _BACK, _TOP, _BEND = 30.0, 12.0, -2.4, 20.0, 1.5  # m


def _profile():
    """From the front edge of the floor to the top of the wall: (y, z), and its normals."""
    angle = np.linspace(0, np.pi / 2, 25)
    floor = np.linspace(_FRONT, _BACK + _BEND, 66)[:-1]
    wall = _BEND + (_TOP - _BEND) * np.linspace(0, 1, 40)[1:] ** 1.7
    y = np.concatenate([0 * floor, _BEND * (1 - np.cos(angle)), wall])
    z = np.concatenate([floor, _BACK + _BEND * (1 - np.sin(angle)), 0 * wall + _BACK])
    bent = np.concatenate([0 * floor, angle, 0 * wall + np.pi / 2])
    return y, z, np.cos(bent), np.sin(bent)


def build():
    y, z, up, forward = _profile()
    share = np.linspace(-1, 1, 101)
    x = _WIDE * np.sign(share) * np.abs(share) ** 1.7
    rows, columns = len(y), len(x)
    points = np.stack([np.tile(x, rows), np.repeat(y, columns), np.repeat(z, columns)], axis=1)
    normals = np.stack([np.zeros(rows * columns), np.repeat(up, columns), np.repeat(forward, columns)], axis=1)
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    triangles = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    # The lamp's light falls off with the distance from its middle, on the floor and up the wall.
    away = np.sqrt((points[:, 0] / 2.6) ** 2 + (points[:, 1] / 2.4) ** 2 + (points[:, 2] / 3.4) ** 2)
    part = Part("Cove", "Backdrop", points, normals, triangles)
    part.colors = part.colors * (0.40 + 0.60 * np.exp(-0.5 * away**2))[:, None]
    return [part]
