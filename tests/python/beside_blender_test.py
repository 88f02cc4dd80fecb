"""Which instant a frame of the clip shows, for pictures beside Blender's."""
import math
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench/pictures"))
import beside_blender  # noqa: E402

PLACE = {"position": [0, 1, 3], "target": [0, 1, 1]}
NEAR = PLACE | {"t": 1.0, "field_of_view": 0.5, "aperture": 2.0}
SCENE = {"duration": 4.0, "fps": 50, "stage": {
    "title": {"duration": 2.0},
    "camera": [PLACE | {"t": 0.0, "field_of_view": 0.7}],
    "shots": [{"from": 0.0, "until": 1.0},
              {"from": 1.0, "until": 2.0, "rate": 0.25,
               "camera": [NEAR, PLACE | {"t": 2.0, "field_of_view": 0.6, "focus": 4}]}]}}


class Frames(unittest.TestCase):
    def test_the_first_follows_the_title(self):
        first = beside_blender.shown(SCENE, 100)
        self.assertEqual((first["time"], first["shot"], first["view"]), (0, 1, 0.7))

    def test_slow_motion_takes_four_frames_for_one(self):
        seen = beside_blender.shown(SCENE, 150 + 20)
        self.assertAlmostEqual(seen["time"], 1.1)
        self.assertEqual((seen["shot"], seen["rate"]), (2, 0.25))

    def test_a_lens_zooms_smoothly(self):
        views = [beside_blender.shown(SCENE, 150 + k)["view"] for k in (0, 100, 199)]
        self.assertEqual(views[0], 0.5)
        self.assertAlmostEqual(views[1], 0.55)  # the middle of the two keys
        self.assertTrue(0.5999 < views[2] < 0.6)

    def test_a_lens_closes_and_focuses_smoothly(self):
        self.assertIsNone(beside_blender.shown(SCENE, 100)["lens"])
        for frame, lens in ((150, [2, 2]), (250, [4, 3])):  # a pinhole's f-number is infinite
            for seen, wanted in zip(beside_blender.shown(SCENE, frame)["lens"], lens):
                self.assertAlmostEqual(seen, wanted)

    def test_an_eye_on_an_orbit_focuses_at_its_distance(self):
        orbit = {"t": 0.0, "target": [0, 1, 1], "orbit": {"distance": 1.5}, "field_of_view": 0.5, "aperture": 2.0}
        for seen, wanted in zip(beside_blender.lens([orbit], 0.5), [2, 1.5]):
            self.assertAlmostEqual(seen, wanted)

    def test_frames_of_no_shot_are_refused(self):
        for frame in (0, 99, 350):
            with self.assertRaises(SystemExit):
                beside_blender.shown(SCENE, frame)

    def test_ten_frames_are_spread_over_all_shots(self):
        frames = beside_blender.spread(SCENE, 10)
        self.assertEqual((frames[0], frames[-1]), (112, 338))
        self.assertEqual({beside_blender.shown(SCENE, f)["shot"] for f in frames}, {1, 2})


class Curve(unittest.TestCase):
    def test_it_rises_from_black(self):
        shades = [float(beside_blender.developed(light)) for light in (0.0, 0.01, 0.1, 1.0, 10.0)]
        self.assertEqual(shades[0], 0)
        self.assertTrue(all(a < b for a, b in zip(shades, shades[1:])))
        self.assertTrue(math.isfinite(shades[-1]))


if __name__ == "__main__":
    unittest.main()
