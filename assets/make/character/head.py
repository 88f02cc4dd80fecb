"""The head's skin: skull, brows, nose and eyelids."""
import numpy as np

from sdf import ellipsoid, intersect, limb, mirrored, ramp, sphere, subtract, tube, union, within
from skeleton import EYE, vec

EYE_RADIUS = 0.0140
_LID = 0.0026
_SLIT = 0.0158  # half width of the opening
UPPER, LOWER = 0.0053, 0.0052  # how far it reaches up and down in its middle
LID_SHADE = (0.70, 0.63, 0.61)  # of the skin of the upper lids


def opening(q):
    """Distance (about) to the opening between the lids, seen from the front; negative inside."""
    x = q[:, 0] - EYE[0]
    y = q[:, 1] - EYE[1] - 0.05 * x  # the outer corner is a little higher
    u = np.clip(x / _SLIT, -1, 1)
    upper = UPPER * (1 - u * u) ** 0.60
    lower = LOWER * (1 - u * u) ** 0.75
    d = np.where(y > 0, y - upper, -lower - y)
    return np.where(np.abs(x) > _SLIT, np.maximum(d, np.abs(x) - _SLIT), d)


def skull(p, q):
    d = ellipsoid(p, (0, 1.688, -0.014), (0.0745, 0.090, 0.097))
    d = union(d, ellipsoid(p, (0, 1.694, 0.030), (0.058, 0.052, 0.056)), 0.04)  # forehead
    d = union(d, ellipsoid(p, (0, 1.622, 0.026), (0.0545, 0.070, 0.0615)), 0.05)  # face
    d = union(d, limb(q, (0.0455, 1.608, -0.006), (0.0405, 1.583, 0.006), 0.0150, 0.0135), 0.03)  # angle of the jaw
    d = union(d, limb(q, (0.0405, 1.583, 0.006), (0.0165, 1.5565, 0.066), 0.0135, 0.0150), 0.032)  # jaw line
    d = union(d, ellipsoid(p, (0, 1.557, 0.075), (0.0200, 0.0150, 0.0165)), 0.022)  # chin
    d = union(d, limb(q, (0.0600, 1.642, 0.018), (0.0460, 1.634, 0.0585), 0.010, 0.0130), 0.030)  # cheek bone
    return d


def brow_ridge(q, d):
    line = [(0.006, 1.6750, 0.0830), (0.026, 1.6775, 0.0800), (0.048, 1.6710, 0.0625)]
    return union(d, tube(q, line, [0.0094, 0.0094, 0.0084]), 0.018)


def _brow_and_socket(q, d):
    d = brow_ridge(q, d)
    d = subtract(d, ellipsoid(q, (0.033, 1.6520, 0.0970), (0.0210, 0.0125, 0.0195)), 0.022)
    return subtract(d, ellipsoid(q, (0.0135, 1.6560, 0.096), (0.0065, 0.010, 0.012)), 0.012)  # beside the bridge


def _nose(p, d):
    line = [(0, 1.668, 0.0830), (0, 1.648, 0.0925), (0, 1.628, 0.1030), (0, 1.6205, 0.1080)]
    return union(d, tube(p, line, [0.0066, 0.0064, 0.0074, 0.0083]), 0.015)


def _lids(q, d):
    """A shell round the eye ball, open between the lids."""
    ball = sphere(q, EYE, EYE_RADIUS)
    slit = opening(q)
    shell = subtract(ball - _LID, slit, 0.0016)
    d = union(d, shell, 0.0085)
    hollow = intersect(ball + 0.0006, slit - 0.0002, 0.001)
    return subtract(d, hollow, 0.0012)


def head(p):
    """The face as far as the slit of hood and mask shows it, and a skull behind."""
    q = mirrored(p)
    d = skull(p, q)
    d = within(q, d, (0, 1.62, 0.03), (0.075, 1.71, 0.13), _brow_and_socket)
    d = within(p, d, (-0.03, 1.59, 0.06), (0.03, 1.69, 0.13), _nose)
    return within(q, d, (0.008, 1.63, 0.045), (0.056, 1.675, 0.10), _lids)


def detail(p):
    """Where errors count more: the lids before the rest; and the brows, whose shade is painted on the skin."""
    q = mirrored(p)
    lids = np.exp(-np.sum(((q - EYE) / vec(0.020, 0.013, 0.03)) ** 2, axis=1))
    brow = np.exp(-np.sum(((q - vec(0.033, 1.678, 0.08)) / vec(0.026, 0.008, 0.03)) ** 4, axis=1))
    return 0.7 + 3.0 * lids + 2.5 * brow


def paint(part):
    p, q = part.points, mirrored(part.points)

    def spot(centre, radius):
        return np.exp(-np.sum(((q - np.array(centre)) / np.array(radius)) ** 2, axis=1))

    part.tint(0.30 * spot((0.045, 1.634, 0.070), (0.022, 0.012, 0.03)), (0.97, 0.78, 0.72))  # cheeks
    part.tint(0.50 * spot((0.0165, 1.6580, 0.085), (0.0080, 0.013, 0.02)), (0.56, 0.50, 0.50))  # beside the bridge
    part.tint(0.35 * spot((0.032, 1.6415, 0.080), (0.020, 0.0050, 0.02)), (0.80, 0.72, 0.72))  # below the lower lid
    part.tint(0.45 * spot((0.034, 1.6640, 0.080), (0.022, 0.0055, 0.02)), (0.58, 0.52, 0.52))  # under the brow
    part.tint(0.30 * spot((0.0, 1.6640, 0.090), (0.0065, 0.010, 0.02)), (1.0, 0.90, 0.88))  # the bridge
    slit = opening(q)
    part.tint(_upper_lid(q, slit), LID_SHADE)
    part.tint(0.9 * _upper_lid(q, slit) * np.exp(-(((slit - 0.0042) / 0.0010) ** 2)), (0.46, 0.38, 0.36))  # its crease
    rim = np.abs(slit) * (p[:, 2] > 0.06)
    part.tint(0.55 * np.exp(-((rim / 0.0012) ** 2)), (0.62, 0.46, 0.44))  # the wet edges of the lids


def _upper_lid(q, slit):
    """The fixed part of the upper lid, as dark as the part that moves."""
    above = ramp(-0.0005, 0.0010, q[:, 1] - EYE[1]) * ramp(0.0090, 0.0040, slit)
    return above * ramp(0.0195, 0.0145, np.abs(q[:, 0] - EYE[0])) * (q[:, 2] > 0.055)
