"""Rows of the chart of speed against accuracy: the errors that `taut chart --quick` writes."""
import sys
import taut

scene = taut.load(sys.argv[1] if len(sys.argv) > 1 else "scenes/bench_swing.toml")
truth = scene.truth(quick=True)
for settings in taut.sweep("direct", quick=True):
    score = truth.score("direct", **settings)
    print(f"direct,{score.label},{score.outcome},{score.error!r}")
