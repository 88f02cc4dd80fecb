"""Worlds that are built in Python, steps, interventions, arrays without copies."""
import gc
import math
import signal
import threading
import time
import unittest

import numpy
import taut
from support import rope


class Worlds(unittest.TestCase):
    def test_pendulum_has_its_period(self):
        # A rod of two particles, the first held: T = 2 pi sqrt(l / g) (1 + a^2 / 16) to a^4.
        length, angle = 0.5, 0.02
        world = taut.World()
        end = [length * math.sin(angle), -length * math.cos(angle), 0]
        world.add_connector("rod", [[0, 0, 0], end], 0.2)
        world.hold("rod", 0, point=[0, 0, 0])
        period = 2 * math.pi * math.sqrt(length / 9.81) * (1 + angle**2 / 16)
        simulation = taut.Simulation(world, "direct", tolerance=1e-9)
        simulation.advance(period)
        self.assertLess(numpy.abs(simulation.positions("rod")[-1] - end).max(), 1e-7)

    def test_free_fall(self):
        world = taut.World(gravity=[0, 0, -2])
        world.add_connector("rope", [[0, 0, 0], [1, 0, 0], [2, 0, 0]], 0.3, velocities=[[1, 0, 0]] * 3)
        # Semi-implicit Euler falls too far by g dt t / 2, the other two are exact.
        step = 1 / 960
        for method, settings, too_far in (
            ("direct", {}, 0),
            ("dynamic-constraints", {}, 0),
            ("xpbd", {"step": step}, 2 * step * 0.5 / 2),
        ):
            with self.subTest(method):
                simulation = taut.Simulation(world, method, **settings)
                simulation.advance(0.5)
                expected = numpy.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]) + [0.5, 0, -0.25 - too_far]
                self.assertLess(numpy.abs(simulation.positions("rope") - expected).max(), 1e-12)
                self.assertLess(numpy.abs(simulation.velocities("rope") - [1, 0, -1]).max(), 1e-12)

    def test_body_hangs_at_rest(self):
        world = taut.World()
        world.add_body("stick", 0.4, cylinder=(0.3, 0.03), position=[0, -1.15, 0])
        world.add_connector("rope", numpy.linspace([0, 0, 0], [0, -1, 0], 6), 0.1)
        world.hold("rope", 0, point=[0, 0, 0])
        world.hold("rope", -1, body="stick", point=[0, 0.15, 0])
        simulation = taut.Simulation(world, "direct", tolerance=1e-6)
        simulation.advance(1)
        numpy.testing.assert_allclose(simulation.pose("stick"), [0, -1.15, 0, 1, 0, 0, 0], atol=1e-9)
        self.assertEqual(simulation.bodies, ["stick"])

    def test_path_carries_an_end(self):
        path = taut.Path([0, 1], [[0, 0, 0], [0, 0.5, 0]], ease=True)
        world = taut.World()
        world.add_connector("rope", numpy.linspace([0, 0, 0], [0, -1, 0], 6), 0.1)
        world.hold("rope", 0, path=path)
        simulation = taut.Simulation(world)
        simulation.advance(0.4)
        numpy.testing.assert_allclose(simulation.positions("rope")[0], path.position(0.4), atol=1e-15)
        self.assertGreater(path.position(0.4)[1], 0.1)

    def test_positions_of_a_world_write_into_it(self):
        world = rope()
        world.positions("rope")[:, 2] = 3
        world.velocities("rope")[:] = 0
        self.assertEqual(world.positions("rope")[5, 2], 3)

    def test_what_cannot_be_is_said(self):
        world = rope()
        wrong = {
            "expected an array of shape (any, 3), found (2, 2)": lambda: world.add_connector("b", [[0, 0], [1, 1]], 1),
            "expected finite numbers": lambda: world.add_connector("b", [[0, 0, 0], [1, 1, math.nan]], 1),
            "length of a link: found 0": lambda: world.add_connector("b", [[0, 0, 0], [0, 0, 0]], 1),
            "mass: found -1": lambda: world.add_connector("b", [[0, 0, 0], [1, 0, 0]], -1),
            "there is a connector \"rope\" already": lambda: world.add_connector("rope", [[0, 0, 0], [1, 0, 0]], 1),
            "there is no connector \"rop\", expected one of: rope": lambda: world.positions("rop"),
            "particle 11: rope has 11 particles": lambda: world.hold("rope", 11, point=[0, 0, 0]),
            "particle 0 of rope is held already": lambda: world.hold("rope", 0, point=[0, 0, 0]),
            "expected one of cylinder, sphere and box": lambda: world.add_body("b", 1),
            "hold: expected a point, a body or a path": lambda: world.hold("rope", 3),
            "there is no method \"sprigs\", expected one of": lambda: taut.Simulation(world, "sprigs"),
            "stifness": lambda: taut.Simulation(world, "springs", stifness=5),
            "until -1 s": lambda: taut.Simulation(world).advance(-1),
            "point: expected numbers, found <class 'str'>": lambda: world.hold("rope", 3, point="here"),
        }
        for message, call in wrong.items():
            with self.subTest(message), self.assertRaises(taut.ArgumentError) as raised:
                call()
            self.assertIn(message, str(raised.exception))
            self.assertIsInstance(raised.exception, (taut.Error, ValueError))
        with self.assertRaises(TypeError):
            world.hold("rope")


class Forces(unittest.TestCase):
    def test_a_hanging_rope_pulls_with_what_is_below(self):
        world = taut.World()
        world.add_connector("rope", [[0, 0, 0], [0, -1, 0], [0, -2, 0]], 0.3)
        world.hold("rope", 0, point=[0, 0, 0])
        forces = taut.Simulation(world, "direct").forces()
        self.assertLess(numpy.abs(forces["tensions"]["rope"] - 9.81 * numpy.array([0.2, 0.1])).max(), 1e-5)
        (hold,) = forces["holds"]
        self.assertEqual((hold["connector"], hold["particle"]), ("rope", 0))
        self.assertLess(numpy.abs(hold["force"] - [0, 9.81 * 0.3, 0]).max(), 1e-5)
        self.assertEqual(forces["contacts"], [])

    def test_a_rod_that_swings_pulls_three_times_its_weight(self):
        # Of Huygens: released level, at its lowest point m g + m v^2 / l = 3 m g.
        world = taut.World()
        world.add_connector("rod", [[0, 0, 0], [1, 0, 0]], 0.2)
        world.hold("rod", 0, point=[0, 0, 0])
        simulation = taut.Simulation(world, "direct", tolerance=1e-9)
        most = 0
        for step in range(1, 101):
            simulation.advance(step * 0.01)
            most = max(most, simulation.forces()["tensions"]["rod"][0])
        self.assertAlmostEqual(most, 3 * 0.1 * 9.81, delta=0.01)
        self.assertEqual(simulation.events, [])


class Arrays(unittest.TestCase):
    def test_show_the_present_state_without_a_copy(self):
        simulation = taut.Simulation(rope())
        positions, again = simulation.positions("rope"), simulation.positions("rope")
        self.assertTrue(numpy.shares_memory(positions, again))
        self.assertEqual((positions.shape, positions.strides), ((11, 3), (24, 8)))
        before = positions.copy()
        simulation.advance(0.2)
        self.assertLess(positions[-1, 1], before[-1, 1] - 0.1)
        numpy.testing.assert_array_equal(positions, again)

    def test_cannot_be_written(self):
        positions = taut.Simulation(rope()).positions("rope")
        with self.assertRaises(ValueError):
            positions[0, 0] = 1

    def test_outlive_the_simulation(self):
        positions = taut.Simulation(rope()).positions("rope")
        gc.collect()
        numpy.testing.assert_array_equal(positions, numpy.linspace([0, 0, 0], [1, 0, 0], 11))

    def test_keep_what_they_showed_once_particles_change(self):
        simulation = taut.Simulation(rope())
        simulation.advance(0.2)
        positions = simulation.positions("rope")
        kept = positions.copy()
        pin = simulation.pin("rope", 0.55)
        now = simulation.positions("rope")
        self.assertEqual(len(now), 12)
        simulation.advance(0.3)
        simulation.release(pin)
        simulation.cut("rope", 0.45)
        del simulation
        gc.collect()
        numpy.testing.assert_array_equal(positions, kept)
        self.assertTrue(numpy.isfinite(now).all())


class Interventions(unittest.TestCase):
    def test_a_pin_holds_until_it_is_released(self):
        simulation = taut.Simulation(rope(), "direct", tolerance=1e-6)
        simulation.advance(0.2)
        pin = simulation.pin("rope", 0.5)
        held = simulation.positions("rope")[5].copy()
        simulation.advance(0.5)
        numpy.testing.assert_array_equal(simulation.positions("rope")[5], held)
        simulation.move(pin, point=held + [0, 0.05, 0], over=0.1)
        simulation.advance(0.7)
        numpy.testing.assert_allclose(simulation.positions("rope")[5], held + [0, 0.05, 0], atol=1e-15)
        simulation.release(pin)
        simulation.advance(0.8)
        self.assertGreater(numpy.linalg.norm(simulation.positions("rope")[5] - held - [0, 0.05, 0]), 1e-3)
        with self.assertRaises(taut.InterventionError) as raised:
            simulation.release(pin)
        self.assertEqual(raised.exception.time, 0.8)
        self.assertIn("there is no such pin", str(raised.exception))

    def test_what_is_cut_off_falls(self):
        simulation = taut.Simulation(rope(), "direct", tolerance=1e-6)
        simulation.advance(0.3)
        part = simulation.cut("rope", 0.5)
        self.assertEqual(simulation.connectors, ["rope", part])
        masses = numpy.array([0.5] + [1] * 4 + [1])  # what is cut at a particle is shared
        centre = lambda: masses @ simulation.positions(part) / masses.sum()
        before, speed = centre(), masses @ simulation.velocities(part) / masses.sum()
        simulation.advance(0.5)
        fallen = before + speed * 0.2 + numpy.array([0, -9.81, 0]) * 0.2**2 / 2
        numpy.testing.assert_allclose(centre(), fallen, atol=1e-6)

    def test_beyond_reach_is_refused(self):
        with self.assertRaises(taut.InterventionError):
            taut.Simulation(rope()).pin("rope", 0.5, point=[3, 0, 0])


class Running(unittest.TestCase):
    def test_a_long_way_has_the_bits_of_its_frames(self):
        for method, settings in ("direct", {"tolerance": 1e-4}), ("xpbd", {"step": 1 / 960}), ("springs", {}):
            with self.subTest(method):
                once, often = (taut.Simulation(rope(), method, **settings) for _ in range(2))
                once.advance(0.5)
                for frame in range(31):
                    often.advance(frame / 60)
                self.assertEqual(once.state_hash, often.state_hash)

    def test_divergence_says_where(self):
        simulation = taut.Simulation(rope(), "springs", stiffness=1e9, step=1 / 60)
        with self.assertRaises(taut.DivergedError) as raised:
            simulation.advance(10)
        error = raised.exception
        self.assertEqual((error.method, error.connector), ("springs", "rope"))
        self.assertTrue(0 < error.time <= 10 and error.step > 0 and error.link >= 0)

    def test_ctrl_c_ends_a_long_way(self):
        for settings in {"tolerance": 1e-8}, {"step": 1e-5}:
            simulation = taut.Simulation(rope(201), "direct", **settings)
            threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
            begin = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                simulation.advance(1e4)
            self.assertLess(time.monotonic() - begin, 20)
            self.assertGreater(simulation.time, 0)
            simulation.advance(simulation.time + 1e-3)  # it goes on

    def test_ctrl_c_ends_a_frame_that_takes_long(self):
        simulation = taut.Simulation(rope(201), "direct", tolerance=1e-8, fps=1e-3)  # 1000 s
        threading.Timer(0.7, signal.raise_signal, [signal.SIGINT]).start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            simulation.advance(1e6)
        self.assertLess(time.monotonic() - begin, 20)
        with self.assertRaisesRegex(taut.Error, "cannot continue"):
            simulation.advance(1e6)

    def test_other_threads_go_on_meanwhile_and_keep_off(self):
        simulation = taut.Simulation(rope(201), "direct", tolerance=1e-6)
        thread = threading.Thread(target=simulation.advance, args=[1.0])
        thread.start()
        refused = 0
        while thread.is_alive() and not refused:
            try:
                simulation.positions("rope")
            except taut.Error as error:
                self.assertIn("another thread", str(error))
                refused += 1
        thread.join()
        self.assertEqual(simulation.time, 1.0)
        self.assertTrue(refused)


if __name__ == "__main__":
    unittest.main()
