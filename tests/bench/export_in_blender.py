"""Exports a scene and opens it in Blender: is every particle where the simulation had it, and every bone of the
BVH where the glTF file has it?

blender --background --factory-startup --python tests/bench/export_in_blender.py -- \
    build/release/taut scenes/rope_swing.toml scenes/nunchaku.toml

Needs Blender and numpy (Debian: blender, python3-numpy). Prints the largest distance (m) of a particle
at any frame from the arrays of --to npz, for each format that this Blender reads; exits with 1 where
one is above 1e-6 m (a joint: 1e-4 m).
"""

import builtins
import math
import os
import subprocess
import sys
import tempfile

import bpy
import numpy

LIMIT = 1e-6  # m, of a particle: Blender keeps places in single precision
JOINT_LIMIT = 1e-4  # m: rotations in the glTF file have 16 bits


def y_up(point):
    """A place in Blender, whose z is up, in the scene's axes."""
    return (point[0], point[2], -point[1])


def export(taut, scene, file):
    subprocess.run([taut, "export", scene, "-o", file, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return file


def empty_scene(fps):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = fps
    bpy.context.scene.frame_start = 0


def largest_error(names, expected, place_of):
    """place_of(connector, particle) is asked at some frames, the last among them."""
    worst = 0.0
    frames = len(expected[names[0]])
    for frame in sorted(set(range(0, frames, max(frames // 40, 1))) | {frames - 1}):
        bpy.context.scene.frame_set(frame)
        for name in names:
            for particle, position in enumerate(expected[name][frame]):
                worst = max(worst, math.dist(y_up(place_of(name, particle)), position))
    return worst


def in_glb(file, fps, names, expected):
    empty_scene(fps)
    bpy.ops.import_scene.gltf(filepath=file, import_shading="SMOOTH")  # others fail in Debian 12
    bones = {bone.name: (rig, bone) for rig in bpy.data.objects if rig.type == "ARMATURE" for bone in rig.pose.bones}

    def place(name, particle):
        node = f"{name}.{particle}"
        if node in bones:  # the joints of a tube
            rig, bone = bones[node]
            return (rig.matrix_world @ bone.matrix).translation
        return bpy.data.objects[node].matrix_world.translation

    return largest_error(names, expected, place)


def in_pc2(file, fps, names, expected):
    empty_scene(fps)
    first, count = {}, 0
    for name in names:
        first[name] = count
        count += expected[name].shape[1]
    mesh = bpy.data.meshes.new("particles")
    mesh.from_pydata([(0, 0, 0)] * count, [(i, i + 1) for i in range(count - 1)], [])
    cloud = bpy.data.objects.new("particles", mesh)
    bpy.context.collection.objects.link(cloud)
    cache = cloud.modifiers.new("cache", "MESH_CACHE")
    cache.cache_format, cache.filepath, cache.frame_start = "PC2", file, 0
    cloud.rotation_euler.x = math.pi / 2
    places = {}

    def place(name, particle):
        frame = bpy.context.scene.frame_current
        if frame not in places:
            shown = cloud.evaluated_get(bpy.context.evaluated_depsgraph_get())
            places.clear()
            places[frame] = [shown.matrix_world @ v.co for v in shown.data.vertices]
        return places[frame][first[name] + particle]

    return largest_error(names, expected, place)


def in_usda(file, fps, names, expected):
    if not hasattr(bpy.types, "WM_OT_usd_import") and "usd_import" not in dir(bpy.ops.wm):
        return None
    empty_scene(fps)
    bpy.ops.wm.usd_import(filepath=file)

    def place(name, particle):
        curve = bpy.data.objects[name]
        shown = curve.evaluated_get(bpy.context.evaluated_depsgraph_get())
        points = [p for spline in shown.data.splines for p in spline.points]
        return shown.matrix_world @ points[particle].co.xyz

    return largest_error(names, expected, place)


def joints(frames):
    """[frame][name] of the joints of the scene's armatures."""
    places = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        places.append({
            bone.name: tuple(rig.matrix_world @ bone.head)
            for rig in bpy.data.objects if rig.type == "ARMATURE" for bone in rig.pose.bones
        })
    return places


def in_bvh(file, glb, fps, frames):
    """The largest distance of a joint from the one of the same name in the glTF file."""
    some = range(0, frames, max(frames // 20, 1))
    empty_scene(fps)
    bpy.ops.import_scene.gltf(filepath=glb, import_shading="SMOOTH")
    expected = joints(some)
    empty_scene(fps)
    # Blender 3.4 opens it in a mode that Debian's Python no longer has.
    plain = builtins.open
    builtins.open = lambda name, mode="r", *more, **others: plain(name, mode.replace("U", ""), *more, **others)
    bpy.ops.import_anim.bvh(filepath=file)  # from frame 1 on
    builtins.open = plain
    found = joints(frame + 1 for frame in some)
    return max(math.dist(place, there[name]) for there, here in zip(expected, found) for name, place in here.items())


def main():
    taut, *scenes = sys.argv[sys.argv.index("--") + 1 :]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            at = lambda suffix: os.path.join(folder, "scene." + suffix)
            arrays = numpy.load(export(taut, scene, at("npz")))
            expected = {
                key.split("/")[1]: arrays[key] for key in arrays if key.startswith("connectors/") and key.endswith("positions")
            }
            fps = round(1 / arrays["times"][1])
            for read, suffix in ((in_glb, "glb"), (in_pc2, "pc2"), (in_usda, "usda")):
                try:
                    error = read(export(taut, scene, at(suffix)), fps, list(expected), expected)
                except AttributeError as missing:  # built without that importer
                    error = None
                    print(f"{scene} {suffix}: {missing}")
                print(f"{scene} {suffix}: " + ("not read by this Blender" if error is None else f"{error:.2g} m"))
                failed |= error is not None and error > LIMIT
            if subprocess.run([taut, "export", scene, "-o", at("bvh"), "--quiet"], capture_output=True).returncode == 0:
                error = in_bvh(at("bvh"), at("glb"), fps, len(arrays["times"]))
                print(f"{scene} bvh: {error:.2g} m")
                failed |= error > JOINT_LIMIT
    sys.exit(1 if failed else 0)


main()
