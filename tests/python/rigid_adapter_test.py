"""The rigid bodies that the adapter of other engines makes of scenes."""
import sys
import tomllib
import unittest

from support import SOURCE

ANSWERS = SOURCE / "tests/answers"
sys.path.insert(0, str(ANSWERS / "engines"))
import rigid_adapter  # pylint: disable=wrong-import-position


def scene_of(case):
    return tomllib.loads((ANSWERS / case / "scene.toml").read_text())


def model(case):
    return rigid_adapter.Model(scene_of(case))


class Models(unittest.TestCase):
    def test_rods_are_bodies_in_a_tree(self):
        """Two links of 0.4 m, particles of 0.2 kg, the last with 0.1 kg more: half of a bead belongs to each link."""
        made = model("double_pendulum")
        upper, lower = made.all
        self.assertAlmostEqual(upper.mass, 0.2 + 0.1)
        self.assertAlmostEqual(lower.mass, 0.1 + 0.3)
        self.assertAlmostEqual(upper.inertia[0], 0.2 * 0.1 / 0.3 * 0.4**2)
        self.assertAlmostEqual(upper.position[0], 0.4 * 0.1 / 0.3)
        self.assertAlmostEqual(lower.position[1], 1 - 0.4 * 0.3 / 0.4)
        self.assertIs(upper.parent, rigid_adapter.WORLD)
        self.assertIs(lower.parent, upper)
        for place, wanted in zip(lower.joint, (0.4, 1.0, 0.0)):
            self.assertAlmostEqual(place, wanted)
        self.assertEqual((made.loops, made.springs), ([], []))

    def test_four_bars_close_a_loop(self):
        made = model("four_bar")
        self.assertEqual([rigid_adapter.WORLD] * 2, [body.parent for body in made.all[:2]])
        self.assertEqual([len(made.all), len(made.loops)], [3, 1])

    def test_links_that_stretch_are_springs(self):
        made = model("spring_mass")
        (one, point, bead, _, length, stiffness, _), = made.springs
        self.assertEqual((one, point, length, stiffness), (rigid_adapter.WORLD, (0.0, 1.0, 0.0), 0.5, 20.0 / 0.5))
        self.assertAlmostEqual(bead.mass, 0.02 + 0.3)
        self.assertIs(bead.parent, rigid_adapter.FREE)

    def test_cords_move_with_the_bodies_that_they_hold(self):
        """The bar of the bifilar pendulum spins: the ends of its cords have its velocity."""
        made = model("bifilar")
        cord = made.nodes["left", 1][0]
        lower = rigid_adapter.plus(cord.velocity, rigid_adapter.cross(cord.spin, made.nodes["left", 1][1]))
        for speed, wanted in zip(lower, (0.0, 0.0, 0.9)):
            self.assertAlmostEqual(speed, wanted)

    def test_every_case_is_expressed_or_refused(self):
        expressed = 0
        for file in ANSWERS.glob("*/scene.toml"):
            rows = [row.split(",")[:2] for row in (file.parent / "answer.csv").read_text().splitlines() if row[0] != "#"][1:]
            try:
                lines = list(model(file.parent.name).lines(0.01, rows))
            except rigid_adapter.CannotExpress:
                continue
            expressed += 1
            self.assertEqual(sum(line.startswith("row ") for line in lines), len(rows))
        self.assertGreater(expressed, 40)

    def test_unknown_keys_are_refused(self):
        for part, key in (((), "nets"), (("connectors", "rod"), "sagging"), (("connectors", "rod", "to"), "sagging"),
                          (("connectors", "rod", "start"), "sagging")):
            scene = table = scene_of("pendulum")
            for name in part:
                table = table[name]
            table[key] = 1.0
            with self.assertRaisesRegex(rigid_adapter.CannotExpress, key):
                rigid_adapter.Model(scene)

    def test_degenerate_scenes_are_refused(self):
        scene = scene_of("pendulum")
        scene["connectors"]["rod"]["start"]["direction"] = [0.0, 0.0, 0.0]
        with self.assertRaises(rigid_adapter.CannotExpress):
            rigid_adapter.Model(scene)
        self.assertEqual(rigid_adapter.Model({}).all, [])


if __name__ == "__main__":
    unittest.main()
