"""Torso and neck: what the clothes hang on."""

from sdf import Loft, ellipsoid, intersect, limb, mirrored, union

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
    """The chest in the opening of the jacket."""
    q = mirrored(p)
    d = trunk(p, -0.004)
    d = union(d, ellipsoid(q, (0.075, 1.335, 0.062), (0.085, 0.060, 0.045)), 0.035)
    d = union(d, neck(p), 0.045)
    return union(d, limb(q, (0.018, 1.437, 0.047), (0.150, 1.455, 0.0), 0.010, 0.010), 0.018)  # collar bones
