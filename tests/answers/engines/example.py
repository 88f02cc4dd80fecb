#!/usr/bin/python3
"""An example adapter: points on springs, by the semi-implicit Euler method."""
import sys
import time
import tomllib

import numpy as np


def main():
    file, step = sys.argv[1], float(sys.argv[2])
    asked = [line.split(",") for line in sys.stdin.read().split()[1:]]
    with open(file, "rb") as text:
        scene = tomllib.load(text)
    springs = scene.get("connectors", {})
    known = {"length", "mass", "particles", "axial_stiffness", "from", "to", "start"}
    if len(springs) != 1 or set(scene) - {"title", "duration", "gravity", "method", "connectors"}:
        return print("cannot express: anything but one connector")
    name, spring = next(iter(springs.items()))
    if "axial_stiffness" not in spring or set(spring) - known or set(spring["from"]) != {"fixed"} \
            or set(spring["to"]) - {"free", "point_mass"} or set(spring.get("start", {})) != {"direction"}:
        return print("cannot express: a connector that is not a spring from a fixed point")
    if any(quantity.split(".")[-1] not in "xyz" or quantity.count(".") < 2 for _, quantity in asked):
        return print("cannot express: a quantity that is not a place")
    links, direction = spring["particles"] - 1, np.array(spring["start"]["direction"])
    rest, mass = spring["length"] / links, np.full(links + 1, spring["mass"] / (links + 1))
    mass[-1] += spring["to"].get("point_mass", 0.0)
    along = rest * direction / np.linalg.norm(direction)
    x = np.array(spring["from"]["fixed"]) + np.outer(np.arange(links + 1), along)
    v, g, now, begun = np.zeros_like(x), np.array(scene.get("gravity", [0, -9.81, 0])), 0.0, time.process_time()
    print("time,quantity,value")
    for when, quantity in asked:
        connector, particle, axis = quantity.split(".")
        count = int(np.ceil((float(when) - now) / step))
        for _ in range(count):  # of steps to the row's time
            gap = np.diff(x, axis=0)
            length = np.linalg.norm(gap, axis=1, keepdims=True)
            pull = spring["axial_stiffness"] * (length / rest - 1) * gap / length
            force = np.outer(mass, g)
            force[:-1] += pull
            force[1:] -= pull
            v[1:] += (float(when) - now) / count * force[1:] / mass[1:, None]
            x += (float(when) - now) / count * v
        now = float(when)
        print(f"{when},{quantity},{x[int(particle)]['xyz'.index(axis)]:.17g}")
    print(f"cpu_s,{time.process_time() - begun}")


main()
