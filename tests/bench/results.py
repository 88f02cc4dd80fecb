#!/usr/bin/env python3
"""Writes every table and picture of the results, each with machine, date and commit.

The README.md files have places for them, between <!-- results: NAME --> and <!-- /results -->.
A place is written as soon as its commands have ended; where one fails, the place keeps what it has.

  tests/bench/results.py                all of them: about an hour on two cores
  tests/bench/results.py swing hard     these alone
  tests/bench/results.py --list         names, places and the commands behind them
  tests/bench/results.py --check        whether every result has its place, and what no clock measures is up to date
"""
import argparse
import datetime
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from markdown_tables import cells
import results_engines  # adds its results
import results_gallery
from results_tables import ANIMATIONS, RESULTS, Failed, check_animation, check_pictures

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PLACE = re.compile(r"<!-- results: ([a-z-]+) -->\n(.*?)<!-- /results -->\n", re.DOTALL)


class Workshop:
    """Runs the programs of a build, and remembers what it ran."""

    def __init__(self, build):
        self.build = build
        self.source, self.out = SOURCE, SOURCE / "out/results"
        self.commands = []

    def run(self, command, codes=(0,), **environment):
        """What the command prints. Its first word is a program of the build, or of the system."""
        command = command.replace(f"{SOURCE}/", "")  # where it runs; a page names no machine's paths
        self.commands.append(command)
        words = shlex.split(command)
        if "--out" in words:  # files of an earlier run would be read on into
            folder = SOURCE / words[words.index("--out") + 1]
            if self.out in folder.parents:
                shutil.rmtree(folder, ignore_errors=True)
        program = next((p for p in (self.build / words[0], self.build / "tests/bench" / words[0],
                                    self.build / "tests" / words[0]) if p.is_file()), words[0])
        done = subprocess.run([str(program), *words[1:]], cwd=SOURCE, capture_output=True, text=True, check=False,
                              env=os.environ | environment)
        if done.returncode not in codes:
            raise Failed(f"{command}: exit code {done.returncode}\n{done.stderr.strip()[-2000:]}")
        return done.stdout

    def place(self, result):
        """What stands there now."""
        text = (SOURCE / result.page).read_text()
        for name, body in PLACE.findall(text):
            if name == result.name:
                return body
        raise Failed(f"{result.page} has no place <!-- results: {result.name} -->")

    def table(self, result):
        """The rows of the first table at the result's place, the header among them."""
        return cells(self.place(result))

    def write(self, result):
        self.place(result)
        self.commands = []
        load = os.getloadavg()[0]
        body = result.make(self).strip("\n") + "\n"
        if result.measured:
            body += "\n" + stamp(self.commands, load) + "\n"
        page = SOURCE / result.page
        text = PLACE.sub(lambda m: f"<!-- results: {m[1]} -->\n{body}<!-- /results -->\n" if m[1] == result.name
                         else m[0], page.read_text())
        part = page.with_suffix(".md.part")
        part.write_text(text)
        part.replace(page)

    def check(self, result):
        old = self.place(result)
        if result.measured:
            if not re.search(r"^\*Measured \d{4}-\d\d-\d\d at [0-9a-f]{7,}, \d+ cores of .*, load [\d.]+: `.*\*$", old, re.MULTILINE):
                raise Failed(f"{result.page}: the place has no line with date, commit and machine")
            return
        if old.strip() != result.make(self).strip():
            raise Failed(f"{result.page}: is not up to date; tests/bench/results.py {result.name} writes it")


def stamp(commands, load):
    def git(*words):
        return subprocess.run(["git", *words], cwd=SOURCE, capture_output=True, text=True, check=True).stdout.strip()
    commit = git("rev-parse", "--short", "HEAD")
    if git("status", "--porcelain", "--untracked-files=no", "--", "sim", "scenes", "render", ":!*.md"):
        commit += " with changes"
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    machine = f"{os.cpu_count()} cores of {model[1] if model else os.uname().machine}, load {load:.1f}"
    lines = "; ".join(f"`{command}`" for command in commands)
    return f"*Measured {datetime.date.today()} at {commit}, {machine}: {lines}*"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="which results; default: all")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release",
                        help="the build whose programs run; default: build/release")
    parser.add_argument("--list", action="store_true", help="name the results and end")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 where a place is missing or stale")
    options = parser.parse_args()
    for name in options.names:
        if name not in RESULTS:
            parser.error(f"there is no result {name}, expected some of: {', '.join(RESULTS)}")
    workshop = Workshop(options.build.resolve())
    failures = 0
    for name in options.names or RESULTS:
        result = RESULTS[name]
        if options.list:
            print(f"{name:14} {result.page:22} {result.make.__doc__}")
            continue
        try:
            if options.check:
                workshop.check(result)
            else:
                print(f"{name}: {result.make.__doc__}", flush=True)
                workshop.write(result)
        except (Failed, OSError, ValueError, KeyError, IndexError) as problem:
            print(f"results.py: {name}: {type(problem).__name__}: {problem}", file=sys.stderr)
            failures += 1
    if options.check:
        pages = [page for page in SOURCE.rglob("README.md") if "build" not in page.relative_to(SOURCE).parts]
        checks = [lambda name=name: check_animation(SOURCE, name) for name in ANIMATIONS]
        for check in [*checks, lambda: check_pictures(SOURCE, pages)]:
            try:
                check()
            except (Failed, OSError) as problem:
                print(f"results.py: {problem}", file=sys.stderr)
                failures += 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
