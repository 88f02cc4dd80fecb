"""A swinging rope is held in its middle for half a second, let go again, and cut."""
import taut

scene = taut.load("scenes/rope_swing.toml", {"duration": 3.0})
simulation = scene.simulation("direct", tolerance=1e-5)
name = simulation.connectors[0]
simulation.advance(0.4)
pin = simulation.pin(name, along=0.1)
simulation.advance(0.9)
simulation.release(pin)
simulation.advance(1.5)
part = simulation.cut(name, along=0.1)
simulation.advance(2.0)
for each in name, part:
    print(each, "ends at", simulation.positions(each)[-1].round(3))
