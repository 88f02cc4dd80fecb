#!/usr/bin/python3
"""Known answers by engines of rigid bodies: ODE, Bullet, MuJoCo, Simbody. README.md in the folder
above has the protocol.

    build/release/taut verify --engine "ode=tests/answers/engines/rigid_adapter.py ode" --cap 2

It makes a model of rigid bodies of a scene and writes it, line by line (rigid.h has the lines), to the
program taut_rigid, which runs the engine. A rigid link is a body with the mass and the moment of
inertia of half of the bead at each of its ends; ball joints hold the links together. A link that
stretches is a spring between two beads.
"""
import collections
import math
import os
import pathlib
import subprocess
import sys
import tomllib

PROGRAM = pathlib.Path(__file__).resolve().parents[3] / "build/release/taut_rigid"
PICTURES = {"look", "title", "finish"}  # keys that only pictures need
LIGHT = 1e-6  # of the greatest mass: the mass of a link that has none
AXES = {"x": 0, "y": 1, "z": 2}
WORLD, FREE = "world", "free"  # instead of a body: what holds it


class CannotExpress(Exception):
    """The model has nothing for a feature of the scene."""


def only(table, known, where):
    """Refuses keys that this adapter does not know."""
    for key in table:
        if key not in known and key not in PICTURES:
            raise CannotExpress(f"{where} with {key}")


# Vectors are tuples of three numbers, quaternions of four: w, x, y, z. Importing numpy would take
# longer than most runs.


def plus(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b))


def minus(a, b):
    return plus(a, b, -1.0)


def times(factor, a):
    return tuple(factor * x for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def norm(a):
    return math.sqrt(dot(a, a))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a, where):
    length = norm(a)
    if not length > 0:
        raise CannotExpress(f"{where} of no length")
    return times(1 / length, a)


def turned(quaternion, vector):
    w, axis = quaternion[0], quaternion[1:]
    return plus(vector, cross(axis, plus(cross(axis, vector), vector, w)), 2.0)


def turn_between(one, other):
    """The quaternion of the shortest turn from one unit vector to another."""
    w = 1 + dot(one, other)
    if w < 1e-12:
        return (0.0, 1.0, 0.0, 0.0)
    quaternion = (w, *cross(one, other))
    return times(1 / norm(quaternion), quaternion)


class Body:
    """A rigid body. Its axes are those of its principal moments of inertia, its origin the centre of mass."""

    def __init__(self, mass, inertia, position, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0),
                 rotation=(1.0, 0.0, 0.0, 0.0)):
        self.mass, self.inertia = mass, inertia
        self.position, self.rotation, self.velocity, self.spin = position, rotation, velocity, spin
        self.parent, self.joint = FREE, (0.0, 0.0, 0.0)  # what holds it, and where in the world
        self.index = None

    def place(self, point):
        return plus(self.position, turned(self.rotation, point))


class Model:
    """The rigid bodies of a scene."""

    def __init__(self, scene):
        only(scene, {"duration", "gravity", "method", "bodies", "connectors", "obstacles", "touching"}, "a scene")
        self.gravity = tuple(scene.get("gravity", (0.0, -9.81, 0.0)))
        self.all, self.joints, self.springs = [], [], []
        self.shapes, self.obstacles, self.contacts = [], [], []
        self.bodies = {}    # those that have a name
        self.nodes = {}     # (connector, particle): its body, or WORLD, and the point on it
        self.links = {}     # (connector, link): number of its spring
        self.touching = {}  # name of a body or connector: bodies with shapes
        self.scale = greatest_mass(scene)
        hang(scene)
        for name, table in scene.get("bodies", {}).items():
            self.add_body(name, table)
        self.connectors = scene.get("connectors", {})
        starts = {name: self.start(table) for name, table in self.connectors.items()}
        for name, table in self.connectors.items():
            self.add_connector(name, table, *starts[name])
        for name, table in self.connectors.items():
            self.hold(name, table, starts[name][0])
        for table in scene.get("obstacles", {}).values():
            self.add_obstacle(table)
        for table in scene.get("touching", {}).values():
            self.touch(table)
        self.loops = self.make_trees()

    # Bodies and their contacts.

    def add(self, body):
        self.all.append(body)
        return body

    def add_body(self, name, table):
        only(table, {"mass", "shape", "position", "rotation", "velocity", "spin", "contact", "hangs"}, "a body")
        m, (kind, shape) = table["mass"], next(iter(table["shape"].items()))
        if kind == "sphere":
            radius, length = shape["diameter"] / 2, 0.0
            inertia = 3 * (0.4 * m * radius**2,)
        elif kind == "cylinder":
            radius, length = shape["diameter"] / 2, shape["length"]
            across = m * (3 * radius**2 + length**2) / 12
            inertia = (across, m * radius**2 / 2, across)
        elif kind == "box":
            x, y, z = (size**2 for size in shape["size"])
            inertia = (m * (y + z) / 12, m * (x + z) / 12, m * (x + y) / 12)
        else:
            raise CannotExpress(f"a body that is a {kind}")
        state = {key: tuple(table[key]) for key in ("rotation", "velocity", "spin") if key in table}
        body = self.add(Body(m, inertia, tuple(table.get("position", (0.0, 0.0, 0.0))), **state))
        self.bodies[name] = body
        if "contact" in table:
            capsule = table["contact"]
            only(capsule, {"radius", "from", "to"}, "a contact")
            if kind == "box":
                raise CannotExpress("a box that touches")
            radius = capsule.get("radius", radius)
            self.add_shape(name, body, radius, capsule.get("from", (0.0, min(radius - length / 2, 0.0), 0.0)),
                           capsule.get("to", (0.0, max(length / 2 - radius, 0.0), 0.0)))

    def add_shape(self, name, body, radius, start, end):
        """A ball or a capsule on a body."""
        self.shapes.append((body, radius, tuple(start), tuple(end)))
        if body not in self.touching.setdefault(name, []):
            self.touching[name].append(body)

    def add_obstacle(self, table):
        only(table, {"shape", "position", "rotation", "friction", "restitution"}, "an obstacle")
        kind, shape = next(iter(table["shape"].items()))
        if kind not in ("plane", "box"):
            raise CannotExpress(f"an obstacle that is a {kind}")
        self.obstacles.append((shape.get("size", (0.0, 0.0, 0.0)), table.get("position", (0.0, 0.0, 0.0)),
                               table.get("rotation", (1.0, 0.0, 0.0, 0.0))))
        for bodies in self.touching.values():
            for body in bodies:
                self.contacts.append((body, len(self.obstacles) - 1, table.get("friction", 0.0),
                                      table.get("restitution", 0.0)))

    def touch(self, table):
        only(table, {"bodies", "friction", "restitution"}, "a touching table")
        things = [self.touching.get(name, []) for name in table["bodies"]]
        for i, bodies in enumerate(things):
            for others in things[:i]:
                self.contacts += [(body, other, table.get("friction", 0.0), table.get("restitution", 0.0))
                                  for body in bodies for other in others]

    # Connectors.

    def start(self, table):
        """Places and velocities of a connector's particles."""
        only(table, {"length", "mass", "particles", "from", "to", "start", "axial_stiffness", "axial_damping",
                     "radius"}, "a connector")
        for end in ("from", "to"):
            only(table[end], {"fixed", "free", "point_mass", "body", "point", "connector", "at"}, "an end")
        count, start = table["particles"], table.get("start", {})
        only(start, {"direction", "points", "spin"}, "a start")
        if table["length"] == 0:
            return 2 * [self.place_of(table["from"])], 2 * [(0.0, 0.0, 0.0)]
        if "points" in start:
            points = [tuple(point) for point in start["points"]]
        else:
            first = self.place_of(table["from"])
            if "direction" in start:
                points = [first, plus(first, unit(start["direction"], "a direction"), table["length"])]
            elif ("body" in table["to"] or "fixed" in table["to"]) and (count == 2 or "axial_stiffness" in table):
                points = [first, self.place_of(table["to"])]
            else:
                raise CannotExpress("a start that taut computes")
        places = points if len(points) == count else along(points, count)
        if "spin" in start:
            return places, [cross(start["spin"], minus(place, places[0])) for place in places]
        first, last = (self.velocity_of(table[end], place) for end, place in (("from", places[0]), ("to", places[-1])))
        return places, [plus(first, minus(last, first), k / (count - 1)) for k in range(count)]

    def velocity_of(self, end, place):
        if "body" not in end:
            return (0.0, 0.0, 0.0)
        body = self.bodies[end["body"]]
        return plus(body.velocity, cross(body.spin, minus(place, body.position)))

    def place_of(self, end):
        if "fixed" in end:
            return tuple(end["fixed"])
        if "body" in end:
            return self.bodies[end["body"]].place(tuple(end.get("point", (0.0, 0.0, 0.0))))
        raise CannotExpress("a start without places")

    def add_connector(self, name, table, places, velocities):
        if table["length"] == 0:
            return
        links = table["particles"] - 1
        own = [norm(minus(b, a)) for a, b in zip(places, places[1:])]
        masses = (links + 1) * [table["mass"] / (links + 1)]
        for end, particle in (("from", 0), ("to", -1)):
            masses[particle] += table[end].get("point_mass", 0.0)
        if "axial_stiffness" in table:
            self.add_beads(name, table, places, velocities, masses)
            return
        if not all(math.isclose(length, table["length"] / links, rel_tol=1e-6) for length in own):
            raise CannotExpress("a start whose links have other lengths")
        for i in range(links):
            left = masses[i] if i == 0 else masses[i] / 2
            right = masses[i + 1] if i == links - 1 else masses[i + 1] / 2
            if left + right < LIGHT * self.scale:
                left = right = LIGHT * self.scale / 2
            mass, edge = left + right, minus(places[i + 1], places[i])
            centre = plus(places[i], edge, right / mass)
            inertia = max(left * right / mass, LIGHT * mass) * dot(edge, edge)
            spin = cross(edge, minus(velocities[i + 1], velocities[i]))
            body = self.add(Body(mass, 3 * (inertia,), centre,
                                 plus(times(left / mass, velocities[i]), velocities[i + 1], right / mass),
                                 times(1 / dot(edge, edge), spin)))
            upper, lower = minus(places[i], centre), minus(places[i + 1], centre)
            if i > 0:
                self.joints.append((body, self.nodes[name, i][0], places[i]))
            else:
                self.nodes[name, 0] = (body, upper)
            self.nodes[name, i + 1] = (body, lower)
            if "radius" in table:
                if i == 0 and "fixed" not in table["from"]:
                    self.add_shape(name, body, table["radius"], upper, upper)
                self.add_shape(name, body, table["radius"], lower, lower)

    def add_beads(self, name, table, places, velocities, masses):
        if "connector" in table["from"] or "connector" in table["to"]:
            raise CannotExpress("a joint of links that stretch")
        rest = table["length"] / (len(places) - 1)
        for k, (place, velocity) in enumerate(zip(places, velocities)):
            if k == 0 and "fixed" in table["from"] or k == len(places) - 1 and "fixed" in table["to"]:
                self.nodes[name, k] = (WORLD, place)
            else:
                mass = max(masses[k], LIGHT * self.scale)
                bead = self.add(Body(mass, 3 * (1e-3 * mass * table["length"]**2,), place, velocity))
                self.nodes[name, k] = (bead, (0.0, 0.0, 0.0))
                if "radius" in table:
                    self.add_shape(name, bead, table["radius"], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            if k > 0:
                self.links[name, k - 1] = len(self.springs)
                self.springs.append((*self.nodes[name, k - 1], *self.nodes[name, k], rest,
                                     table["axial_stiffness"] / rest, table.get("axial_damping", 0.0) / rest))

    def hold(self, name, table, places):
        """Joins the ends of a connector to what holds them."""
        if table["length"] == 0:
            things = [self.bodies[end["body"]] if "body" in end else WORLD for end in (table["from"], table["to"])]
            if things == [WORLD, WORLD]:
                raise CannotExpress("a joint that holds nothing")
            self.joints.append((*sorted(things, key=lambda thing: thing is WORLD), places[0]))
            return
        for key, particle in (("from", 0), ("to", table["particles"] - 1)):
            end, (body, _) = table[key], self.nodes[name, particle]
            if "fixed" in end and body is not WORLD:
                self.joints.append((body, WORLD, places[particle]))
            elif "body" in end:
                self.joints.append((body, self.bodies[end["body"]], places[particle]))
            elif "connector" in end:
                other = self.connectors[end["connector"]]
                at = end["at"] / other["length"] * (other["particles"] - 1)
                if abs(at - round(at)) > 1e-6 or "axial_stiffness" in other:
                    raise CannotExpress("a joint between particles")
                self.joints.append((body, self.nodes[end["connector"], round(at)][0], places[particle]))

    def make_trees(self):
        """Sorts the bodies into trees that the world or a free body holds. Joints that are left close loops."""
        joints, left, queue, order = collections.defaultdict(list), list(self.joints), collections.deque(), []
        for joint in self.joints:
            for thing in joint[:2]:
                joints[thing].append(joint)

        def grow(thing):
            for joint in joints[thing]:
                one, other, place = joint
                child = other if one is thing else one
                if child is WORLD or child is root or child.parent is not FREE:
                    continue
                child.parent, child.joint = thing, place
                left.remove(joint)
                queue.append(child)
                order.append(child)

        root = None
        for start in [WORLD, *self.all]:
            if start is not WORLD:
                if start.parent is not FREE:
                    continue
                root = start
                order.append(start)
            grow(start)
            while queue:
                grow(queue.popleft())
        self.all = order
        for index, body in enumerate(order):
            body.index = index
        return left

    # What the program reads.

    def row(self, name):
        """The line of a quantity."""
        words = name.split(".")
        thing, last = words[0], words[-1]
        axis = AXES.get(last[-1])
        if len(words) == 2 and thing in self.bodies and axis is not None:
            body = self.bodies[thing].index
            if last in AXES:
                return f"place {body} 0 0 0 {axis}"
            if last[0] in "vw":
                return f"velocity {body} 0 0 0 {axis}" if last[0] == "v" else f"spin {body} {axis}"
        if len(words) == 2 and thing in self.bodies and last in ("qw", "qx", "qy", "qz"):
            return f"turn {self.bodies[thing].index} {'wxyz'.index(last[1])}"
        if len(words) == 3 and words[1].isdigit() and (thing, int(words[1])) in self.nodes and axis is not None:
            body, point = self.nodes[thing, int(words[1])]
            where = f"{-1 if body is WORLD else body.index} {numbers(point)} {axis}"
            if last in AXES or last[0] == "v":
                return f"{'place' if last in AXES else 'velocity'} {where}"
        if len(words) == 3 and last == "tension":
            first = words[1].split("-")[0]
            if first.isdigit() and (thing, int(first)) in self.links:
                return f"tension {self.links[thing, int(first)]}"
            raise CannotExpress("the tension of a rigid link")
        if name in ("kinetic_energy", "elastic_energy", "energy"):
            return name
        if thing == "momentum" and last in AXES:
            return f"momentum {axis}"
        raise CannotExpress(f"the quantity {last if len(words) < 3 else '.'.join(words[1:])}")

    def lines(self, step, asked):
        def index(body):
            return -1 if body is WORLD else -2 if body is FREE else body.index

        yield f"step {step!r}"
        yield f"gravity {numbers(self.gravity)}"
        for b in self.all:
            yield (f"body {b.mass!r} {numbers(b.inertia)} {numbers(b.position)} {numbers(b.rotation)} "
                   f"{numbers(b.velocity)} {numbers(b.spin)} {index(b.parent)} {numbers(b.joint)}")
        for one, other, place in self.loops:
            yield f"loop {index(one)} {index(other)} {numbers(place)}"
        for one, point, other, other_point, *law in self.springs:
            yield f"spring {index(one)} {numbers(point)} {index(other)} {numbers(other_point)} {numbers(law)}"
        for body, radius, start, end in self.shapes:
            yield f"shape {index(body)} {radius!r} {numbers(start)} {numbers(end)}"
        for size, position, rotation in self.obstacles:
            yield f"obstacle {numbers(size)} {numbers(position)} {numbers(rotation)}"
        for body, other, friction, restitution in self.contacts:
            with_what = f"obstacle {other}" if isinstance(other, int) else f"body {other.index}"
            yield f"contact {index(body)} {with_what} {friction!r} {restitution!r}"
        for when, name in asked:
            yield f"row {when} {self.row(name)}"


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def along(points, count):
    """So many places along a polyline, at equal distances of its length."""
    lengths = [norm(minus(b, a)) for a, b in zip(points, points[1:])]
    places, i, before = [], 0, 0.0
    for k in range(count):
        at = sum(lengths) * k / (count - 1)
        while i < len(lengths) - 1 and at > before + lengths[i]:
            before += lengths[i]
            i += 1
        share = (at - before) / lengths[i] if lengths[i] > 0 else 0.0
        places.append(plus(points[i], minus(points[i + 1], points[i]), share))
    return places


def greatest_mass(scene):
    masses = [body["mass"] for body in scene.get("bodies", {}).values()]
    for connector in scene.get("connectors", {}).values():
        masses.append(connector.get("mass", 0.0))
        masses += [connector[end].get("point_mass", 0.0) for end in ("from", "to")]
    return max(masses, default=1.0) or 1.0


def hang(scene):
    """Places the bodies that hang from a connector's end."""
    for name, body in scene.get("bodies", {}).items():
        if "hangs" not in body:
            continue
        down = unit(body["hangs"], "a direction")
        for connector in scene.get("connectors", {}).values():
            if connector["to"].get("body") != name or "fixed" not in connector["from"]:
                continue
            point, end = tuple(connector["to"]["point"]), tuple(connector["from"]["fixed"])
            if connector["length"] > 0:
                direction = unit(connector.get("start", {}).get("direction", (0.0, 0.0, 0.0)), "a direction")
                end = plus(end, direction, connector["length"])
            body["rotation"] = turn_between(unit(times(-1.0, point), "a point"), down)
            body["position"] = minus(end, turned(body["rotation"], point))
            break
        else:
            raise CannotExpress("such a hanging body")


def main():
    engine, (file, step) = sys.argv[1], sys.argv[-2:]
    program = sys.argv[2] if len(sys.argv) > 4 else PROGRAM
    asked = [line.split(",") for line in sys.stdin.read().split()[1:]]
    with open(file, "rb") as text:
        scene = tomllib.load(text)
    try:
        model = "\n".join(Model(scene).lines(float(step), asked)) + "\n"
    except CannotExpress as reason:
        print(f"cannot express: {reason}")
        return 0
    if not os.path.exists(program):
        print(f"{program} is missing: ninja -C build/release taut_rigid", file=sys.stderr)
        return 1
    done = subprocess.run([program, engine], input=model, capture_output=True, text=True, check=False)
    sys.stderr.write(done.stderr)
    if done.returncode < 0:  # the limit of CPU time reaches the engine first: end as it did
        os.kill(os.getpid(), -done.returncode)
    if done.returncode != 0 or done.stdout.startswith("cannot express: "):
        print(done.stdout, end="")
        return 1 if done.returncode != 0 else 0
    *values, cpu = done.stdout.split()
    print("time,quantity,value", *(f"{when},{name},{value}" for (when, name), value in zip(asked, values)), cpu, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
