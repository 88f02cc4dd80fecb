"""The face: skull, features, ears and eyelids of the head's skin."""
import numpy as np

from character.body import neck
from sdf import ellipsoid, intersect, limb, mirrored, rotation, sphere, subtract, tube, union, within
from skeleton import EYE, vec

EYE_RADIUS = 0.0140
_LID = 0.0018
_SLIT = 0.0158  # half width of the opening


def opening(q):
    """Distance (about) to the opening between the lids, seen from the front; negative inside."""
    x = q[:, 0] - EYE[0]
    y = q[:, 1] - EYE[1] - 0.05 * x  # the outer corner is a little higher
    u = np.clip(x / _SLIT, -1, 1)
    upper = 0.0046 * (1 - u * u) ** 0.60
    lower = 0.0047 * (1 - u * u) ** 0.75
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


def _brow_and_socket(q, d):
    d = union(d, tube(q, [(0.006, 1.675, 0.083), (0.026, 1.6775, 0.0795), (0.048, 1.671, 0.062)], [0.0090, 0.0088, 0.0080]), 0.020)
    d = subtract(d, ellipsoid(q, (0.033, 1.6520, 0.0955), (0.0210, 0.0125, 0.0195)), 0.020)
    return subtract(d, ellipsoid(q, (0.0135, 1.6560, 0.096), (0.0065, 0.010, 0.012)), 0.012)  # beside the bridge


def _nose(p, q, d):
    bridge = tube(p, [(0, 1.668, 0.0830), (0, 1.648, 0.0925), (0, 1.628, 0.1030), (0, 1.6205, 0.1080)], [0.0066, 0.0064, 0.0074, 0.0083])
    d = union(d, bridge, 0.015)
    d = union(d, ellipsoid(p, (0, 1.6180, 0.1085), (0.0096, 0.0082, 0.0092)), 0.008)  # tip
    d = union(d, ellipsoid(q, (0.0122, 1.6165, 0.0940), (0.0070, 0.0068, 0.0088)), 0.012)  # wings
    d = union(d, limb(p, (0, 1.6105, 0.0945), (0, 1.6115, 0.1040), 0.0042, 0.0040), 0.005)  # septum
    return subtract(d, ellipsoid(q, (0.0072, 1.6095, 0.0985), (0.0036, 0.0042, 0.0058)), 0.004)  # nostrils


def _mouth(p, q, d):
    d = union(d, ellipsoid(p, (0, 1.5895, 0.0725), (0.0300, 0.0240, 0.0215)), 0.022)  # teeth behind the lips
    upper = [(0.0, 1.5950, 0.0930), (0.0048, 1.5964, 0.0932), (0.0140, 1.5932, 0.0885), (0.0245, 1.5900, 0.0790)]
    lower = [(0.0, 1.5838, 0.0918), (0.0095, 1.5843, 0.0900), (0.0220, 1.5887, 0.0805)]
    d = union(d, tube(q, upper, [0.0042, 0.0044, 0.0038, 0.0022]), 0.0050)
    d = union(d, tube(q, lower, [0.0060, 0.0055, 0.0026]), 0.0055)
    line = [(0.0, 1.5896, 0.0990), (0.0050, 1.5904, 0.0985), (0.0140, 1.5902, 0.0945), (0.0255, 1.5893, 0.0830)]
    d = subtract(d, tube(q, line, [0.0016, 0.0015, 0.0014, 0.0012]), 0.0032)
    d = subtract(d, ellipsoid(p, (0, 1.6045, 0.1020), (0.0036, 0.0065, 0.0050)), 0.006)  # philtrum
    d = subtract(d, ellipsoid(p, (0, 1.5712, 0.1022), (0.017, 0.0056, 0.0105)), 0.018)  # below the lip
    return subtract(d, ellipsoid(q, (0.0300, 1.5890, 0.0875), (0.0028, 0.0028, 0.0038)), 0.008)  # corners


def _lids(q, d):
    """A shell round the eye ball, open between the lids, with a fold above."""
    ball = sphere(q, EYE, EYE_RADIUS)
    slit = opening(q)
    shell = subtract(ball - _LID, slit, 0.0016)
    d = union(d, shell, 0.0070)
    fold = np.hypot(ball - _LID - 0.0014, slit - 0.0046) - 0.0013
    fold = np.where(q[:, 1] > EYE[1] + 0.001, fold, 1.0)
    d = subtract(d, fold, 0.0030)
    hollow = intersect(ball + 0.0006, slit - 0.0002, 0.001)
    return subtract(d, hollow, 0.0012)


def _ear(q, d):
    turn = rotation("y", 0.42) @ rotation("x", -0.18)
    c = vec(0.0775, 1.640, -0.012)
    helix = ellipsoid(q, c, (0.0085, 0.0315, 0.0180), turn)
    helix = subtract(helix, ellipsoid(q, c + vec(0.009, 0.003, 0.003), (0.0075, 0.0235, 0.0115), turn), 0.005)
    anti = tube(q, [c + vec(0.004, 0.014, 0.000), c + vec(0.0045, 0.000, -0.005), c + vec(0.003, -0.014, 0.000)], [0.0030, 0.0034, 0.0030])
    helix = union(helix, anti, 0.004)
    helix = union(helix, ellipsoid(q, c + vec(0.000, -0.0265, 0.006), (0.0050, 0.0085, 0.0070)), 0.006)  # lobe
    helix = union(helix, ellipsoid(q, vec(0.0725, 1.637, 0.0035), (0.0050, 0.0065, 0.0045)), 0.005)  # tragus
    return union(d, helix, 0.008)


def head(p, throat=neck):
    """The head on its neck; `throat`: field of the neck and what hangs on it."""
    q = mirrored(p)
    d = union(skull(p, q), throat(p), 0.025)
    d = within(q, d, (0, 1.62, 0.03), (0.075, 1.71, 0.13), _brow_and_socket)
    d = within(p, d, (-0.03, 1.59, 0.06), (0.03, 1.69, 0.13), lambda p, d: _nose(p, mirrored(p), d))
    d = within(p, d, (-0.06, 1.54, 0.03), (0.06, 1.63, 0.13), lambda p, d: _mouth(p, mirrored(p), d))
    d = within(q, d, (0.008, 1.63, 0.045), (0.056, 1.675, 0.10), _lids)
    return within(q, d, (0.05, 1.58, -0.06), (0.12, 1.70, 0.04), _ear)


def detail(p):
    """Where errors count more: eyes, mouth and nose before cheeks before the back of the head."""
    q = mirrored(p)
    front = np.clip((p[:, 2] - 0.02) / 0.04, 0, 1) * np.clip((p[:, 1] - 1.50) / 0.03, 0, 1)
    eyes = np.exp(-np.sum(((q - EYE) / vec(0.020, 0.012, 0.03)) ** 2, axis=1))
    mouth = np.exp(-np.sum(((q - vec(0, 1.59, 0.09)) / vec(0.03, 0.012, 0.03)) ** 2, axis=1))
    nose = np.exp(-np.sum(((q - vec(0, 1.616, 0.1)) / vec(0.02, 0.012, 0.02)) ** 2, axis=1))
    return 0.5 + 1.0 * front + 3.0 * np.maximum(eyes, 0.8 * np.maximum(mouth, nose))


def paint(part):
    p, q = part.points, mirrored(part.points)

    def spot(centre, radius):
        return np.exp(-np.sum(((q - np.array(centre)) / np.array(radius)) ** 2, axis=1))

    lip = np.maximum(
        spot((0.004, 1.5945, 0.094), (0.0190, 0.0036, 0.02)), spot((0.0, 1.5842, 0.093), (0.0185, 0.0048, 0.02))
    )
    part.tint(np.clip(1.5 * lip - 0.15, 0, 1) * 0.65, (0.80, 0.50, 0.48))
    part.tint(0.20 * spot((0.046, 1.622, 0.068), (0.022, 0.020, 0.03)), (0.97, 0.78, 0.72))  # cheeks
    part.tint(0.50 * spot((0, 1.617, 0.110), (0.013, 0.012, 0.013)), (0.97, 0.78, 0.72))
    part.tint(0.55 * spot((0.084, 1.640, -0.012), (0.014, 0.034, 0.03)), (0.97, 0.74, 0.66))
    part.tint(0.20 * spot((0.032, 1.654, 0.080), (0.022, 0.011, 0.02)), (0.80, 0.64, 0.58))  # round the eyes
    part.tint(0.60 * spot((0.0072, 1.6095, 0.0985), (0.0042, 0.0035, 0.006)), (0.35, 0.22, 0.18))  # nostrils
    beard = np.maximum(spot((0.0, 1.562, 0.07), (0.05, 0.020, 0.05)), spot((0.0, 1.604, 0.095), (0.022, 0.006, 0.02)))
    part.tint(0.16 * beard * (1 - np.clip(lip * 2, 0, 1)), (0.66, 0.70, 0.72))
    line = (np.abs(q[:, 1] - 1.5902) < 0.0011) & (q[:, 0] < 0.0255) & (p[:, 2] > 0.070)
    part.tint(0.45 * line, (0.50, 0.28, 0.26))
