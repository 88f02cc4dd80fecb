#!/usr/bin/env python3
"""Opens the page in a browser without a window and checks what it reports: test.py PAGE PICTURE

The page runs its own test, on #test: for both worlds its hand is dragged for two seconds and rests for two. A picture of
the page at the end is kept. Without a browser the test is skipped (exit code 77).
"""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse

page, picture = map(os.path.abspath, sys.argv[1:])
browser = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
if not browser:
    print("page: skipped, no browser is installed (Debian: chromium)")
    sys.exit(77)

size = os.path.getsize(page)
assert size < 5e6, f"the page has {size} bytes"
with tempfile.TemporaryDirectory() as folder:
    command = [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={folder}",
               "--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1280,1150", "--virtual-time-budget=600000",
               f"--screenshot={picture}", "--dump-dom", f"file://{page}#test"]
    done = subprocess.run(command, capture_output=True, text=True)
found = re.search(r'data-result="([^"]*)"', done.stdout)
if not found:
    message = re.search(r'id="message"[^>]*>([^<]*)', done.stdout)
    sys.exit(f"the page reports no result: {message and message[1]}\n{done.stderr[-2000:]}")
result = json.loads(urllib.parse.unquote(found[1]))
assert result["faults"] == [], result["faults"]
assert [world["name"] for world in result["worlds"]] == ["Nunchaku", "Rope"]
for world in result["worlds"]:
    name = world["name"]
    assert abs(world["time"] - 4) < 1e-9, world["time"]
    assert world["moved"] > 0.05, f"{name}: the hand does not follow the pointer"
    print(f"{name}: the others are at least {world['nearer']:.2g} times as far from the reference as direct for a second")
    runs = {run["method"]: run for run in world["results"]}
    for method, run in runs.items():
        print(f"{name}, {method}: setting {run['setting']:.3g}, {run['cost']:.3g} ms per simulated second, energy changed by "
              f"{run['drift']:.2g} in {run['rested']:.2f} s, stretch {run['stretch']:.2g}, distance {run['distance']:.2g} m")
        assert not run["failed"], run["failed"]
        assert run["finite"] and all(math.isfinite(run[key]) for key in ("drift", "stretch", "distance", "cost"))
        assert run["rested"] > 1, "the hand does not come to rest"
    direct = runs["direct"]
    assert abs(runs["reference"]["drift"]) < 1e-6 and direct["stretch"] < 1e-6
    for method in ("xpbd", "springs"):
        other = runs[method]
        assert 0.8 < other["cost"] / direct["cost"] < 1.25, f"{name}: direct costs {direct['cost']} ms, {method} {other['cost']} ms"
        assert abs(direct["drift"]) < abs(other["drift"]), f"{name}: {method} keeps the energy better than direct"
        assert direct["stretch"] < other["stretch"], f"{name}: {method} keeps the lengths better than direct"
    assert world["nearer"] > 1, f"{name}: direct is not the nearest to the reference in the first second"
    assert world["copied"] < 1e-12, f"{name}: not all states are the reference's"
assert os.path.getsize(picture) > 10000
