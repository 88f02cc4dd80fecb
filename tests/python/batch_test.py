"""Thousands of ropes at once."""
import signal
import threading
import unittest

import numpy
import taut


def fan(ropes, particles=6, length=0.6):
    """Ropes that begin at their own points, each in another direction."""
    i = numpy.arange(ropes)
    first = numpy.stack([0.1 * i, numpy.zeros(ropes), numpy.zeros(ropes)], axis=1)
    angle = 0.3 + 2 * i / ropes
    along = numpy.stack([numpy.cos(angle), -numpy.sin(angle), numpy.zeros(ropes)], axis=1)
    return first[:, None] + numpy.linspace(0, length, particles)[None, :, None] * along[:, None]


class Batches(unittest.TestCase):
    def test_ropes_move_as_each_alone(self):
        start = fan(37)
        together = taut.Batch(start, 0.1, 1e-3)
        together.advance(0.3)
        for i in (0, 17, 36):
            alone = taut.Batch(start[i : i + 1], 0.1, 1e-3)
            alone.advance(0.3, threads=1)
            numpy.testing.assert_array_equal(alone.positions[0], together.positions[i])

    def test_agrees_with_the_direct_method(self):
        start = fan(3)
        batch = taut.Batch(start, [0.1, 0.1, 0.2], 2e-4, end_mass=[0, 0.3, 0])
        batch.advance(0.3)
        world = taut.World()
        world.add_connector("rope", start[1], 0.1)
        world.add_mass("rope", -1, 0.3)
        world.hold("rope", 0, point=start[1, 0])
        exact = taut.Simulation(world, "direct", tolerance=1e-8)
        exact.advance(0.3)
        self.assertLess(numpy.abs(batch.positions[1] - exact.positions("rope")).max(), 1e-5)

    def test_one_array_is_brought_up_to_date(self):
        batch = taut.Batch(fan(5), 0.1, 1e-3, dtype="float32")
        positions, velocities = batch.positions, batch.velocities
        self.assertEqual(positions.shape, (5, 6, 3))
        before = positions.copy()
        batch.advance(0.1)
        self.assertTrue(numpy.shares_memory(positions, batch.positions))
        self.assertEqual(batch.time, 0.1)
        self.assertGreater(numpy.abs(positions - before).max(), 0.01)
        self.assertGreater(numpy.abs(velocities).max(), 0.1)

    def test_a_path_carries_the_first_particles(self):
        path = taut.Path([0, 1], [[1, 0, 0], [1, 0, 0.4]], ease=True)
        start = fan(4)
        batch = taut.Batch(start, 0.1, 1e-3, path=path)
        numpy.testing.assert_allclose(batch.positions, start, atol=1e-15)
        batch.advance(0.5)
        moved = path.position(0.5) - path.position(0)
        numpy.testing.assert_allclose(batch.positions[:, 0], start[:, 0] + moved, atol=1e-14)

    def test_ctrl_c_leaves_how_far_it_came(self):
        batch = taut.Batch(fan(500), 0.1, 1e-5)
        threading.Timer(0.2, signal.raise_signal, [signal.SIGINT]).start()
        with self.assertRaises(KeyboardInterrupt):
            batch.advance(1e6)
        self.assertGreater(batch.time, 0)
        again = taut.Batch(fan(500), 0.1, 1e-5)
        again.advance(batch.time)
        numpy.testing.assert_array_equal(batch.positions, again.positions)

    def test_a_step_too_long_diverges(self):
        batch = taut.Batch(fan(3, particles=40), 0.01, 0.1, end_mass=50.0)
        with self.assertRaises(taut.DivergedError):
            batch.advance(20)

    def test_what_cannot_be_is_said(self):
        start = fan(3)
        for message, arguments in {
            "shape (any, any, 3), found (6, 3)": dict(positions=start[0]),
            "mass: expected 1 or 3 numbers, found 2": dict(mass=[1, 2]),
            "step: found 0": dict(step=0),
            "dtype: found \"float16\"": dict(dtype="float16"),
            "velocities: expected the shape of positions": dict(velocities=start[:2]),
        }.items():
            with self.subTest(message), self.assertRaises(taut.ArgumentError) as raised:
                taut.Batch(**{"positions": start, "mass": 0.1, "step": 1e-3, **arguments})
            self.assertIn(message, str(raised.exception))


if __name__ == "__main__":
    unittest.main()
