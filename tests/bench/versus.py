#!/usr/bin/python3
"""What an error of the method direct costs in two builds of taut.

Both builds run every scene over the same tolerances, each beside the other in turn. Printed is, per
scene and error, the cheapest tolerance of each build that comes within the error: its CPU time per
simulated second (median), its solves, and what the new build takes of the base's. An error is the
RMS over all particles and frames of the first second, as far as it is predictable, against the
method truth, by the new build.

  tests/bench/versus.py --base ../base/build/release --new build/release
  tests/bench/versus.py --base a --new b scenes/bench_swing.toml --errors 1 --repeats 25 --markdown
"""
import argparse
import csv
import functools
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
TOLERANCES = [m * 10**-p for p in range(0, 6) for m in (1, 0.7, 0.5, 0.4, 0.3, 0.2, 0.14)]  # m
PARTICLE = re.compile(r".*\.\d+\.[xyz]$")


class Failed(Exception):
    """taut, or what it wrote, is not as it should be."""


def taut(build, *arguments):
    """What the build's taut prints, or None where the simulation diverged."""
    command = [str(build / "taut"), *map(str, arguments)]
    done = subprocess.run(command, cwd=SOURCE, capture_output=True, text=True, check=False)
    if done.returncode == 7:
        return None
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def trajectory(build, scene, folder, *method):
    """Rows of the time and all coordinates of particles, or None."""
    file = folder / "trajectory.csv"
    if taut(build, "simulate", scene, "--csv", file, "--json", "--quiet", "--method", *method) is None:
        return None
    with file.open(newline="") as stream:
        rows = csv.reader(stream)
        header = next(rows)
        columns = [0] + [i for i, name in enumerate(header) if PARTICLE.match(name)]
        return [[float(row[i]) for i in columns] for row in rows]


def horizon(build, scene):
    """Until when (s) the motion is predictable, at most a second."""
    [told] = json.loads(taut(build, "classify", scene, "--methods", "direct", "--json", "--quiet"))["scenes"]
    if told["truth_until_s"] is None:
        raise Failed(f"{scene}: nothing is predictable")
    return min(1.0, told["truth_until_s"])


def rms(frames, truth, until):
    """In metres; infinite where the frames end before."""
    if frames is None or len(frames) < len(truth):
        return math.inf
    squares, count = 0.0, 0
    for frame, true in zip(frames, truth):
        if true[0] > until:
            break
        squares += sum((a - b) ** 2 for a, b in zip(frame[1:], true[1:]))
        count += (len(true) - 1) // 3
    return math.sqrt(squares / count)


@functools.cache
def without_estimate(build):
    """What leaves out the run that estimates the error, which builds before it do not know."""
    return ["--no-estimate"] if "--no-estimate" in taut(build, "simulate", "--help") else []


class Setting:
    """One tolerance in one build."""

    def __init__(self, tolerance, error):
        self.tolerance, self.error = tolerance, error
        self.times, self.solves = [], 0

    def run(self, build, scene):
        told = json.loads(taut(build, "simulate", scene, "--method", "direct", "--tolerance",
                               f"{self.tolerance:g}", "--json", "--quiet", *without_estimate(build)))
        self.times.append(told["stepping_ms_per_second"])
        self.solves = told["solves"]

    def cost(self):
        return statistics.median(self.times)


def measured(builds, scene, options, folder):
    """Per build, the settings that come within the largest of the errors, with their costs."""
    truth = trajectory(builds[1], scene, folder, "truth")
    if truth is None:
        raise Failed(f"{scene}: the truth diverged")
    until = horizon(builds[1], scene)
    settings = []
    for build in builds:
        of_build = [Setting(t, rms(trajectory(build, scene, folder, "direct", "--tolerance",
                                              f"{t:g}"), truth, until))
                    for t in options.tolerances]
        settings.append([s for s in of_build if s.error <= max(options.errors) * 1e-3])
    for turn in range(options.repeats):
        for i in range(max(map(len, settings))):
            pairs = [(build, some[i]) for build, some in zip(builds, settings) if i < len(some)]
            for build, setting in pairs if turn % 2 == 0 else reversed(pairs):
                setting.run(build, scene)
    return settings


def rows_of(scene, settings, errors):
    """Rows of the table, and the ratios of costs among them."""
    for error in errors:
        row = [pathlib.Path(scene).stem, f"{error:g} mm"]
        best = []
        for some in settings:
            enough = [s for s in some if s.error <= error * 1e-3]
            best.append(min(enough, key=Setting.cost) if enough else None)
        for one in best:
            row += ([f"{one.tolerance:g}", f"{1e3 * one.error:.2g}", f"{one.solves}",
                     f"{one.cost():.3g}"] if one else ["-"] * 4)
        ratio = best[1].cost() / best[0].cost() if all(best) else None
        yield row + [f"{ratio:.2f}" if ratio else "-"], ratio


def table(rows, markdown):
    head = ["scene", "error"]
    for build in ("base", "new"):
        head += [f"{build} tol. m", "mm", "solves", "ms/s"]
    head.append("new/base")
    if markdown:
        lines = [head, ["---", "---"] + ["---:"] * (len(head) - 2)] + rows
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)
    widths = [max(len(line[i]) for line in [head] + rows) for i in range(len(head))]
    return "\n".join("  ".join(cell.ljust(w) if i < 2 else cell.rjust(w)
                               for i, (cell, w) in enumerate(zip(line, widths))).rstrip()
                     for line in [head] + rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--base", type=pathlib.Path, required=True, help="build folder")
    parser.add_argument("--new", type=pathlib.Path, required=True, help="build folder")
    parser.add_argument("scenes", nargs="*", help="default: those of the tables of engines")
    parser.add_argument("--errors", type=float, nargs="+", default=[10, 1, 0.1], help="mm")
    parser.add_argument("--tolerances", type=float, nargs="+", default=TOLERANCES, help="m")
    parser.add_argument("--repeats", type=int, default=16,
                        help="runs that a median is of; each build goes first in every second")
    parser.add_argument("--markdown", action="store_true", help="the table in Markdown")
    options = parser.parse_args()
    builds = [options.base.resolve(), options.new.resolve()]
    scenes = [pathlib.Path(scene).resolve() for scene in options.scenes] or [
        *(SOURCE / "scenes" / f"bench_{name}.toml" for name in ("swing", "stick", "heavy")),
        *(SOURCE / "tests/bench/engines" / f"{name}.toml"
          for name in ("stick_in_space", "swing_30", "swing_in_space"))]
    rows, ratios = [], []
    try:
        with tempfile.TemporaryDirectory() as folder:
            for scene in scenes:
                settings = measured(builds, scene, options, pathlib.Path(folder))
                for row, ratio in rows_of(scene, settings, options.errors):
                    rows.append(row)
                    ratios += [ratio] if ratio else []
    except (Failed, OSError) as problem:
        sys.exit(f"versus.py: {problem}")
    print(table(rows, options.markdown))
    if ratios:
        print(f"\nnew/base, geometric mean of {len(ratios)}: {statistics.geometric_mean(ratios):.3f}")


if __name__ == "__main__":
    main()
