"""FLIP and SSIM on pictures whose errors are known, and what holds for any picture."""
import pathlib
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench/pictures"))
import picture_error  # noqa: E402


def flat(*color):
    return numpy.tile(numpy.array(color, float), (40, 60, 1))


class PictureError(unittest.TestCase):
    def test_flip_of_even_pictures_is_computed_by_hand(self):
        # Green and blue are as far apart as colours can be: the paper's largest error.
        self.assertAlmostEqual(picture_error.flip(flat(0, 1, 0), flat(0, 0, 1)).mean(), 1, places=9)
        # Black and white: HyAB 100, between (87.735, -75.61, 72.98) and (32.297, 25.57, -34.84) of Hunt's green and
        # blue 203.30; 100^0.7 = 25.119 beyond 0.4 * 41.273, so 0.95 + 0.05 * (25.119 - 16.509) / (41.273 - 16.509).
        error = picture_error.flip(flat(0, 0, 0), flat(1, 1, 1))
        self.assertAlmostEqual(error.mean(), 0.95 + 0.05 * (25.1189 - 16.5092) / (41.2729 - 16.5092), places=4)
        self.assertLess(numpy.ptp(error), 1e-9)

    def test_flip_of_a_picture_and_itself_is_nothing(self):
        picture = numpy.random.default_rng(1).random((40, 60, 3))
        self.assertEqual(picture_error.flip(picture, picture).max(), 0)

    def test_flip_is_symmetric_and_grows_with_the_error(self):
        rng = numpy.random.default_rng(2)
        picture, noise = 0.3 + 0.4 * rng.random((40, 60, 3)), rng.standard_normal((40, 60, 3))
        errors = []
        for amount in (0.01, 0.03, 0.1):
            other = numpy.clip(picture + amount * noise, 0, 1)
            there, back = picture_error.flip(picture, other), picture_error.flip(other, picture)
            self.assertLess(numpy.abs(there - back).max(), 1e-12)
            errors.append(there.mean())
        self.assertLess(errors[0], errors[1])
        self.assertLess(errors[1], errors[2])

    def test_flip_forgives_what_the_eye_cannot_resolve(self):
        # A checkerboard of single pixels beside its mean light: seen from 0.7 m it is grey, from close by it is not.
        board = numpy.indices((64, 64)).sum(axis=0) % 2 * 0.2 + 0.4
        board = numpy.repeat(board[..., None], 3, axis=2)
        mean = picture_error.srgb(picture_error.linear(board).mean()) + 0 * board
        far, near = (picture_error.flip(mean, board, degree).mean() for degree in (67.02, 5))
        self.assertLess(far, 0.5 * near)

    def test_flip_sees_a_line_rather_than_a_slow_change(self):
        plain, line, slow = (numpy.full((64, 64, 3), 0.5) for _ in range(3))
        line[:, 32] += 0.25
        slow += 0.25 / 64
        self.assertGreater(picture_error.flip(plain, line)[:, 32].mean(), 10 * picture_error.flip(plain, slow).mean())

    def test_ssim(self):
        picture = numpy.random.default_rng(3).random((40, 60, 3))
        self.assertAlmostEqual(picture_error.ssim(picture, picture), 1, places=12)
        # Without contrast nothing but the means is left: C1 / (1 + C1).
        self.assertAlmostEqual(picture_error.ssim(flat(0, 0, 0), flat(1, 1, 1)), 1e-4 / (1 + 1e-4), places=12)
        self.assertLess(abs(picture_error.ssim(picture, picture[::-1])), 0.1)


if __name__ == "__main__":
    unittest.main()
