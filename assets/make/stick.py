"""A nunchaku's stick.

It lies along y, centred: butt at y = -0.15, and at y = +0.15, just over the ferrule, the point where the
chain is attached; the swivel there belongs to the chain, which turns in it. 28 mm thick at the butt, 24 mm
at the chain's end.
"""
import numpy as np

from lathe import arc, revolve

HALF = 0.150
BUTT, NECK = 0.0140, 0.0120  # radii
_CAP_TOP = HALF - 0.0024  # under the swivel's collar
_WOOD_TOP = _CAP_TOP - 0.0200


def _radius(y):
    """Of the bare wood: tapered."""
    return np.interp(y, [-HALF, HALF], [BUTT, NECK])


def _groove(y, depth, half):
    r = _radius(y)
    return [(r, y - half), (r - 0.7 * depth, y - 0.55 * half), (r - depth, y), (r - 0.7 * depth, y + 0.55 * half), (r, y + half)]


def _wood(grooves, facets):
    bevel = 0.0028
    profile = [(0.0, -HALF), (0.007, -HALF)] + arc((BUTT - bevel, -HALF + bevel), bevel, -np.pi / 2, 0, 7)
    for y in grooves:
        profile += _groove(y, 0.0009, 0.0014)
    for y in np.arange(-0.08, 0.09, 0.04):  # light that arms and scenery hide is found at vertices
        profile.append((_radius(y), y))
    profile.sort(key=lambda p: p[1])
    profile = [p for p in profile if p[1] < _WOOD_TOP - 1e-6] + [(_radius(_WOOD_TOP), _WOOD_TOP)]
    return revolve("Wood", "Oak", profile, facets)


def _metal():
    r = _radius(_WOOD_TOP) + 0.0005
    ferrule = [(r - 0.0008, _WOOD_TOP - 0.0010), (r, _WOOD_TOP), (r, _WOOD_TOP + 0.0028), (r - 0.0006, _WOOD_TOP + 0.0034)]
    ferrule += [(r - 0.0006, _WOOD_TOP + 0.0042), (r, _WOOD_TOP + 0.0048)]
    ferrule += arc((r - 0.0030, _CAP_TOP - 0.0042), 0.0030, 0, np.pi / 2, 6)
    ferrule += [(0.0072, _CAP_TOP - 0.0012), (0.0066, _CAP_TOP - 0.0002), (0.0060, _CAP_TOP), (0.0, _CAP_TOP)]
    return revolve("Ferrule", "Brass", ferrule, 40)


def _shade(part):
    """Grooves and the foot of the swivel collect shade."""
    r, y = np.hypot(part.points[:, 0], part.points[:, 2]), part.points[:, 1]
    if part.material != "Brass":
        part.tint(np.clip((_radius(y) - r - 0.0002) / 0.0006, 0, 1) * (np.abs(y) < HALF - 0.004) * 0.65, (0.2, 0.2, 0.2))
    part.tint(0.4 * np.clip(1 - np.abs(y - _WOOD_TOP) / 0.0012, 0, 1), (0.3, 0.3, 0.3))


def oak():
    """Stained oak in clear lacquer, with grooves at the butt and below the ferrule."""
    parts = [_wood((-0.120, -0.112, 0.096, 0.103), 40), _metal()]
    for part in parts:
        _shade(part)
    return parts


def lacquer():
    """Octagonal black lacquer: another look for the same body."""
    wood = _wood((-0.128, 0.104), 8)
    wood.material = "Lacquer"
    parts = [wood, _metal()]
    for part in parts:
        _shade(part)
    return parts
