#!/usr/bin/python3
"""Plays exported GLB files in three.js: is every particle where the simulation had it?

  npm install --prefix /tmp/three three
  tests/bench/export_in_three.py build/release/taut /tmp/three/node_modules/three scenes/rope_swing.toml

Needs Chromium and numpy (Debian: chromium, python3-numpy). A page in headless Chromium loads the file, sets
its AnimationMixer to every eighth frame and to times between them, and is asked for each particle's node.
At frames it is compared with the arrays of --to npz; between them with those of as many more frames a second
as the method's steps allow without another trajectory. Exits with 1 above 1e-6 m and 1e-4 m.
"""

import argparse
import functools
import html
import http.server
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading

import numpy

PAGE = """<!doctype html><script type="importmap">{"imports": {"three": "./three/build/three.module.js"}}</script>
<pre id="result"></pre>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "./three/examples/jsm/loaders/GLTFLoader.js";
const result = document.getElementById("result");
try {
  const { times, nodes } = await (await fetch("asked.json")).json();
  const file = await new GLTFLoader().loadAsync("scene.glb");
  const mixer = new THREE.AnimationMixer(file.scene);
  mixer.clipAction(file.animations[0]).play();
  const found = nodes.map(name => file.scene.getObjectByName(THREE.PropertyBinding.sanitizeNodeName(name)));
  const places = [];
  for (const time of times) {
    mixer.setTime(time);
    file.scene.updateMatrixWorld(true);
    places.push(found.map(node => new THREE.Vector3().setFromMatrixPosition(node.matrixWorld).toArray()));
  }
  result.textContent = JSON.stringify(places);
} catch (error) { result.textContent = "failed: " + error; }
</script>
"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def positions(taut, scene, folder, *options):
    file = folder / "scene.npz"
    subprocess.run([taut, "export", scene, "-o", file, "--quiet", *options], check=True, stdout=subprocess.DEVNULL)
    arrays = numpy.load(file)
    wanted = re.compile(r"connectors/(.*)/positions")
    return arrays["times"], {m[1]: arrays[m[0]] for m in map(wanted.fullmatch, arrays) if m}


def played(folder, times, nodes):
    """[time][node] as the page says."""
    (folder / "asked.json").write_text(json.dumps({"times": list(times), "nodes": nodes}))
    (folder / "index.html").write_text(PAGE)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    page = subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=60000", "--dump-dom",
         f"http://127.0.0.1:{server.server_port}/index.html"],
        check=True, capture_output=True, text=True, timeout=300).stdout
    server.shutdown()
    text = html.unescape(re.search(r'<pre id="result">(.*?)</pre>', page, re.S)[1])
    if not text.startswith("["):
        sys.exit(f"the page says: {text or 'nothing'}")
    return json.loads(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taut")
    parser.add_argument("three", help="the package's folder")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--finer", type=int, default=4, help="states to a frame between which nothing is compared")
    options = parser.parse_args()
    failed = False
    for scene in options.scenes:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            shutil.copytree(options.three, folder / "three", ignore=shutil.ignore_patterns("src", "textures", "fonts"))
            times, at_frames = positions(options.taut, scene, folder)
            fps = round(1 / times[1])
            finer = options.finer
            _, between = positions(options.taut, scene, folder, "--fps", str(fps * finer))
            subprocess.run([options.taut, "export", scene, "-o", folder / "scene.glb", "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
            nodes = [f"{c}.{i}" for c, states in at_frames.items() for i in range(states.shape[1])]
            asked = [(k, part) for k in range(0, len(times) - 1, 8) for part in range(finer)]
            # A key's time is a float.
            when = [float(numpy.float32(times[k])) if part == 0 else (k + part / finer) / fps for k, part in asked]
            errors = [0.0, 0.0]
            for (k, part), places in zip(asked, played(folder, when, nodes)):
                expected = [p for states in (between if part else at_frames).values()
                            for p in states[k * finer + part if part else k]]
                worst = max(math.dist(a, b) for a, b in zip(places, expected))
                errors[part > 0] = max(errors[part > 0], worst)
            print(f"{scene}: {errors[0]:.2g} m at frames, {errors[1]:.2g} m between")
            failed |= errors[0] > 1e-6 or errors[1] > 1e-4
    sys.exit(1 if failed else 0)


main()
