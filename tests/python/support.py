"""What the tests of the module share."""
import os
import pathlib
import subprocess

import numpy
import taut

SOURCE = pathlib.Path(os.environ["TAUT_SOURCE_DIR"])
PROGRAM = os.environ["TAUT_PROGRAM"]
SWING = str(SOURCE / "scenes/bench_swing.toml")


def program(*arguments):
    """Standard output of taut."""
    return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True, cwd=SOURCE).stdout


def rope(particles=11, length=1.0, mass=0.1):
    """A world with a rope that lies along x and is held at the origin."""
    world = taut.World()
    world.add_connector("rope", numpy.linspace([0, 0, 0], [length, 0, 0], particles), mass)
    world.hold("rope", 0, point=[0, 0, 0])
    return world
