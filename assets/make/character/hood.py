"""The hood: two panels sewn along the crown, drawn in by the head band, hanging over the nape into the collar."""
import numpy as np

from character import head
from character.body import chest, neck
from character.cloth import crumple
from sdf import ellipsoid, intersect, limb, mirrored, ramp, union
from skeleton import vec

CLOTH = 0.0030  # thickness with its hem, m
_KNOT = vec(0, 1.730, -0.120)  # of the band
AXIS = -0.010  # z of the upright line round which angles are told


def around(p):
    """The angle about the upright line through the head, from the front to the left, rad."""
    return np.arctan2(p[:, 0], p[:, 2] - AXIS)


def form(p):
    """Head and neck as taut cloth sees them: it spans the hollows beside the nose, below the mouth and under the jaw."""
    q = mirrored(p)
    d = head.brow_ridge(q, head.skull(p, q))
    d = union(d, limb(p, (0, 1.652, 0.0830), (0, 1.6195, 0.1050), 0.0080, 0.0110), 0.026)  # the nose's ridge
    d = union(d, ellipsoid(p, (0, 1.5890, 0.0720), (0.0300, 0.0260, 0.0225)), 0.030)
    d = union(d, limb(p, (0, 1.6100, 0.0960), (0, 1.5600, 0.0790), 0.0110, 0.0140), 0.030)  # from the nose to the chin
    d = union(d, ellipsoid(q, (0.0685, 1.6400, -0.0120), (0.0135, 0.0320, 0.0220)), 0.018)  # the ear, pressed flat
    d = union(d, limb(p, (0, 1.554, 0.060), (0, 1.490, 0.016), 0.012, 0.028), 0.040)  # the throat
    d = union(d, limb(p, (0, 1.660, -0.054), (0, 1.500, -0.040), 0.046, 0.040), 0.030)  # the nape
    d = union(d, neck(p) + 0.002, 0.012)
    return union(d, chest(p), 0.001 + 0.030 * ramp(1.56, 1.48, p[:, 1]))


def scalp(p):
    q = mirrored(p)
    d = ellipsoid(p, (0, 1.690, -0.016), (0.0805, 0.0965, 0.1015))
    d = union(d, ellipsoid(q, (0.030, 1.645, -0.050), (0.046, 0.072, 0.056)), 0.035)
    return union(d, form(p) - 0.0036, 0.012)


def opening(p):
    """The distance to where the face is bare of the hood, along the cloth; negative inside."""
    s, y = 0.088 * around(p), p[:, 1]
    top = 1.6892 + 0.0006 * np.sin(70 * s + 1)
    u, v = np.abs(s) - (0.0790 - 0.030), np.abs(y - (top - 0.070)) - (0.070 - 0.030)
    return np.hypot(np.maximum(u, 0), np.maximum(v, 0)) + np.minimum(np.maximum(u, v), 0) - 0.030


def hem(edge):
    """How much the cloth rises by its distance from an edge: the hem is doubled and stitched."""
    doubled = 0.0011 * ramp(0.0118, 0.0090, edge)
    return doubled - 0.0006 * np.exp(-(((edge - 0.0072) / 0.0016) ** 2))


def band_height(p):
    """Height over the middle of the head band, which rises a little towards the back."""
    return p[:, 1] - (1.7205 - 0.10 * p[:, 2])


def _folds(p):
    """Puckers above and below the band, folds that hang from it over the nape, and the seam over the crown."""
    a, up = around(p), band_height(p)
    near = ramp(0.014, 0.021, np.abs(up)) * ramp(0.060, 0.020, np.abs(up))
    pucker = np.abs(np.sin(11 * a + 1.7 * np.sin(3 * a + 0.6) + 8 * np.abs(up))) ** 0.7 - 0.55
    pucker = pucker + 0.5 * np.sin(23 * a + 2.3 * np.sin(4 * a))
    behind = ramp(1.3, 2.0, np.abs(a)) * ramp(-0.016, -0.045, up)
    drape = np.abs(np.sin(4.2 * a + 9 * p[:, 1] + 0.8 * np.sin(17 * p[:, 1] + a))) ** 0.6 - 0.6
    seam = np.exp(-((p[:, 0] / 0.0018) ** 2)) * ramp(0.016, 0.022, up)
    side = np.exp(-((np.abs(p[:, 0]) - 0.006) / 0.003) ** 2) * ramp(0.016, 0.022, up)
    crown = ramp(0.02, 0.05, up) * crumple(p, 1.6, 4.0)
    # The cloth of the crown is drawn together where the band is knotted.
    v = p - _KNOT
    fan, far = np.arctan2(v[:, 0], v[:, 1] + 0.3 * v[:, 2]), np.linalg.norm(v, axis=1)
    drawn = np.abs(np.sin(3.7 * fan + 0.6 * np.sin(4 * fan + 25 * far) + 0.4)) ** 0.7 - 0.6
    crown = crown + 2.4 * drawn * ramp(0.012, 0.03, up) * ramp(0.03, 0.07, far) * ramp(0.19, 0.09, far)
    return 0.0011 * near * pucker + 0.0042 * behind * drape - 0.0008 * seam + 0.0004 * side + 0.0005 * crown


def outside(p):
    """The hood without its opening."""
    up = band_height(p)
    puffed = 0.0030 * ramp(0.012, 0.035, up) - 0.0010 * ramp(0.020, 0.013, np.abs(up))
    return scalp(p) - puffed - _folds(p) - 0.0003 * crumple(p, 0.6)


def hood(p):
    edge = opening(p)
    outer = outside(p) - hem(edge)
    d = intersect(outer, -(outer + CLOTH + 0.0012), 0.0010)
    d = intersect(d, -edge, 0.0016)
    return intersect(d, 1.470 - p[:, 1], 0.003)


def filling(p):
    """What the skin has under the hood so that no sight passes between both."""
    return np.maximum(outside(p) + CLOTH + 0.0012, 0.010 - opening(p))


def shown(p):
    """What of the hood can be seen: its outside, and its lining near the opening."""
    return (outside(p) > -0.0016) | (opening(p) < 0.022)


def detail(p):
    """Where errors count more: near the opening and where the mask ends."""
    return 0.7 + 1.6 * np.exp(-((opening(p) / 0.012) ** 2))
