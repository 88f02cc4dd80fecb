"""Ten thousand ropes of 16 particles swing for a second, in steps of a millisecond."""
import numpy
import taut

ropes, particles, length = 10_000, 16, 0.5
i = numpy.arange(ropes)
first = numpy.stack([0.01 * (i % 100), numpy.full(ropes, 2.0), 0.01 * (i // 100)], axis=1)
along = numpy.stack([numpy.ones(ropes), -1e-4 * i, numpy.full(ropes, 0.5)], axis=1)
along /= numpy.linalg.norm(along, axis=1, keepdims=True)
share = numpy.linspace(0, length, particles)
start = first[:, None, :] + share[None, :, None] * along[:, None, :]

batch = taut.Batch(start, mass=0.05, step=1e-3, dtype="float32")
batch.advance(1.0)
ends = batch.positions[:, -1]  # (10000, 3), brought up to date by advance()
print(f"{ropes} ropes: the lowest end hangs {(first - ends)[:, 1].max():.4f} m below its first particle")
