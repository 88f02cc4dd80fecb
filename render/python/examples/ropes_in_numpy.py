"""A rope with a weight swings; its lowest point and its energy, from arrays that are no copies."""
import numpy
import taut

world = taut.World()
world.add_connector("rope", positions=numpy.linspace([0, 0, 0], [1, 0, 0], 21), mass=0.1)
world.add_mass("rope", particle=-1, mass=0.2)
world.hold("rope", particle=0, point=[0, 0, 0])

simulation = taut.Simulation(world, "direct", tolerance=1e-5)
positions = simulation.positions("rope")  # the simulation's own memory: always the present state
for frame in range(121):
    simulation.advance(frame / 60)
    if frame % 30 == 0:
        energy = simulation.kinetic_energy + simulation.potential_energy
        print(f"{simulation.time:.2f} s: lowest {positions[:, 1].min():.4f} m, energy {energy:+.6f} J")
