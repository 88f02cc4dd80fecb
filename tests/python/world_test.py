"""Worlds with contact, materials, joints, winches, pulleys, forces of one's own and breaking."""
import math
import os
import tempfile
import unittest

import numpy
import taut
from support import rope


def line(start, end, particles=6):
    return numpy.linspace(start, end, particles)


class Contact(unittest.TestCase):
    def test_a_bead_slides_on_a_slope_as_friction_lets_it(self):
        # Down a slope of 45 degrees: g (sin - mu cos).
        slope, friction = math.pi / 4, 0.3
        down = numpy.array([math.cos(slope), -math.sin(slope), 0])
        turned = [math.cos(slope / 2), 0, 0, -math.sin(slope / 2)]
        world = taut.World()
        world.add_connector("rope", line([0, 0, 0], 0.2 * down, 3), 0.1)
        world.add_obstacle("floor", plane=True, rotation=turned, friction=friction)
        for method, settings in (("direct", {}), ("xpbd", {"step": 1 / 960})):
            with self.subTest(method):
                simulation = taut.Simulation(world, method, **settings)
                simulation.advance(0.25)
                speed = simulation.velocities("rope") @ down
                self.assertAlmostEqual(speed[1], 9.81 * (math.sin(slope) - friction * math.cos(slope)) * 0.25, 2)

    def test_a_body_rests_on_a_box_and_ignores_another(self):
        world = taut.World()
        world.add_body("ball", 0.2, sphere=0.1, position=[0, 1.06, 0], contact={})
        world.add_obstacle("passed", box=[1, 0.2, 1], position=[0, 1, 0], ignores=["ball"])
        world.add_obstacle("table", box=[1, 0.2, 1], position=[0, 0.5, 0], friction=0.5)
        world.add_connector("rope", line([2, 0, 0], [3, 0, 0]), 0.1)
        simulation = taut.Simulation(world, "direct")
        simulation.advance(1.0)
        self.assertAlmostEqual(simulation.pose("ball")[1], 0.65, 3)
        self.assertEqual(simulation.forces()["contacts"][0]["other"], ("table", ""))

    def test_bodies_and_connectors_touch_where_it_is_said(self):
        world = taut.World(gravity=[0, 0, 0])
        world.add_body("a", 0.2, sphere=0.1, position=[0, 0, 0], velocity=[1, 0, 0], contact={})
        world.add_body("b", 0.2, cylinder=(0.3, 0.1), position=[0.3, 0, 0], contact={})
        world.add_touching(bodies=["a", "b"], restitution=1)
        world.add_connector("rope", line([5, 0, 0], [6, 0, 0]), 0.1)
        simulation = taut.Simulation(world, "direct")
        simulation.advance(0.5)
        self.assertAlmostEqual(simulation.pose("a")[0], 0.2, 3)  # equal masses exchange their speeds
        self.assertAlmostEqual(simulation.pose("b")[0], 0.6, 3)

    def test_ropes_touch_each_other_and_themselves(self):
        world = taut.World()
        world.add_connector("low", line([-0.5, 0, 0], [0.5, 0, 0], 11), 0.2, radius=0.01, touches_itself=True)
        world.hold("low", 0, point=[-0.5, 0, 0])
        world.hold("low", -1, point=[0.5, 0, 0])
        world.add_connector("high", line([0, 0.05, -0.2], [0, 0.05, 0.2], 5), 0.05, radius=0.01)
        world.add_touching(connectors=["low", "high"], friction=0.5)
        simulation = taut.Simulation(world, "xpbd", step=1 / 2400)
        simulation.advance(0.3)
        self.assertGreater(simulation.positions("high")[2, 1], -0.05)


class Materials(unittest.TestCase):
    def test_a_spring_stretches_by_its_load(self):
        world = taut.World()
        world.add_connector("cord", line([0, 0, 0], [0, -1, 0], 2), 1e-6, axial_stiffness=100, axial_damping=100)
        world.add_mass("cord", -1, 0.5)
        world.hold("cord", 0, point=[0, 0, 0])
        simulation = taut.Simulation(world, "direct", tolerance=1e-6)
        simulation.advance(10)
        self.assertAlmostEqual(simulation.positions("cord")[1, 1], -1 - 0.5 * 9.81 / 100, 3)

    def test_a_rod_of_steel_has_its_mass_and_bends_as_a_cantilever(self):
        # The end of a rod that is clamped level sinks by m g L^3 / 8 E I at rest, about which it swings.
        steel = {"youngs_modulus": 2e11, "diameter": 1e-3, "density": 7800}
        length, area = 0.5, math.pi / 4 * 1e-6
        mass = 7800 * area * length
        world = taut.World()
        world.add_connector("rod", line([0, 0, 0], [length, 0, 0], 11), material=steel, bending_damping=2e-4)
        world.hold("rod", 0, point=[0, 0, 0], clamp=[1, 0, 0])
        simulation = taut.Simulation(world, "direct")
        simulation.advance(4)
        stiffness = 2e11 * math.pi / 64 * 1e-12
        sinks = mass * 9.81 * length**3 / (8 * stiffness)
        self.assertAlmostEqual(simulation.positions("rod")[-1, 1] / -sinks, 1, delta=0.1)
        self.assertAlmostEqual(simulation.forces()["holds"][0]["force"][1], mass * 9.81, 3)

    def test_wind_blows_a_kite_s_line(self):
        world = taut.World(gravity=[0, 0, 0])
        world.set_air(1.2, wind=[5, 0, 0])
        world.add_connector("line", line([0, 0, 0], [0, 1, 0]), 0.01, radius=0.005, drag={"across": 1.2})
        world.hold("line", 0, point=[0, 0, 0])
        simulation = taut.Simulation(world)
        simulation.advance(1)
        self.assertGreater(simulation.positions("line")[-1, 0], 0.5)


class JointsAndReels(unittest.TestCase):
    def test_a_joint_keeps_particles_together(self):
        world = rope()
        world.add_connector("branch", line([0.5, 0, 0], [0.5, 0, 0.5]), 0.1)
        world.join("rope", 5, "branch", 0)
        simulation = taut.Simulation(world)
        simulation.advance(0.3)
        numpy.testing.assert_allclose(simulation.positions("rope")[5], simulation.positions("branch")[0], atol=1e-9)
        with self.assertRaisesRegex(taut.ArgumentError, "joined already"):
            world.join("rope", 5, "branch", 0)

    def test_a_winch_pays_out(self):
        world = taut.World()
        world.add_connector("rope", line([0, 0, 0], [0, -1, 0]), 0.1)
        world.hold("rope", 0, point=[0, 0, 0])
        world.add_winch("rope", first=[[0, 0], [0.5, 0.2]])
        simulation = taut.Simulation(world)
        simulation.advance(0.5)
        self.assertAlmostEqual(simulation.positions("rope")[-1, 1], -1.2, 6)

    def test_weights_on_a_pulley_move_as_atwood_s(self):
        # a = g (m2 - m1) / (m1 + m2), with rope without weight.
        world = taut.World()
        world.add_connector("left", line([0, -1, 0], [0, 0, 0], 2), 1e-9)
        world.add_connector("right", line([0, 0, 0], [0, -1, 0], 2), 1e-9)
        world.add_mass("left", 0, 1)
        world.add_mass("right", 1, 2)
        world.hold("left", -1, point=[0, 0, 0])
        world.hold("right", 0, point=[0, 0, 0])
        world.add_pulley("eye", "left", "right")
        self.assertEqual(world.pulleys, ["eye"])
        simulation = taut.Simulation(world)
        simulation.advance(0.5)
        self.assertAlmostEqual(simulation.passed("eye"), 9.81 / 3 * 0.5**2 / 2, 4)


class OwnForces(unittest.TestCase):
    def test_a_spring_of_one_s_own_has_its_period(self):
        stiffness, mass = 50, 1.0
        world = taut.World(gravity=[0, 0, 0])
        world.add_connector("rod", [[0, 0, 0], [1, 0, 0]], mass, velocities=[[0, 0.5, 0]] * 2)
        world.add_force("rod", lambda time, x, v: -stiffness / 2 * x * [0, 1, 0])
        for method, settings in (("direct", {"tolerance": 1e-5}), ("springs", {})):
            with self.subTest(method):
                simulation = taut.Simulation(world, method, **settings)
                simulation.advance(2 * math.pi * math.sqrt(mass / stiffness))
                self.assertLess(numpy.abs(simulation.positions("rod")[:, 1]).max(), 2e-3)

    def test_what_a_force_raises_ends_the_step(self):
        world = rope()
        world.add_force("rope", lambda time, x, v: 1 / 0)
        with self.assertRaises(ZeroDivisionError):
            taut.Simulation(world).advance(0.1)
        world = rope()
        world.add_force("rope", lambda time, x, v: x[:3])
        with self.assertRaisesRegex(taut.ArgumentError, "expected 11 rows, found 3"):
            taut.Simulation(world).advance(0.1)
        with self.assertRaisesRegex(taut.ArgumentError, r"impulse does not follow applied forces \(connector rope\)"):
            taut.Simulation(world, "impulse")


class Breaking(unittest.TestCase):
    def test_a_weight_breaks_a_cord(self):
        world = taut.World()
        world.add_connector("cord", [[0, 0, 0], [1, 0, 0]], 1e-9, breaks_at=1.5 * 0.2 * 9.81)
        world.add_mass("cord", -1, 0.2)
        world.hold("cord", 0, point=[0, 0, 0])
        simulation = taut.Simulation(world, "direct", tolerance=1e-6)
        before, events = simulation.positions("cord"), []
        for frame in range(1, 31):
            simulation.advance(frame / 60)
            events += [event for event in simulation.events if event["kind"] == "break"]
        (event,) = events
        self.assertEqual(event["of"], ("cord", "0"))
        self.assertGreater(event["size"], 1.5 * 0.2 * 9.81)
        self.assertEqual(simulation.connectors, ["cord", "cord'"])
        self.assertEqual(before.shape, (2, 3))


class States(unittest.TestCase):
    def test_a_state_goes_on(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "rope.state")
            whole, first, second = (taut.Simulation(rope(), "springs", step=1e-4) for _ in range(3))
            shown = second.positions("rope")
            whole.advance(0.5)
            first.advance(0.25)
            first.save(file)
            second.load(file)
            self.assertEqual(second.time, 0.25)
            self.assertEqual(shown[-1, 0], 1)  # keeps what it showed
            second.advance(0.5)
            self.assertEqual(second.state_hash, whole.state_hash)
            with self.assertRaisesRegex(taut.AssetError, "rope.state: the state is of another scene"):
                taut.Simulation(rope(12)).load(file)
            with open(file, "r+b") as changed:
                changed.seek(100)
                changed.write(b"\xff")
            with self.assertRaisesRegex(taut.AssetError, "the state is damaged"):
                second.load(file)
            self.assertEqual(second.time, 0.5)


class Messages(unittest.TestCase):
    def test_what_cannot_be_is_said(self):
        world = rope()
        ends = [[0, 0, 0], [1, 0, 0]]
        wrong = {
            "expected one of mass and material": lambda: world.add_connector("b", ends),
            "twisting_stiffness: needs bending_stiffness": lambda: world.add_connector("b", ends, 1, twisting_stiffness=1),
            "material: density is missing": lambda: world.add_connector("b", ends, material={"youngs_modulus": 1, "diameter": 1}),
            "drag: found acros, expected one of: across, along": lambda: world.add_connector("b", ends, 1, drag={"acros": 1}),
            "links: found \"pul\", expected \"rigid\" or \"pull\"": lambda: world.add_connector("b", ends, 1, links="pul"),
            "breaks_at: found 0": lambda: world.add_connector("b", ends, 1, breaks_at=0),
            "touches_itself: needs a radius": lambda: world.add_connector("b", ends, 1, touches_itself=True),
            "friction: needs touches_itself": lambda: world.add_connector("b", ends, 1, friction=1),
            "taper: found 0": lambda: world.add_connector("b", ends, 1, taper=[1, 0]),
            "expected one of plane, sphere": lambda: world.add_obstacle("o"),
            "static_friction: found 0.1, expected at least friction, 0.2":
                lambda: world.add_obstacle("o", plane=True, friction=0.2, static_friction=0.1),
            "rounding: found 1": lambda: world.add_obstacle("o", box=[1, 1, 1], rounding=1),
            "there is no connector \"nobody\"": lambda: world.add_obstacle("o", plane=True, ignores=["nobody"]),
            "expected at least two names": lambda: world.add_touching(connectors=["rope"]),
            "expected first or last": lambda: world.add_winch("rope"),
            "first: found 1 m at the start, expected 0": lambda: world.add_winch("rope", first=[[0, 1], [1, 2]]),
            "turn: needs clamp": lambda: world.hold("rope", 3, point=[0, 0, 0], turn=[[0, 0], [1, 1]]),
            "contact: from and to are missing": lambda: world.add_body("b", 1, box=[1, 1, 1], contact={"radius": 1}),
        }
        for message, call in wrong.items():
            with self.subTest(message), self.assertRaises(taut.ArgumentError) as raised:
                call()
            self.assertIn(message, str(raised.exception))
        self.assertEqual((world.obstacles, world.bodies), ([], []))


if __name__ == "__main__":
    unittest.main()
