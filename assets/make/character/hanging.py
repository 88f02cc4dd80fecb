"""Weights of the cloth that hangs: it has chains of bones of its own, which the program simulates."""
import numpy as np

import skeleton
from sdf import mirrored, ramp
from skeleton import REST

SLIT = 0.86  # m, where the slits of the skirt end


def _give(dense, share, to):
    """Of all weights a share (n,) goes to bones: pairs of name and part of it (n,)."""
    dense = dense * (1 - share)[:, None]
    for bone, part in to:
        dense[:, REST.index(bone)] += share * part
    return dense


def tails(part, dense):
    """Below the knot the belt's tails hang on bones of their own."""
    p = part.points
    on_left = ramp(-0.006, 0.006, p[:, 0])
    for side, share in (("Left", on_left), ("Right", 1 - on_left)):
        knot, bend, _ = skeleton.TAILS[side]
        hangs = share * ramp(knot[1], knot[1] - 0.045, p[:, 1]) * (p[:, 2] > 0.10)
        lower = ramp(bend[1] + 0.065, bend[1] - 0.065, p[:, 1])
        dense = _give(dense, hangs, [(side + "Tail1", 1 - lower), (side + "Tail2", lower)])
    return dense


def _columns(angle, count):
    """How much of each of `count` columns is at angles (n,): linear between neighbours. (count, n)"""
    place = np.mod(angle / (2 * np.pi) * count - 0.5, count)
    away = np.abs(place[None, :] - np.arange(count)[:, None])
    return np.clip(1 - np.minimum(away, count - away), 0, 1)


def skirt(part, dense):
    """Below the belt the jacket hangs in columns of two bones each; below the slits its panels are apart."""
    p, count = part.points, skeleton.SKIRT_COLUMNS
    y, half_x, half_z, centre_z = np.array(skeleton.SKIRT)[::-1].T
    half_x, half_z, centre_z = (np.interp(p[:, 1], y, values) for values in (half_x, half_z, centre_z))
    angle = np.mod(np.arctan2((centre_z - p[:, 2]) / half_z, p[:, 0] / half_x), 2 * np.pi)
    half = 2 * np.pi / count / 2
    behind = angle < np.pi
    start = np.where(behind, 0, np.pi)  # of the panel: its corners go with its outer columns
    own = start + half + (angle - start) * (np.pi - 2 * half) / np.pi
    apart = ramp(SLIT + 0.03, SLIT, p[:, 1])
    columns = (1 - apart) * _columns(angle, count) + apart * _columns(own, count)
    top, bend = skeleton.SKIRT[0][0], skeleton.SKIRT[1][0]
    hangs = ramp(top, top - 0.06, p[:, 1]) * (np.abs(p[:, 0]) < 0.30)
    lower = ramp(bend + 0.06, bend - 0.06, p[:, 1])
    names = skeleton.skirt_columns()
    to = [(name + "1", column * (1 - lower)) for name, column in zip(names, columns)]
    return _give(dense, hangs, to + [(name + "2", column * lower) for name, column in zip(names, columns)])


def cuffs(part, dense):
    """The ends of the sleeves hang in columns of one bone each."""
    wrist, down, forward, across = skeleton.cuff_frame()
    q = mirrored(part.points) - wrist
    columns = _columns(np.arctan2(q @ across, q @ forward), skeleton.CUFF_COLUMNS)
    start, _ = skeleton.CUFF
    hangs = ramp(-start, -start + 0.08, q @ down) * (np.abs(part.points[:, 0]) > 0.35)
    for side, sign in skeleton.SIDES:
        names = [f"{side}Cuff{letter}1" for letter in skeleton.letters(skeleton.CUFF_COLUMNS)]
        dense = _give(dense, hangs * (sign * part.points[:, 0] > 0), list(zip(names, columns)))
    return dense


def without_cuffs(dense):
    """The same weights as if the sleeves ended on the fore arms."""
    dense = dense.copy()
    for side, _ in skeleton.SIDES:
        own = [k for k, name in enumerate(REST.names) if name.startswith(side + "Cuff")]
        dense[:, REST.index(side + "ForeArm")] += dense[:, own].sum(axis=1)
        dense[:, own] = 0
    return dense
