"""The jacket of the gi: left over right, wide sleeves, a skirt below the belt, folds."""
import numpy as np

from body import trunk
from cloth import Folds, crumple, ribbon, spline
from sdf import Loft, ellipsoid, intersect, limb, mirrored, ramp, subtract, union
from skeleton import joint, unit, vec

HEM, BELT = 0.735, 1.035
_SHOULDER, _ELBOW, _WRIST = joint("LeftArm"), joint("LeftForeArm"), joint("LeftHand")
_UPPER, _FORE = unit(_ELBOW - _SHOULDER), unit(_WRIST - _ELBOW)
_CUFF = _WRIST - 0.060 * _FORE
_LAPEL = 0.021  # half width

_BODY = Loft(
    y=[0.70, 0.78, 0.86, 0.92, 0.98, 1.035, 1.075, 1.12, 1.20, 1.28, 1.36, 1.42, 1.47, 1.50],
    half_x=[0.244, 0.236, 0.222, 0.206, 0.184, 0.166, 0.176, 0.180, 0.186, 0.196, 0.203, 0.188, 0.130, 0.085],
    half_z=[0.180, 0.172, 0.162, 0.149, 0.131, 0.117, 0.128, 0.130, 0.132, 0.138, 0.138, 0.122, 0.092, 0.078],
    centre_z=[-0.010, -0.010, -0.012, -0.012, -0.010, -0.002, 0.0, 0.0, 0.001, -0.003, -0.008, -0.016, -0.024, -0.026],
    power=2.5,
    smooth=21,
)
_SKIRT_CAVITY = Loft(
    y=[0.60, 0.735, 0.80, 0.86],
    half_x=[0.222, 0.217, 0.204, 0.10],
    half_z=[0.157, 0.153, 0.142, 0.06],
    centre_z=[-0.010, -0.010, -0.010, -0.012],
    power=2.5,
)


def lapel_centre(y):
    """x of the middle line of the left lapel on the front; the right lapel is its mirror image."""
    return np.interp(y, [0.70, 1.06, 1.18, 1.30, 1.40, 1.47], [-0.118, -0.070, -0.022, 0.024, 0.056, 0.070])


_LAPEL_PATH = spline(
    [(0.0, 1.487, -0.092), (0.045, 1.487, -0.074), (0.072, 1.484, -0.030), (0.072, 1.462, 0.020)]
    + [(lapel_centre(y), y, z) for y, z in ((1.42, 0.068), (1.36, 0.102), (1.28, 0.128), (1.20, 0.134), (1.10, 0.130), (1.02, 0.120), (0.90, 0.140), (0.80, 0.158), (0.715, 0.170))]
)


def _front(p):
    return ramp(0.0, 0.04, p[:, 2])


def smooth(p, grow=0.0):
    """The jacket's outside without folds and openings."""
    q = mirrored(p)
    d = _BODY(p, grow)
    d = intersect(d, p[:, 1] - 1.480 - grow, 0.05)
    arm = limb(q, vec(0.10, 1.422, -0.02), _SHOULDER + 0.02 * _UPPER, 0.066 + grow, 0.080 + grow)
    arm = union(arm, limb(q, _SHOULDER, _ELBOW, 0.080 + grow, 0.068 + grow), 0.05)
    arm = union(arm, limb(q, _ELBOW, _CUFF + vec(0, -0.012, 0), 0.067 + grow, 0.072 + grow, (0, 0, 1), 0.86), 0.04)
    arm = intersect(arm, (q - _CUFF) @ _FORE - grow, 0.005)
    d = union(d, arm, 0.07)
    d = union(d, ellipsoid(q, (0.085, 1.335, 0.066), (0.080, 0.070, 0.060)), 0.06)  # chest
    d = union(d, ellipsoid(q, (0.085, 1.375, -0.100), (0.070, 0.085, 0.040)), 0.06)  # shoulder blades
    return union(d, limb(p, (0, 1.43, -0.026), (0, 1.492, -0.020), 0.088 + grow, 0.078 + grow), 0.02)  # collar


def _folds():
    f = Folds()
    for s, seed in ((1, 0.0), (-1, 1.7)):
        m = vec(s, 1, 1)
        pit_front, pit_back = vec(0.185, 1.345, 0.070), vec(0.185, 1.345, -0.100)
        f.fan(m * pit_front, [m * vec(*a) for a in ((0.070, 1.400, 0.130), (0.060, 1.330, 0.135), (0.085, 1.240, 0.135), (0.130, 1.180, 0.110))], 0.013, 0.0065, seed=seed)
        f.fan(m * pit_back, [m * vec(*a) for a in ((0.060, 1.410, -0.145), (0.050, 1.320, -0.150), (0.090, 1.220, -0.135), (0.150, 1.160, -0.080))], 0.013, 0.0065, seed=seed + 1)
        f.fan(m * vec(0.190, 1.350, 0.060), [m * (_SHOULDER + 0.16 * _UPPER + vec(*a)) for a in ((0, 0.050, 0.055), (0, 0.0, 0.075), (0, -0.050, 0.055))], 0.012, 0.0055, seed=seed + 2)
        f.fan(m * vec(0.200, 1.345, -0.090), [m * (_SHOULDER + 0.16 * _UPPER + vec(*a)) for a in ((0, 0.040, -0.065), (0, -0.010, -0.080), (0, -0.055, -0.050))], 0.012, 0.0055, seed=seed + 3)
        f.rings(m * (_ELBOW + vec(0, 0, 0.0)), m * (_UPPER + _FORE), m * vec(0.20, -0.10, 1.0), 0.070, 0.030, 4, 0.0085, 0.0085, seed=seed)
        f.rings(m * (_ELBOW - 0.01 * _UPPER), m * (_UPPER + _FORE), m * vec(-0.3, -0.6, -0.6), 0.070, 0.036, 3, 0.011, 0.0060, seed=seed + 2)
        f.rings(m * (_ELBOW + 0.12 * _FORE), m * _FORE, m * vec(-0.2, -1.0, 0.35), 0.070, 0.032, 3, 0.010, 0.0055, lean=0.8, seed=seed + 4)
        f.rings(m * (_SHOULDER + 0.17 * _UPPER), m * _UPPER, m * vec(-0.5, -0.7, 0.2), 0.072, 0.040, 3, 0.011, 0.0055, lean=0.8, seed=seed + 5)
        # Blousing above the belt and pleats below it.
        for k, x in enumerate((0.035, 0.075, 0.115, 0.150)):
            z = 0.128 * np.sqrt(max(0.0, 1 - (x / 0.180) ** 2.4))
            sway = 0.014 * np.sin(3.1 * k + seed)
            f.ridge(m * vec(x, 1.064, z), m * vec(x + sway, 1.165, z * 1.02), 0.010, 0.0075)
            f.ridge(m * vec(x + 0.018, 1.064, z), m * vec(x + 0.018 + sway, 1.120, z), 0.008, -0.0050)
            f.ridge(m * vec(x - 0.01, 1.064, -z - 0.002), m * vec(x + sway, 1.190, -z * 1.05), 0.011, 0.0085)
            f.ridge(m * vec(x + 0.012, 1.064, -z), m * vec(x + 0.012 + sway, 1.140, -z), 0.009, -0.0055)
            f.ridge(m * vec(x, 1.004, z), m * vec(1.25 * x + sway, 0.800, z * 1.25 + 0.010), 0.011, 0.0075, 2.2)
            f.ridge(m * vec(x, 1.004, -z), m * vec(1.25 * x - sway, 0.800, -z * 1.25 - 0.014), 0.011, 0.0085, 2.2)
    f.ridge((0.05, 1.26, -0.142), (-0.08, 1.17, -0.140), 0.013, 0.005)
    f.ridge((-0.02, 1.11, 0.130), (0.10, 1.22, 0.128), 0.012, 0.006)
    f.ridge((0.02, 1.10, 0.130), (-0.12, 1.19, 0.115), 0.012, 0.006)
    return f


_FOLDS = _folds()


def _flutes(p):
    """Waves of the skirt, growing to the hem."""
    angle = np.arctan2(p[:, 0], p[:, 2] + 0.010)
    down = ramp(0.98, HEM, p[:, 1]) * (p[:, 1] < 1.0)
    return down * (0.0065 * np.sin(9 * angle + 1.3) + 0.0045 * np.sin(14 * angle + 0.4 + 6 * p[:, 1]))


def jacket(p):
    q = mirrored(p)
    base = smooth(p)
    calm = 1 - 0.9 * np.exp(-(((p[:, 1] - BELT) / 0.030) ** 2)) * (np.abs(p[:, 0]) < 0.25)
    d = base - (_FOLDS(p) + _flutes(p) + 0.0014 * crumple(p)) * calm
    line = p[:, 0] - lapel_centre(p[:, 1])  # > 0: on the left panel, which lies on top
    front = _front(p)
    over = ramp(-_LAPEL - 0.003, -_LAPEL + 0.003, line) * front * ramp(1.33, 1.27, p[:, 1])
    d = d - 0.0050 * over
    d = _openings(p, q, d)
    right = p * vec(-1, 1, 1)
    strip = ribbon(right, d * 0 + base - 0.0035 - 0.5 * _FOLDS(p) * calm, _LAPEL_PATH, _LAPEL, 0.0058)
    strip = intersect(strip, line + _LAPEL + 0.001 - 1.0 * (p[:, 1] > 1.36), 0.002)
    d = union(d, strip, 0.0018)
    strip = ribbon(p, base - 0.0035 - 0.0050 * over - 0.5 * _FOLDS(p) * calm, _LAPEL_PATH, _LAPEL, 0.0062)
    d = union(d, strip, 0.0018)
    d = intersect(d, HEM - 0.010 * np.cos(9 * p[:, 0]) - p[:, 1], 0.005)
    return _seams(p, q, d, line)


def _openings(p, q, d):
    inner = -(trunk(p, -0.016))
    v = np.abs(p[:, 0]) - (lapel_centre(p[:, 1]) - 0.6 * _LAPEL)
    v = intersect(intersect(v, -p[:, 2] + 0.005, 0.008), 1.10 - p[:, 1], 0.01)
    d = subtract(d, intersect(v, inner, 0.004), 0.004)
    throat = limb(p, (0, 1.42, -0.024), (0, 1.60, -0.012), 0.066, 0.078)
    d = subtract(d, intersect(throat, inner, 0.004), 0.006)
    sleeve = limb(q, _WRIST - 0.17 * _FORE + vec(0, -0.006, 0), _WRIST + 0.02 * _FORE + vec(0, -0.012, 0), 0.046, 0.0625, (0, 0, 1), 0.86)
    d = subtract(d, sleeve, 0.004)
    skirt = intersect(_SKIRT_CAVITY(p), p[:, 1] - 0.84, 0.03)
    d = subtract(d, skirt, 0.004)
    slit = intersect(np.abs(p[:, 2] + 0.012) - 0.003 - 0.05 * np.maximum(0.86 - p[:, 1], 0), p[:, 1] - 0.86, 0.01)
    return subtract(d, np.where(q[:, 0] > 0.12, slit, 9.0), 0.004)


def _seams(p, q, d, line):
    """Grooves of stitching at hem and cuffs, and along the lapels."""
    hem = p[:, 1] - (HEM - 0.010 * np.cos(9 * p[:, 0]))
    d = d + 0.0014 * np.exp(-(((hem - 0.030) / 0.0035) ** 2))
    cuff = (q - _CUFF) @ _FORE
    return d + 0.0014 * np.exp(-(((cuff + 0.030) / 0.0035) ** 2)) * (q[:, 0] > 0.40)
