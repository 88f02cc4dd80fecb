"""The lapels: one band of several layers from the right front round the neck to the left front, and the strip of the
collar under them."""
import numpy as np

import nets
from character import sheet
from character.cloth import spline
from character.jacket_shape import BELT, LAPEL, lapel_centre, smooth
from sdf import limb, ramp, union
from skeleton import vec

# Distances across a lapel from its free edge: the edges, the rows where it is sewn, and what is between them.
ACROSS = np.array([0, 0.0060, 0.0078, 0.0096, 0.0190, 0.0210, 0.0230, 0.0330, 0.0348, 0.0366, 0.0414, 0.0432])
_SEWN = (0.0078, 0.0210, 0.0348)
_RAISED, _GROOVE = 0.0026, 0.0015


def lying(p):
    """What the lapels lie on: the jacket, running up a cone round the neck."""
    return union(smooth(p), limb(p, (0, 1.40, -0.020), (0, 1.62, -0.036), 0.084, 0.072), 0.025)


def over(p):
    """How far the left panel is raised, which lies on top, m; the belt presses it flat."""
    line = p[:, 0] - lapel_centre(p[:, 1])
    share = ramp(-LAPEL + 0.001, -LAPEL + 0.006, line) * ramp(0.0, 0.04, p[:, 2]) * ramp(1.33, 1.25, p[:, 1])
    return 0.0050 * share * (1 - np.exp(-(((p[:, 1] - BELT) / 0.026) ** 2)))


def band(distance):
    """Height and tint across a lapel, from its free edge."""
    raised = _RAISED * np.interp(distance, [2 * LAPEL - 0.0006, 2 * LAPEL + 0.0012], [1, 0])
    sewn = sum(np.exp(-(((distance - row) / 0.0013) ** 2)) for row in _SEWN)
    step = np.exp(-(((distance - 2 * LAPEL - 0.0012) / 0.0014) ** 2))
    worn = 0.18 * np.exp(-((distance / 0.003) ** 2))
    return raised - _GROOVE * sewn, (1 + worn) * (1 - 0.42 * sewn) * (1 - 0.35 * step)


def _path(last):
    """The middle line of the left lapel from the neck behind down to a height."""
    line = spline(
        [(0.0, 1.484, -0.102), (0.045, 1.488, -0.085), (0.074, 1.492, -0.040), (0.074, 1.478, 0.010), (0.067, 1.450, 0.042)]
        + [(lapel_centre(y), y, z) for y, z in ((1.40, 0.090), (1.34, 0.118), (1.27, 0.132), (1.20, 0.134), (1.10, 0.130))]
        + [(lapel_centre(y), y, z) for y, z in ((1.02, 0.120), (0.90, 0.140))],
        4,
    )
    line = nets.project(lying, line, 0.05, 4)
    return line[(line[:, 1] > last) | (line[:, 2] < 0)]


def _strip(name, material, distances, height, tint, last, thick, shown=None):
    """A strip along the lapels; `height` (points, side) -> m over what it lies on, per distance; `shown` (line) -> what
    share of it there is beyond the free edge."""
    left, right = _path(last[0]), _path(last[1]) * vec(-1, 1, 1)
    line = np.concatenate([right[:0:-1], left])
    way = np.gradient(line, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    up = nets.normals(lying, line, 0.004)
    aside = np.cross(up, way)  # on the left half away from the free edge
    side = np.r_[-np.ones(len(right) - 1), np.ones(len(left))]
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    across = np.tile(distances, (len(line), 1))
    if shown is not None:
        share = shown(line)[:, None]
        across = np.where(across < 0, across * share + 0.0050 * (1 - share), across)
    grid = line[:, None] + (across - LAPEL)[:, :, None] * aside[:, None]
    # Across the neck the free edge is above on both halves.
    flat = nets.project(lying, grid.reshape(-1, 3), 0.05, 5)
    facing = nets.normals(lying, flat, 0.003)
    base = height(flat, np.repeat(side, len(distances)), across.ravel())
    relief, tints = tint(distances)
    plain = (flat + facing * base[:, None]).reshape(grid.shape)
    outer = plain + facing.reshape(grid.shape) * relief[None, :, None]
    return sheet.slab(name, material, outer, thick, np.tile(tints, (len(line), 1)), plain=plain)


def _raised(p, side, distance):
    """The base of the lapels over what they lie on: the right one goes under the left panel."""
    line = p[:, 0] - lapel_centre(p[:, 1])
    pressed = 1 - 0.85 * np.exp(-(((p[:, 1] - BELT) / 0.026) ** 2)) * (p[:, 2] > 0)
    under = np.where((side < 0) & (p[:, 1] < 1.36), ramp(-0.020, -0.004, line), 0)
    end = np.where(distance > 2 * LAPEL + 0.0008, 0.0050, 0)
    return (0.0034 + np.where(side > 0, over(p), 0)) * pressed - 0.0105 * under - end


def lapels():
    """The band and the points of its outside."""
    return _strip("Lapels", "Gi", ACROSS, _raised, band, (BELT - 0.012, 1.15), 0.0042)


def under_collar():
    """The strip that shows inside the lapels, and the points of its outside."""
    across = np.array([-0.0165, -0.0140, -0.0115, -0.005, 0.006])

    def height(p, side, distance):
        deeper = 0.0110 * np.clip((-0.004 - distance) / 0.0125, 0, 1) ** 1.5
        lower = np.where(distance < 0, 0.0026, 0.0048)  # beside the lapel nearly as high, which else shades it
        return np.minimum(_raised(p, side, np.full(len(p), LAPEL)), 0.0034 + over(p)) - lower - deeper

    def tint(distance):
        return np.zeros(len(distance)), 1 - 0.25 * np.exp(-(((distance + 0.0115) / 0.0014) ** 2))

    def shown(line):  # neither beside the neck, where it would come out as the head turns, nor where the lapels cross
        y = line[:, 1]
        return 0.05 + 0.95 * ramp(1.465, 1.440, y) * ramp(1.252, 1.280, y) * ramp(0.0, 0.03, line[:, 2])

    return _strip("Collar", "Collar", across, height, tint, (1.19, 1.19), 0.0022, shown)
