#!/usr/bin/python3
"""Makes the models in assets/: same scripts, same bytes."""
import argparse
import pathlib
import sys
import time

import cube
import dojo
import earring
import glb
import peg
import skeleton
import stick
import studio
from character import martial_artist
from materials import MATERIALS

MODELS = {
    "martial_artist": lambda: (martial_artist.build(), skeleton.REST),
    "stick": lambda: (stick.oak(), None),
    "stick_lacquer": lambda: (stick.lacquer(), None),
    "earring": lambda: (earring.drop(), None),
    "peg": lambda: (peg.build(), None),
    "dojo": lambda: (dojo.build(), None),
    "studio": lambda: (studio.build(), None),
    "cube": lambda: (cube.build(), None),
    "bracket": lambda: (cube.bracket(), None),
}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, epilog="example: assets/make/make.py stick dojo --out /somewhere"
    )
    parser.add_argument("models", nargs="*", metavar="MODEL", help="which (default: all): " + ", ".join(MODELS))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    args = parser.parse_args()
    for unknown in set(args.models) - set(MODELS):
        parser.error(f"unknown model '{unknown}'; there are {', '.join(MODELS)}")
    for name in args.models or MODELS:
        start = time.time()
        parts, rest = MODELS[name]()
        path = args.out / f"{name}.glb"
        glb.write(path, parts, MATERIALS, rest)
        vertices, triangles = sum(len(p.points) for p in parts), sum(len(p.triangles) for p in parts)
        print(f"{path}: {vertices} vertices, {triangles} triangles, {path.stat().st_size / 1e6:.2f} MB, {time.time() - start:.1f} s")


if __name__ == "__main__":
    sys.exit(main())
