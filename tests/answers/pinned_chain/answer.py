import numpy as np
from answers import agree, integrate

VARIED = [{"connectors.chain.start.spin": [0.0, 0.0, -3.0]}, {"connectors.chain.length": 0.8, "duration": 1.7}]


def answer(scene):
    chain, caught = scene["connectors"]["chain"], scene["pins"][0]["from"]
    l, rate = chain["length"] / 2, chain["start"]["spin"][2]
    turned = rate * caught
    way = np.array([np.cos(turned), np.sin(turned), 0])
    rows = [(caught - 0.1, "chain.2.x", 2 * l * np.cos(rate * (caught - 0.1)), 5e-6)]
    # Its speed 2 l w across the arm l: about the pin it turns twice as fast.
    y = integrate(lambda t, s: np.concatenate([s[2:], -(s[2:] @ s[2:]) / l**2 * s[:2]]),
                  np.concatenate([l * way[:2], 2 * l * rate * np.array([-way[1], way[0]])]),
                  [scene["duration"] - caught])[0]
    angle = turned + 2 * rate * (scene["duration"] - caught)
    end = l * way[:2] + l * np.array([np.cos(angle), np.sin(angle)])
    agree(l * way[:2] + y[:2], end, 1e-8)
    t = scene["duration"]
    return rows + [(t, "chain.1.x", l * way[0], 5e-6), (t, "chain.1.y", l * way[1], 5e-6),
                   (t, "chain.2.x", end[0], 5e-6), (t, "chain.2.y", end[1], 5e-6)]
