"""Scenes, trajectories and pictures: the same as the program's."""
import csv
import io
import json
import pathlib
import struct
import tempfile
import unittest
import zlib

import numpy
import taut
from support import SOURCE, SWING, program


def read_png(data):
    """An RGB file of 8 bits as an array (height, width, 3)."""
    width, height, at, packed = 0, 0, 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", body)
            assert (depth, color) == (8, 2)
        if kind == b"IDAT":
            packed += body
        at += length + 12
    rows = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, 1 + 3 * width)
    picture = numpy.zeros((height + 1, width + 1, 3), numpy.int64)
    for y in range(height):
        filtered, line = rows[y, 1:].reshape(width, 3), picture[y + 1]
        kind = rows[y, 0]
        if kind in (0, 2):
            line[1:] = filtered + (picture[y, 1:] if kind == 2 else 0)
        elif kind == 1:
            line[1:] = numpy.cumsum(filtered, axis=0, dtype=numpy.int64)
        else:
            for x in range(1, width + 1):
                left, up, corner = line[x - 1] % 256, picture[y, x], picture[y, x - 1]
                if kind == 3:
                    line[x] = filtered[x - 1] + (left + up) // 2
                else:
                    guess = left + up - corner
                    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
                    near = numpy.where((a <= b) & (a <= c), left, numpy.where(b <= c, up, corner))
                    line[x] = filtered[x - 1] + near
        line %= 256
    return picture[1:, 1:]


class Scenes(unittest.TestCase):
    def test_tell_what_they_are(self):
        scene = taut.load(pathlib.Path(SWING))
        self.assertEqual((scene.file, scene.fps), (SWING, 60))
        self.assertEqual(scene.frames, round(scene.duration * 60))
        self.assertEqual(len(scene.connectors), 1)

    def test_values_in_place_of_the_scene_s(self):
        name = taut.load(SWING).connectors[0]
        scene = taut.load(SWING, {f"connectors.{name}.particles": 7, "title": 'a "b"', "gravity": numpy.zeros(3)})
        self.assertEqual(scene.title, 'a "b"')
        simulation = scene.simulation()
        simulation.advance(0.5)
        self.assertEqual(len(simulation.positions(name)), 7)
        self.assertEqual(simulation.kinetic_energy, 0)

    def test_faults_say_where(self):
        with self.assertRaises(taut.SceneError) as raised:
            taut.load(SWING, {"duration": -1})
        self.assertEqual(raised.exception.key, "duration")
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.toml"
            file.write_text("duration = 1.0\nfpss = 3\ngravity = 4\n")
            found = taut.faults(str(file))
            self.assertEqual([(error.line, error.key) for error in found], [(2, "fpss"), (3, "gravity")])
            self.assertTrue(all(error.file == str(file) and isinstance(error, taut.SceneError) for error in found))
            with self.assertRaisesRegex(taut.SceneError, "wrong.toml:2"):
                taut.load(str(file))
        with self.assertRaises(taut.SceneError):
            taut.load("no such file")

    def test_methods_are_chosen_as_by_the_commands(self):
        scene = taut.load(SWING)
        self.assertEqual(scene.simulation("direct", tolerance=1e-3).settings["tolerance"], 1e-3)
        with self.assertRaisesRegex(taut.ArgumentError, "step 0.005"):
            scene.simulation("xpbd", step=0.005)
        with self.assertRaises(taut.ArgumentError):
            scene.simulation("direct", step="long")


class Trajectories(unittest.TestCase):
    def rows(self, *arguments):
        lines = list(csv.reader(io.StringIO(program("simulate", *arguments, "--no-estimate", "-q"))))
        return lines[0], numpy.array(lines[1:], float)

    def test_are_those_of_the_program_bit_by_bit(self):
        for name, change, options in (
            ("pin", {}, []),  # a pin, and a direct method
            ("two_bodies", {"duration": 0.5}, ["--set", "duration=0.5", "--method", "direct"]),
            ("hose", {}, ["--method", "direct"]),  # and a cut
        ):
            with self.subTest(name):
                file = SOURCE / f"scenes/{name}.toml"
                head, rows = self.rows(file, *options)
                run = taut.load(str(file), change).simulate("direct" if options else "")
                columns = [run.times[:, None]]
                columns += [array.reshape(len(run.times), -1) for array in run.positions.values()]
                columns += list(run.poses.values())
                numpy.testing.assert_array_equal(numpy.hstack(columns), rows)
                self.assertEqual(list(run.positions), list(dict.fromkeys(n.split(".")[0] for n in head if n.count(".") == 2)))

    def test_simulations_of_scenes_end_there_too(self):
        file = SOURCE / "scenes/pin.toml"
        told = json.loads(program("simulate", file, "--json", "--no-estimate"))
        simulation = taut.load(str(file)).simulation()
        before = simulation.positions(simulation.connectors[0])
        simulation.advance((told["frames"] - 1) / 60)
        self.assertEqual(simulation.state_hash, told["state_hash"])
        self.assertTrue(numpy.isfinite(before).all())  # the scene's pin has left it behind
        with self.assertRaisesRegex(taut.ArgumentError, "cuts"):
            simulation.cut(simulation.connectors[0], 0.1)


    def test_rope_passes_pulleys(self):
        scene = taut.load(str(SOURCE / "scenes/topology/tackle.toml"),
                          {"connectors.rope.mass": 0.0, "connectors.rope.particles": 2})
        simulation = scene.simulation()
        simulation.advance(3.0)
        lifted = simulation.pose("block")[1] - 1
        self.assertGreater(lifted, 0.3)
        self.assertAlmostEqual(simulation.passed("lead4") / lifted, 12, delta=0.2)
        with self.assertRaisesRegex(taut.ArgumentError, "no pulley"):
            simulation.passed("none")


class Pictures(unittest.TestCase):
    def test_are_those_of_the_program(self):
        file = SOURCE / "scenes/rope_swing.toml"
        with tempfile.TemporaryDirectory() as folder:
            program("render", file, "--poster", "0.5", "--size", "160x90", "--out", folder, "-q")
            drawn = read_png((pathlib.Path(folder) / "poster.png").read_bytes())
        picture = taut.load(str(file)).render(0.5, size=(160, 90))
        self.assertEqual((picture.shape, picture.dtype), ((90, 160, 4), numpy.uint8))
        numpy.testing.assert_array_equal(picture[:, :, :3], drawn)
        self.assertTrue((picture[:, :, 3] == 255).all())

    def test_show_the_state_of_a_simulation(self):
        scene = taut.load(str(SOURCE / "scenes/rope_swing.toml"))
        renderer = scene.renderer(size=(160, 90))
        self.assertEqual(renderer.size, (160, 90))
        simulation = scene.simulation()
        simulation.advance(0.5)
        numpy.testing.assert_array_equal(renderer.draw(simulation), renderer.frame(0.5))
        other = taut.load(SWING, {"connectors.rope.particles": 5}).simulation()
        with self.assertRaisesRegex(taut.ArgumentError, "other particles"):
            renderer.draw(other)

    def test_are_transparent_where_nothing_is(self):
        scene = taut.load(SWING, {"stage.scenery": []})
        picture = scene.render(0.0, size=(64, 36), transparent=True)
        self.assertEqual((picture[0, 0, 3], picture[:, :, 3].max()), (0, 255))

    def test_what_cannot_be_is_said(self):
        scene = taut.load(str(SOURCE / "scenes/rope_swing.toml"))
        for message, arguments in {
            "time 99": dict(time=99, size=(16, 16)),
            "size: found 0": dict(time=0, size=(0, 16)),
            "samples: found 0": dict(time=0, samples=0),
            "vulkan": dict(time=0, backend="vulkan"),
        }.items():
            with self.subTest(message), self.assertRaisesRegex(taut.ArgumentError, message):
                scene.render(**arguments)


if __name__ == "__main__":
    unittest.main()
