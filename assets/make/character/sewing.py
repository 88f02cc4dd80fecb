"""What moves with the jacket's trunk: its skirt, the lapels, the hems of the sleeves, the collar under them, the belt."""
from dataclasses import replace

import numpy as np

from character import hanging, jacket, lapels, skirt
from character.weights import dense_of, nearby, sides, strongest
from mesh import merge, mirror
from sdf import ramp

_FLIP = np.array([-1.0, 1, 1])


def on_jacket(cloth, belt, heat):
    """Weighted parts, the belt's weights among them; `cloth`: the jacket's trunk and sleeves, weighted."""
    outer = jacket.lining(cloth.points) < 0.5
    points, dense = cloth.points[outer], dense_of(cloth)[outer]
    out = []
    for part, flat in skirt.panels():
        below = ramp(1.02, 0.97, flat[:, 1])[:, None]  # the belt
        held = (1 - below) * nearby(flat, points, dense) + below * heat.at(flat, ["Hips", "Spine", *sides("UpLeg")])
        hung = hanging.skirt(replace(part, points=flat), held)
        out.append(_weighted(part, hung))
    cuff, end = jacket.cuff()
    for part, flat in (lapels.lapels(), lapels.under_collar(), (cuff, end), (mirror(cuff, "CuffR"), end * _FLIP)):
        out.append(_weighted(part, nearby(flat, points, dense)))
    _weighted(belt, hanging.tails(belt, nearby(belt.points, points, dense)))
    return out


def _weighted(part, dense):
    part.joints, part.weights = strongest(dense)
    return part


def sewn(parts, cloth, others):
    """The closed sheets of that cloth become one with it."""
    own = [p for p in others if p.name.startswith(("Skirt", "Cuff"))]
    one = merge(cloth.name, cloth.material, [cloth, *own])
    return [one if p is cloth else p for p in parts if not any(p is o for o in own)]
