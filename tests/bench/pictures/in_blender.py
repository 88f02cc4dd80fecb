"""The part of beside_blender.py that Blender runs: renders the frames of a job by Cycles and by Eevee.

  blender --background --python tests/bench/pictures/in_blender.py -- job.json

Writes cycles_I.npy, half_I.npy and eevee_I.npy, linear light of shape (height, width, 3), and times.json, CPU seconds.
"""
import json
import math
import resource
import sys

import bpy
import numpy

OAK, WOOD, PAPER = ("oak",), ("wood", "floor", "plank", "beam"), ("paper",)
THROUGH = 0.70  # the share of the daylight that comes through paper (render/gl/shaders.cpp)
LUMA = (0.2126, 0.7152, 0.0722)


def lattice(x, y, seed):
    h = (x * 0x8DA6B343) ^ (y * 0xD8163841) ^ (seed * 0xCB1AB31F & 0xFFFFFFFF)
    h &= 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    h = ((h ^ (h >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return ((h ^ (h >> 15)) >> 8) / 2**24


def noise(size=256):
    """The two channels of the renderer's noise (render/draw/shading/surfaces.cpp), as an image."""
    y, x = numpy.mgrid[0:size, 0:size].astype(numpy.uint64)
    pixels = numpy.ones((size, size, 4), numpy.float32)
    for channel, period in ((0, 8), (1, 32)):
        total, amplitude = 0, 0.5
        for octave in range(4):
            u, v = x * period / size, y * period / size
            x0, y0 = numpy.floor(u).astype(numpy.uint64), numpy.floor(v).astype(numpy.uint64)
            s, t = (f * f * (3 - 2 * f) for f in (u - x0, v - y0))
            at = lambda i, j: lattice((x0 + i) % period, (y0 + j) % period, 8 * channel + octave)
            low, high = at(0, 0) * (1 - s) + at(1, 0) * s, at(0, 1) * (1 - s) + at(1, 1) * s
            total = total + amplitude * (low * (1 - t) + high * t)
            amplitude *= 0.5
            period = min(2 * period, size)
        pixels[..., channel] = total / (1 - 2 * amplitude)
    image = bpy.data.images.new("noise", size, size, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.ravel())
    return image


class Nodes:
    """Builds a material's nodes."""

    def __init__(self, material):
        self.tree = material.node_tree
        self.shader = next(n for n in self.tree.nodes if n.type == "BSDF_PRINCIPLED")

    def math(self, operation, a, b):
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, (a, b)):
            self.put(socket, value)
        return node.outputs[0]

    def put(self, socket, value):
        if isinstance(value, (int, float)):
            socket.default_value = value
        else:
            self.tree.links.new(value, socket)

    def smoothstep(self, low, high, value):
        node = self.tree.nodes.new("ShaderNodeMapRange")
        node.interpolation_type = "SMOOTHSTEP"
        for name, x in (("Value", value), ("From Min", low), ("From Max", high)):
            self.put(node.inputs[name], x)
        return node.outputs[0]

    def rest(self):
        """The place at rest, in the model's axes: y up."""
        place = self.tree.nodes.new("ShaderNodeTexCoord")
        split = self.tree.nodes.new("ShaderNodeSeparateXYZ")
        self.tree.links.new(place.outputs["Object"], split.inputs[0])
        x, y, z = split.outputs
        return [x, z, self.math("MULTIPLY", y, -1)]

    def noise(self, image, u, v):
        at = self.tree.nodes.new("ShaderNodeCombineXYZ")
        self.put(at.inputs[0], u)
        self.put(at.inputs[1], v)
        texture = self.tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        self.tree.links.new(at.outputs[0], texture.inputs[0])
        split = self.tree.nodes.new("ShaderNodeSeparateColor")
        self.tree.links.new(texture.outputs[0], split.inputs[0])
        return split.outputs[0], split.outputs[1]

    def tint(self, share):
        """The base colour times a number; returns its socket."""
        socket = self.shader.inputs["Base Color"]
        scale = self.tree.nodes.new("ShaderNodeVectorMath")
        scale.operation = "SCALE"
        if socket.links:
            self.tree.links.new(socket.links[0].from_socket, scale.inputs[0])
        else:
            scale.inputs[0].default_value = socket.default_value[:3]
        self.put(scale.inputs["Scale"], share)
        self.tree.links.new(scale.outputs[0], socket)
        return scale.outputs[0]


def extent(material):
    """Sizes of the box about what has the material, in the model's axes."""
    low, high = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf)
    for item in bpy.data.objects:
        if item.type != "MESH" or material.name not in item.data.materials:
            continue
        slot = item.data.materials.find(material.name)
        for face in item.data.polygons:
            if face.material_index == slot:
                for vertex in face.vertices:
                    x, y, z = item.data.vertices[vertex].co
                    low, high = numpy.minimum(low, (x, z, -y)), numpy.maximum(high, (x, z, -y))
    return high - low


def daylight(light):
    """What shines on paper from behind: as bright as the key light, of the sky's colour."""
    key, sky = (sum(w * c for w, c in zip(LUMA, light[name])) for name in ("color", "sky"))
    return [key / sky * c for c in light["sky"]] if sky > 0 else light["color"]


def rings(nodes, image, axis):
    """A tree's rings and pores, as on turned wood (render/gl/shaders.cpp)."""
    place = nodes.rest()
    x, y, along = place[(axis + 1) % 3], place[(axis + 2) % 3], place[axis]
    across = nodes.math("ADD", x, nodes.math("MULTIPLY", y, 0.6))
    pores, _ = nodes.noise(image, nodes.math("MULTIPLY", along, 5), nodes.math("MULTIPLY", across, 90))
    bent = nodes.noise(image, nodes.math("MULTIPLY", along, 1.3), 0.37)
    squares = []
    for c, pith, bend in zip((x, y), (0.031, 0.012), bent):
        off = nodes.math("ADD", nodes.math("SUBTRACT", c, pith), nodes.math("MULTIPLY", nodes.math("SUBTRACT", bend, 0.5), 0.007))
        squares.append(nodes.math("MULTIPLY", off, off))
    ring = nodes.math("FRACT", nodes.math("DIVIDE", nodes.math("SQRT", nodes.math("ADD", *squares), 0), 0.0024), 0)
    late = nodes.math("MULTIPLY", nodes.smoothstep(0.25, 0.95, ring),
                      nodes.math("SUBTRACT", 1, nodes.smoothstep(0.95, 1, ring)))
    dark = nodes.math("SUBTRACT", 1.24, nodes.math("MULTIPLY", late, 0.78))
    nodes.tint(nodes.math("MULTIPLY", dark, nodes.math("ADD", nodes.math("MULTIPLY", pores, 0.60), 0.70)))


def pattern(material, image, day):
    """What the renderer's surfaces have beyond glTF: streaks of wood, and paper that the day shines through."""
    name, nodes = material.name.lower(), Nodes(material)
    if any(word in name for word in OAK):
        rings(nodes, image, int(numpy.argmax(extent(material))))
    elif any(word in name for word in WOOD):
        sizes = extent(material)
        axis = int(numpy.argmax(sizes))
        scale = 5 if sizes[axis] < 0.7 else 1  # render/draw/shading/drawable.cpp
        place = [nodes.math("MULTIPLY", c, scale) for c in nodes.rest()]
        x, y, along = place[(axis + 1) % 3], place[(axis + 2) % 3], place[axis]
        across = nodes.math("ADD", x, nodes.math("MULTIPLY", y, 0.6))
        r, g = nodes.noise(image, nodes.math("MULTIPLY", along, 0.9), nodes.math("MULTIPLY", across, 9))
        streaks = nodes.math("ADD", nodes.math("MULTIPLY", r, 0.42), nodes.math("MULTIPLY", g, 0.18))
        nodes.tint(nodes.math("ADD", streaks, 0.70))
        rough = nodes.shader.inputs["Roughness"]
        nodes.put(rough, nodes.math("ADD", nodes.math("MULTIPLY", r, -0.25), rough.default_value + 0.125))
    if any(word in name for word in PAPER):
        place = nodes.rest()
        sizes = extent(material)
        x, y = (c for k, c in enumerate(place) if k != int(numpy.argmin(sizes)))
        _, g = nodes.noise(image, nodes.math("MULTIPLY", x, 1.1), nodes.math("MULTIPLY", y, 1.7))
        albedo = nodes.tint(nodes.math("ADD", nodes.math("MULTIPLY", g, 0.12), 0.94))
        glow = nodes.tree.nodes.new("ShaderNodeVectorMath")
        glow.operation = "MULTIPLY"
        nodes.put(glow.inputs[0], albedo)
        glow.inputs[1].default_value = [THROUGH * c for c in day]
        nodes.put(nodes.shader.inputs["Emission"], glow.outputs[0])
        nodes.shader.inputs["Emission Strength"].default_value = 1


def surround(tree, light):
    """Sky above, ground and what it throws back below (surrounding_light in render/draw/shading/lighting.cpp)."""
    direction = light["direction"]
    thrown = 0.35 * max(-direction[1], 0) / math.sqrt(sum(c * c for c in direction))
    below = [g + thrown * g * c for g, c in zip(light["ground"], light["color"])]
    place, split, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "MixRGB"))
    above = tree.nodes.new("ShaderNodeMapRange")
    above.interpolation_type = "SMOOTHSTEP"
    above.inputs["From Min"].default_value, above.inputs["From Max"].default_value = -0.3, 0.3
    mix.inputs[1].default_value, mix.inputs[2].default_value = [*below, 1], [*light["sky"], 1]
    for source, sink in ((place.outputs["Generated"], split.inputs[0]), (split.outputs[2], above.inputs["Value"]),
                         (above.outputs[0], mix.inputs[0]),
                         (mix.outputs[0], tree.nodes["Background"].inputs[0])):
        tree.links.new(source, sink)


def prepare(job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start = job["fps"], 0
    bpy.ops.import_scene.gltf(filepath=job["glb"], import_shading="SMOOTH")  # others fail in Debian 12
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    light = job["light"]
    key = max(light["color"])
    for lamp in (item for item in bpy.data.objects if item.type == "LIGHT"):
        lamp.data.energy = math.pi * key  # W/m^2: a white Lambert surface that faces it has that radiance
        lamp.data.color = [c / key for c in light["color"]]
        lamp.data.angle = 0.0093  # rad, the sun's disc
    image = noise()
    for material in list(bpy.data.materials):
        if material.use_nodes:
            pattern(material, image, daylight(light))
        material.shadow_method = "OPAQUE"
    for item in bpy.data.objects:
        if item.type == "MESH" and item.name.split(".")[0] in job["scenery"] and not light.get("scenery_casts"):
            item.visible_shadow = False
            for material in item.data.materials:
                material.shadow_method = "NONE"
    world = scene.world = bpy.data.worlds.new("around")
    world.use_nodes = True
    surround(world.node_tree, light)
    return scene


def seconds():
    use = resource.getrusage(resource.RUSAGE_SELF)
    return use.ru_utime + use.ru_stime


def render(scene, folder, name):
    """Writes NAME.npy; the CPU seconds that it took."""
    before = seconds()
    scene.render.filepath = f"{folder}/{name}.exr"
    bpy.ops.render.render(write_still=True)
    spent = seconds() - before
    image = bpy.data.images.load(scene.render.filepath)
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    numpy.save(f"{folder}/{name}.npy", pixels.reshape(height, width, image.channels)[::-1, :, :3])
    bpy.data.images.remove(image)
    return spent


def main():
    with open(sys.argv[sys.argv.index("--") + 1]) as file:
        job = json.load(file)
    scene = prepare(job)
    times = {"cycles": [], "eevee": []}
    for i, frame in enumerate(job["frames"]):
        name = f"camera of shot {frame['shot']}" if frame["shot"] else "camera"
        scene.camera = bpy.data.objects[name]
        camera = scene.camera.data
        camera.sensor_fit, camera.sensor_height = "VERTICAL", 24
        camera.angle = frame["view"]
        camera.dof.use_dof = frame["lens"] is not None
        if frame["lens"]:
            camera.dof.aperture_fstop, camera.dof.focus_distance = frame["lens"]
        at = frame["time"] * job["fps"]
        scene.frame_set(int(at), subframe=at - int(at))
        blur = job["shutter"] * frame["rate"]
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = blur > 0, blur

        scene.render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.use_denoising = "CPU", False
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.pixel_filter_type = "BOX"  # a pixel is the mean of its square, as in taut
        for kind, samples, seed in (("half", job["samples"] // 2, 2), ("cycles", job["samples"], 1)):
            scene.cycles.samples, scene.cycles.seed = samples, seed
            spent = render(scene, job["folder"], f"{kind}_{i}")
        times["cycles"].append(spent)

        scene.render.engine = "BLENDER_EEVEE"
        eevee = scene.eevee
        eevee.taa_render_samples = 16
        eevee.use_gtao, eevee.gtao_distance, eevee.use_ssr, eevee.use_soft_shadows = True, 1, True, True
        eevee.use_motion_blur, eevee.motion_blur_shutter, eevee.motion_blur_steps = blur > 0, blur, 8
        scene.render.filter_size = 1
        times["eevee"].append(render(scene, job["folder"], f"eevee_{i}"))
    with open(f"{job['folder']}/times.json", "w") as file:
        json.dump(times, file)


main()
