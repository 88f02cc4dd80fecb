"""What moves the skin of the face and the cloth over it: brows, cheeks and jaw. All else is the head's."""
import numpy as np

from sdf import ramp
from skeleton import REST, SIDES, vec

_LIPS = 1.5897  # height of the line between the lips, m


def _brow(q):
    """The brow moves as one, the skin between it and the lid, the temple and the hood gives."""
    up = ramp(1.6610, 1.6730, q[:, 1]) * ramp(1.7130, 1.6860, q[:, 1])
    across = ramp(-0.004, 0.010, q[:, 0]) * ramp(0.070, 0.050, q[:, 0])
    return up * across * ramp(0.030, 0.055, q[:, 2])


def _cheek(q):
    """The corner of the mouth, which the mask hides, lifts the cheek and with it the mask's edge below the eye."""
    return 0.85 * ramp(1.6480, 1.6370, q[:, 1]) * ramp(1.580, 1.604, q[:, 1]) * ramp(0.006, 0.024, q[:, 0]) * ramp(0.025, 0.055, q[:, 2])


def _jaw(p):
    """The chin and the line of the jaw, the less the nearer to the ear and the throat."""
    ahead = ramp(-0.005, 0.060, p[:, 2])
    return ahead * ramp(_LIPS + 0.020, _LIPS - 0.012, p[:, 1]) * ramp(1.535, 1.552, p[:, 1])


def weigh(points, dense):
    """Takes of the head's weight what the face's own bones have."""
    dense = dense.copy()
    head = dense[:, REST.index("Head")].copy()
    shares = {"Jaw": _jaw(points)}
    for side, sign in SIDES:
        q = points * vec(sign, 1, 1)
        shares[side + "Brow"] = _brow(q)
        shares[side + "Mouth"] = _cheek(q)
    corners = np.clip(shares["LeftMouth"] + shares["RightMouth"], 0, 1)
    shares["Jaw"] *= 1 - 0.5 * corners
    total = sum(shares.values())
    scale = head / np.maximum(total, 1.0)
    for bone, share in shares.items():
        dense[:, REST.index(bone)] += share * scale
    dense[:, REST.index("Head")] -= total * scale
    return dense
