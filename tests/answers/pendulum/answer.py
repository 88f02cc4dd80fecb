import numpy as np
from answers import frames, gravity, pendulum_angles, places

VARIED = [
    {"connectors.rod.length": 0.4, "connectors.rod.start.direction": [0.1, -1.0, 0.0]},
    {"gravity": [0.0, -1.62, 0.0], "connectors.rod.start.direction": [-1.0, 1.0, 0.0]},
]


def answer(scene):
    rod, times = scene["connectors"]["rod"], frames(scene)
    x, y = rod["start"]["direction"][:2]
    start, rate = np.arctan2(x, -y), np.sqrt(-gravity(scene)[1] / rod["length"])
    states = []
    for theta in pendulum_angles(start, rate, times):
        states.append(np.array(rod["from"]["fixed"]) + rod["length"] * np.array([np.sin(theta), -np.cos(theta), 0]))
    return places(times, "rod.1", states, 1e-7)
