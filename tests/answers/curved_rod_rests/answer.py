import numpy as np
from answers import agree

VARIED = [{"connectors.rod.bending_stiffness": 20.0}]


def answer(scene):
    rod, t = scene["connectors"]["rod"], scene["duration"]
    x = np.array(rod["start"]["points"])
    ways = np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1)[:, None]
    l = rod["length"] / (rod["particles"] - 1)
    turns = np.diff(np.arctan2(ways[:, 1], ways[:, 0]))
    agree(2 * np.tan(turns / 2) / l, np.full(len(turns), rod["rest_curvature"][2]), 1e-7)
    agree(np.linalg.norm(2 * np.cross(ways[:-1], ways[1:]) / (1 + np.sum(ways[:-1] * ways[1:], axis=1))[:, None], axis=1),
          np.full(len(turns), rod["rest_curvature"][2] * l), 1e-8)
    return [(t, f"rod.{k}.{axis}", x[k][j], 1e-7) for k in range(len(x)) for j, axis in enumerate("xyz")] + [(t, "elastic_energy", 0.0, 1e-12)]
