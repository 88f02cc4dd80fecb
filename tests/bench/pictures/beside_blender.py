#!/usr/bin/python3
"""How far pictures are from a path tracer's: frames of a clip by taut and by Blender's two engines.

  tests/bench/pictures/beside_blender.py build/release/taut scenes/nunchaku.toml --out out/results/beside

Cycles, with samples enough to be converged, is the truth; Eevee at 16 samples is the peer. All get the same geometry,
poses, materials, patterns, lights, camera, lens and shutter, and the film curve of taut. Printed is, for each frame,
the FLIP error (0: none) and the SSIM (1: the same) of either against Cycles, and the CPU time that each took; "noise"
is what is left of it in Cycles: its error against half as many samples of another seed. --out keeps taut's, Eevee's
and Cycles's pictures side by side, three of them as sheet.png.

Needs Blender, numpy and a display for Eevee (Debian: blender, xvfb, python3-numpy).

What the two share by agreement: the key light passes through the scenery where the scene has it so; paper glows with
the daylight behind it; wood and paper have their patterns, skin and cloth have not (taut's have).
Eevee has the stage's ambient light in place of bounces, with ambient occlusion and reflections on the screen.
"""
import argparse
import json
import math
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import tomllib

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import picture_error  # noqa: E402

LIGHT = {"direction": [-0.75, -1.1, -0.18], "color": [6.8, 5.3, 3.8], "sky": [0.49, 0.61, 0.82],
         "ground": [0.22, 0.184, 0.15]}  # scenes/scene/stage.h


def shown(scene, frame):
    """What frame `frame` of the clip shows: time (s), rate, number of the shot, field of view (rad) and lens."""
    stage, fps = scene["stage"], scene.get("fps", 60)
    left = frame - round(stage.get("title", {}).get("duration", 0) * fps)
    whole = {"from": 0, "until": scene["duration"]}
    for number, shot in enumerate(stage.get("shots", [whole]), 1):
        rate = shot.get("rate", 1)
        frames = round((shot["until"] - shot["from"]) / rate * fps)
        if 0 <= left < frames:
            time = shot["from"] + left * rate / fps
            keys = shot.get("camera", stage["camera"])
            return {"time": time, "rate": rate, "shot": number if "shots" in stage else 0,
                    "view": between(keys, time, lambda key: key["field_of_view"]), "lens": lens(keys, time)}
        left -= frames
    raise SystemExit(f"frame {frame} is in no shot")


def between(keys, time, value):
    """A camera's value between two keys: it moves smoothly."""
    before = max((k for k in keys if k["t"] <= time), key=lambda k: k["t"], default=keys[0])
    after = min((k for k in keys if k["t"] > time), key=lambda k: k["t"], default=before)
    span = after["t"] - before["t"]
    u = (time - before["t"]) / span if span > 0 else 0
    return value(before) + (3 - 2 * u) * u * u * (value(after) - value(before))


def to_target(key):
    """How far the eye is from what it looks at (m): on an orbit, or where it stands."""
    return key["orbit"]["distance"] if "orbit" in key else math.dist(key["position"], key["target"])


def lens(keys, time):
    """The f-number and the distance of focus (m); none where all is sharp."""
    opening = between(keys, time, lambda key: 1 / key["aperture"] if "aperture" in key else 0)
    focus = between(keys, time, lambda key: key.get("focus") or to_target(key))
    return [1 / opening, focus] if opening > 0 else None


def spread(scene, count):
    """So many frames, evenly over all shots."""
    stage, fps = scene["stage"], scene.get("fps", 60)
    shots = stage.get("shots", [{"from": 0, "until": scene["duration"]}])
    frames = sum(round((s["until"] - s["from"]) / s.get("rate", 1) * fps) for s in shots)
    first = round(stage.get("title", {}).get("duration", 0) * fps)
    return [first + round((i + 0.5) * frames / count) for i in range(count)]


def cpu(command, **options):
    """Runs it; the CPU seconds that it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise SystemExit(f"{command[0]}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def environment():
    """With Blender's folder first: its Python takes its modules from where the first python3 is."""
    blender = shutil.which("blender")
    if not blender:
        raise SystemExit("Blender is missing (Debian: blender)")
    return os.environ | {"PATH": f"{pathlib.Path(blender).parent}:{os.environ['PATH']}"}


def by_taut(options, frames, folder):
    """Pictures without captions and ribbons, and the seconds that one thread took for each."""
    command = [options.taut, "render", options.scene, "--set", "stage.captions=[]", "--set", "stage.trails=[]", "--size",
               options.size, "--anew", "--no-video", "--no-estimate", "--quiet", "--threads", "1", "--out"]
    told = json.loads(subprocess.run([*command, folder / "taut", "--frames", ",".join(map(str, frames)), "--json"],
                                     capture_output=True, text=True, check=True).stdout)
    return [read(folder / f"taut/frames/{f:06}.png") for f in frames], told["seconds_per_frame"]["rendering"]


def read(file):
    """A PNG as sRGB, 0 to 1."""
    size = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=width,height", "-of", "csv=p=0", file],
                          capture_output=True, text=True, check=True).stdout
    width, height = map(int, size.strip().strip(",").split(","))
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                         capture_output=True, check=True).stdout
    return numpy.frombuffer(raw, numpy.uint8).reshape(height, width, 3) / 255


def write(file, picture):
    height, width, _ = picture.shape
    pixels = numpy.round(255 * picture).astype(numpy.uint8).tobytes()
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
                    "-i", "-", str(file)], input=pixels, check=True)


def developed(light):
    """taut's film curve and exposure (render/gl/shaders.cpp, encode) on linear light, as sRGB."""
    x = 0.44 * numpy.maximum(light, 0)
    return picture_error.srgb(x * (2.51 * x + 0.06) / (x * (2.43 * x + 0.59) + 0.14))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taut")
    parser.add_argument("scene")
    parser.add_argument("--frames", type=int, nargs="+", help="of the clip; default: ten, evenly spread")
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--samples", type=int, default=256, help="of Cycles, a pixel")
    parser.add_argument("--out", type=pathlib.Path, help="a folder for the pictures")
    options = parser.parse_args()
    with open(options.scene, "rb") as file:
        scene = tomllib.load(file)
    frames = options.frames or spread(scene, 10)
    views = [shown(scene, f) for f in frames]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cpu([options.taut, "export", options.scene, "--scenery", "-o", folder / "scene.glb", "--quiet"])
        ours, seconds = by_taut(options, frames, folder)
        width, height = map(int, options.size.split("x"))
        stage = scene["stage"]
        job = {"glb": str(folder / "scene.glb"), "fps": scene.get("fps", 60), "size": [width, height], "folder": name,
               "light": LIGHT | stage.get("light", {}), "shutter": stage.get("shutter", 0), "samples": options.samples,
               "scenery": [pathlib.Path(s).stem for s in stage.get("scenery", [])],
               "frames": views}
        (folder / "job.json").write_text(json.dumps(job))
        inside = pathlib.Path(__file__).with_name("in_blender.py")
        cpu(["xvfb-run", "-a", "blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
             inside, "--", folder / "job.json"], env=environment())
        report(options, frames, ours, seconds, folder)


def report(options, frames, ours, seconds, folder):
    times = json.loads((folder / "times.json").read_text())
    heads = ["frame", "FLIP taut", "FLIP Eevee", "noise", "SSIM taut", "SSIM Eevee", "CPU s taut", "Eevee", "Cycles"]
    numbers, pictures = [], []
    for i in range(len(frames)):
        truth, half, eevee = (developed(numpy.load(folder / f"{kind}_{i}.npy")) for kind in ("cycles", "half", "eevee"))
        flips = [picture_error.flip(truth, p).mean() for p in (ours[i], eevee, half)]
        likes = [picture_error.ssim(truth, p) for p in (ours[i], eevee)]
        numbers.append([*flips, *likes, seconds, times["eevee"][i], times["cycles"][i]])
        pictures.append(numpy.concatenate([ours[i], eevee, truth], axis=1))
    rows = [[str(frame), *row] for frame, row in zip(frames, numbers)] + [["mean", *numpy.mean(numbers, axis=0)]]
    forms = [*["{:.3f}"] * 5, "{:.2f}", "{:.0f}", "{:.0f}"]
    cells = [heads] + [[row[0], *(form.format(x) for form, x in zip(forms, row[1:]))] for row in rows]
    for number, row in enumerate(cells):
        print("| " + " | ".join(cell.rjust(10) for cell in row) + " |")
        if number == 0:
            print("|" + "|".join(["---:"] * len(heads)) + "|")
    nearer = sum(row[0] <= row[1] for row in numbers)
    print(f"\ntaut is nearer to Cycles than Eevee in {nearer} of {len(frames)} frames.")
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        for frame, picture in zip(frames, pictures):
            write(options.out / f"{frame:06}.png", picture)
        some = sorted({0, len(frames) // 2, len(frames) - 1})
        write(options.out / "sheet.png", numpy.concatenate([pictures[i] for i in some]))


if __name__ == "__main__":
    main()
