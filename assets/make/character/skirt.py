"""The jacket below the belt: a panel behind and two in front, the left one over the right one, slit at the sides."""
import numpy as np

from character import jacket_shape, lapels, sheet
from character.hanging import SLIT
from skeleton import SKIRT_POWER

HEM = 0.735  # height
TOP = 1.040  # under the belt
_THICK = 0.0042
_OVER = 0.0052  # by how much the left panel lies over the right one
_ROUND = np.linspace(0, 2 * np.pi, 1441)


def around(angle, y):
    """Points of the smooth skirt; the angle is counted from the left side to the back."""
    a, b, c = jacket_shape.section(y)
    cos, sin = np.cos(angle), np.sin(angle)
    r = (np.abs(cos) ** SKIRT_POWER + np.abs(sin) ** SKIRT_POWER) ** (-1 / SKIRT_POWER)
    return np.stack([r * cos * a, y + 0 * r, c - r * sin * b], axis=-1)


def _angle_at(x, y):
    """Of the front's point with that x."""
    a, _, _ = jacket_shape.section(y)
    s = x / a
    tangent = (np.maximum(1 - np.abs(s) ** SKIRT_POWER, 1e-9)) ** (1 / SKIRT_POWER) / np.abs(s)
    angle = np.arctan(tangent)
    return np.where(s > 0, 2 * np.pi - angle, np.pi + angle)


def _gathers():
    """Folds that fall from the belt: angle, height (m), half width (rad) at the hem, and how they lean (rad)."""
    rng = np.random.default_rng(5)
    angles = np.arange(15) * 2 * np.pi / 15 + rng.uniform(-0.11, 0.11, 15)
    return np.column_stack([angles, rng.uniform(0.010, 0.022, 15), rng.uniform(0.075, 0.115, 15), rng.uniform(-0.10, 0.10, 15)])


_GATHERS = _gathers()


def folds(angle, y):
    """Heights over the smooth skirt, m: narrow under the belt, wide and high at the hem, each from its own gather."""
    down = np.clip((jacket_shape.BELT - 0.02 - y) / (jacket_shape.BELT - 0.02 - HEM), 0, 1)
    h = np.zeros(np.broadcast(angle, y).shape)
    for k, (at, high, width, lean) in enumerate(_GATHERS):
        away = np.mod(angle - at - lean * down + np.pi, 2 * np.pi) - np.pi
        x = away / (width * (0.45 + 0.55 * down))
        grown = down**1.2 if k % 3 else np.minimum(1.4 * down, 1) ** 1.1 * (1 - 0.45 * down)  # some are of the belt's pull alone
        h += high * grown * (np.exp(-np.abs(x) ** 1.7) - 0.30 * np.exp(-((x / 2.0) ** 2)))
    for at in np.arange(34) * 2 * np.pi / 34:  # short ones right below the belt
        x = (np.mod(angle - at - 0.07 * np.sin(9 * at) + np.pi, 2 * np.pi) - np.pi) / 0.050
        h += 0.0026 * (0.5 + 0.5 * np.sin(5.3 * at)) * np.exp(-(x**2)) * np.exp(-(((down - 0.09) / 0.09) ** 2))
    return np.maximum(h, -0.0008)  # legs are beneath


def _panel(name, count, first, last, edge, over=None):
    """A panel between angles that change over y; `edge`: distances across the last edge's band."""
    heights = HEM + sheet.steps(TOP - HEM, 10, last=np.array([0.0]))[::-1]
    rows, plain, tints = [], [], []
    for y in heights:
        angle = _ROUND[0] + np.linspace(first(y), last(y), 700)
        line = around(angle, np.full(700, y))
        way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = sheet.steps(way[-1], count, last=edge)
        angles = np.interp(at, way, angle)
        point = around(angles, np.full(len(angles), y))
        ahead, behind = around(angles + 1e-3, np.full(len(angles), y)), around(angles - 1e-3, np.full(len(angles), y))
        out = np.cross((0, 1, 0), ahead - behind)
        out /= -np.linalg.norm(out, axis=1, keepdims=True)
        out *= np.sign(np.sum(out * (point - [0, y, -0.01]), axis=1, keepdims=True))
        to_hem, to_side, to_edge = y - HEM, at, way[-1] - at
        fold, height = folds(angles, np.full(len(angles), y)), np.zeros(len(at))
        tint = np.clip(1 + 26 * (fold - 0.002), 0.72, 1.20)  # hollows keep their dye, ridges lose it
        for h, t, part in [(*sheet.hem(np.full(len(at), to_hem)), 1.0), (*sheet.hem(to_side), float(np.interp(y, [SLIT, SLIT + 0.02], [1, 0])))]:
            height, tint = height + h * part, tint * (1 - part + t * part)
        if over is None:
            h, t = sheet.hem(to_edge)
            part = float(np.interp(y, [SLIT, SLIT + 0.02], [1, 0])) if name == "SkirtBack" else 1.0
            height, tint = height + h * part, tint * (1 - part + t * part)
        else:
            h, t = lapels.band(to_edge)
            flat = np.interp(to_edge, [0.040, 0.075], [0.25, 1])  # the band is stiff
            fold, height = fold * flat + over(point), height + h
            tint = tint * t
        free = 1 - 0.9 * np.exp(-(((y - jacket_shape.BELT) / 0.024) ** 4))  # of the belt that presses it
        rows.append(point + out * ((fold + height) * free)[:, None])
        plain.append(point + out * (fold * free)[:, None])
        tints.append(tint * (1 - 0.25 * np.exp(-(((y - jacket_shape.BELT + 0.03) / 0.02) ** 2))))
    upwards = -1 if last(HEM) > first(HEM) else 1  # so that the outside is outside

    def grid(rows):
        return np.swapaxes(np.array(rows)[::upwards], 0, 1)

    return sheet.slab(name, "Gi", grid(rows), _THICK, grid(tints), plain=grid(plain))


def panels():
    """(part, the points of its outside) of each."""
    def apart(y):  # half the slit, rad; above it the panels overlap in a seam
        return 0.004 + 0.10 * max(SLIT - y, 0) if y < SLIT else -0.012 * min((y - SLIT) / 0.02, 1)

    def left_edge(y):
        return float(_angle_at(jacket_shape.lapel_centre(y) - jacket_shape.LAPEL, y))

    def right_edge(y):
        return float(_angle_at(jacket_shape.lapel_centre(y) + 0.075, y))

    def over(p):
        reach = p[:, 0] - (jacket_shape.lapel_centre(p[:, 1]) + 0.075)
        return _OVER * np.interp(reach, [0.0, 0.030], [1, 0])

    whole = 2 * np.pi
    return [
        _panel("SkirtBack", 30, apart, lambda y: np.pi - apart(y), sheet.STEPS),
        _panel("SkirtRight", 20, lambda y: np.pi + apart(y), right_edge, sheet.STEPS),
        _panel("SkirtLeft", 19, lambda y: whole - apart(y), left_edge, lapels.ACROSS, over),
    ]
