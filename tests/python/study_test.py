"""Rows of the chart, bit by bit."""
import csv
import pathlib
import tempfile
import unittest

import taut
from support import SWING, program


class Charts(unittest.TestCase):
    def test_rows_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            program("chart", SWING, "--quick", "--budget", "2", "--methods", "direct,impulse", "--out", folder, "-q")
            rows = list(csv.DictReader((pathlib.Path(folder) / "chart.csv").read_text().splitlines()))
        truth = taut.load(SWING).truth(quick=True)
        self.assertTrue(0 < truth.self_error < truth.length * 1e-6 < truth.horizon)
        checked = 0
        for method in "direct", "impulse":
            of_method = [row for row in rows if row["method"] == method]
            for settings, row in zip(taut.sweep(method, quick=True), of_method, strict=True):
                if row["outcome"] != "done" or checked >= 6:
                    continue
                score = truth.score(method, **settings)
                self.assertEqual(score.label, row["settings"])
                self.assertEqual(repr(score.error), row["error (share of length)"])
                checked += 1
        self.assertGreaterEqual(checked, 4)

    def test_runs_that_fail_have_a_score(self):
        truth = taut.load(SWING, {"duration": 0.3}).truth(quick=True)
        score = truth.score("springs", stiffness=1e9, step=1 / 60)
        self.assertEqual((score.outcome, score.error), ("diverged", float("inf")))
        self.assertTrue(score.reason)
        self.assertEqual(truth.score("direct", tolerance=1e-4, cap=0.0).outcome, "over its CPU cap")
        with self.assertRaises(taut.ArgumentError):
            truth.score("direct", tolerance=-1)

    def test_methods_are_listed_with_their_settings(self):
        self.assertIn("tolerance", taut.methods()["direct"])
        with self.assertRaises(taut.ArgumentError):
            taut.sweep("sprigs")


if __name__ == "__main__":
    unittest.main()
