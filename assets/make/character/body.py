"""Torso, neck and feet: what shows of the body outside the clothes, and what the clothes hang on."""
import numpy as np

from sdf import Loft, ellipsoid, intersect, limb, mirrored, union
from skeleton import joint, tip, unit, vec

_TORSO = Loft(
    y=[0.86, 0.92, 0.98, 1.05, 1.12, 1.20, 1.28, 1.34, 1.40, 1.45, 1.48],
    half_x=[0.150, 0.172, 0.170, 0.150, 0.142, 0.152, 0.168, 0.176, 0.172, 0.130, 0.075],
    half_z=[0.098, 0.112, 0.108, 0.098, 0.094, 0.102, 0.114, 0.118, 0.106, 0.080, 0.060],
    centre_z=[-0.012, -0.014, -0.010, -0.002, 0.000, 0.000, -0.004, -0.008, -0.016, -0.024, -0.026],
)


def trunk(p, grow=0.0):
    d = _TORSO(p, grow)
    d = intersect(d, p[:, 1] - 1.465 - grow, 0.06)
    return intersect(d, 0.87 - grow - p[:, 1], 0.06)


def neck(p):
    q = mirrored(p)
    d = limb(p, (0, 1.40, -0.032), (0, 1.575, -0.012), 0.061, 0.0515)
    d = union(d, limb(q, (0.010, 1.432, 0.034), (0.052, 1.600, -0.022), 0.008, 0.013), 0.022)  # sternomastoid
    d = union(d, limb(q, (0.045, 1.480, -0.045), (0.14, 1.436, -0.03), 0.034, 0.026), 0.08)  # trapezius
    return union(d, ellipsoid(p, (0, 1.520, 0.042), (0.012, 0.016, 0.012)), 0.018)  # larynx


def chest(p):
    """The skin in the opening of the jacket."""
    q = mirrored(p)
    d = trunk(p, -0.004)
    d = union(d, ellipsoid(q, (0.075, 1.335, 0.062), (0.085, 0.060, 0.045)), 0.035)
    d = union(d, neck(p), 0.045)
    return union(d, limb(q, (0.018, 1.437, 0.047), (0.150, 1.455, 0.0), 0.010, 0.010), 0.018)  # collar bones


def foot(p):
    """The left foot and shin, to below the knee."""
    knee, ankle, ball = joint("LeftLeg"), joint("LeftFoot"), joint("LeftToeBase")
    d = limb(p, knee + vec(0, -0.02, 0), ankle + vec(0, 0.03, 0), 0.056, 0.036)
    d = union(d, ellipsoid(p, knee * 0.7 + ankle * 0.3 + vec(0.004, 0, -0.022), (0.050, 0.11, 0.045)), 0.04)
    d = union(d, limb(p, ankle + vec(0, 0.10, -0.026), ankle + vec(0, -0.035, -0.045), 0.013, 0.016), 0.03)  # tendon
    d = union(d, limb(p, ankle + vec(0, 0.03, 0), ankle + vec(0, -0.012, -0.005), 0.035, 0.034), 0.03)
    d = union(d, ellipsoid(p, ankle + vec(-0.002, -0.047, -0.042), (0.031, 0.034, 0.036)), 0.03)  # heel
    d = union(d, limb(p, ankle + vec(-0.004, -0.010, 0.028), ball + vec(-0.010, 0.016, -0.012), 0.034, 0.022, (0, 1, 0), 0.9), 0.035)
    d = union(d, limb(p, ankle + vec(0.012, -0.056, -0.03), ball + vec(0.024, 0.002, -0.012), 0.022, 0.018), 0.03)
    d = union(d, limb(p, ankle + vec(-0.012, -0.046, 0.02), ball + vec(-0.030, 0.002, 0.0), 0.020, 0.020), 0.03)
    d = union(d, ellipsoid(p, ankle + vec(0.035, -0.004, -0.006), (0.010, 0.014, 0.012)), 0.014)  # malleoli
    d = union(d, ellipsoid(p, ankle + vec(-0.035, 0.006, 0.002), (0.009, 0.014, 0.012)), 0.014)
    across = (-0.038, -0.0125, 0.0065, 0.0240, 0.0400)
    length = (0.060, 0.061, 0.053, 0.045, 0.035)
    radius = (0.0145, 0.0098, 0.0092, 0.0088, 0.0086)
    for x, l, r in zip(across, length, radius):
        root = ball + vec(x, 0.004, 0.004 - abs(x + 0.02) * 0.25)
        ahead = unit(vec(0.10 + x * 0.6, -0.05, 1))
        middle, end = root + ahead * l * 0.55 + vec(0, 0.002, 0), root + ahead * l - vec(0, 0.0035, 0)
        toe = union(limb(p, root, middle, r * 0.95, r * 0.80), limb(p, middle, end, r * 0.80, r * 0.95), 0.004)
        nail = ellipsoid(p, end + vec(0, r * 0.72, 0.002), (r * 0.62, r * 0.26, r * 0.75))
        d = union(d, union(toe, nail, 0.0012), 0.005)
    return intersect(d, 0.002 - p[:, 1], 0.006)


def below_shin(p):
    """The left foot, cut inside the trouser leg."""
    return intersect(foot(p), p[:, 1] - 0.30, 0.003)


def bust(p):
    """Neck and chest as far as the jacket's opening shows them."""
    d = intersect(chest(p), np.maximum(1.17 - p[:, 1], np.abs(p[:, 0]) - 0.098), 0.004)
    return np.where(p[:, 1] < 1.43, intersect(d, 0.030 - p[:, 2], 0.004), d)


def paint_foot(part, side):
    q = part.points * vec(side, 1, 1)
    toes = np.exp(-np.sum(((q - vec(0.135, 0.006, 0.175)) / vec(0.06, 0.022, 0.045)) ** 2, axis=1))
    heel = np.exp(-np.sum(((q - vec(0.112, 0.012, -0.062)) / vec(0.04, 0.025, 0.03)) ** 2, axis=1))
    part.tint(0.55 * np.maximum(toes, heel), (0.94, 0.72, 0.64))
    sole = np.clip((0.010 - q[:, 1]) / 0.008, 0, 1)
    part.tint(0.25 * sole, (0.80, 0.66, 0.60))
