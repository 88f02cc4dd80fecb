#!/usr/bin/python3
"""The Open Dynamics Engine (Debian: python3-pyode) on known answers. README.md in the folder above
has the protocol.

    build/release/taut verify --engine ode=tests/answers/engines/ode_adapter.py --cap 2

A rigid link is a body with the mass and the moment of inertia of half of the bead at each of its
ends; ball joints hold the links together. A link that stretches is a spring between two small
bodies. The step is ODE's exact one, dWorldStep.
"""
import math
import sys
import time
import tomllib

import numpy as np
import ode

LIGHT = 1e-9  # of the inertia of what has none in the scene, kg m^2


class CannotExpress(Exception):
    """ODE has nothing for a feature of the scene."""


def only(table, known, where):
    """Refuses keys that this adapter does not know, but for what is for pictures."""
    for key in table:
        if key not in known and key not in {"look", "title", "finish"}:
            raise CannotExpress(f"{where} with {key}")


def turned(quaternion, vector):
    w, axis = quaternion[0], np.array(quaternion[1:])
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + w * vector)


def turn_between(one, other):
    """The quaternion of the shortest turn from one direction to another."""
    one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
    axis, w = np.cross(one, other), 1 + one @ other
    quaternion = np.array([w, *axis]) if w > 1e-12 else np.array([0.0, 1.0, 0.0, 0.0])
    return quaternion / np.linalg.norm(quaternion)


class Scene:
    def __init__(self, scene):
        only(scene, {"duration", "gravity", "method", "bodies", "connectors", "obstacles", "touching"}, "a scene")
        self.world, self.space, self.contacts = ode.World(), ode.SimpleSpace(), ode.JointGroup()
        self.world.setGravity(scene.get("gravity", [0.0, -9.81, 0.0]))
        self.world.setCFM(0.0)
        self.kept, self.geoms, self.touching = [], {}, {}  # what Python must not collect; by id of geom
        self.bodies, self.nodes, self.springs = {}, {}, []  # nodes: (connector, particle) -> things
        for name, table in scene.get("bodies", {}).items():
            self.bodies[name] = self.body(name, table)
        for name, table in scene.get("obstacles", {}).items():
            self.obstacle(name, table)
        for name, table in scene.get("touching", {}).items():
            only(table, {"bodies", "friction", "restitution"}, "a touching table")
            for one in table["bodies"]:
                for other in table["bodies"]:
                    self.touching[one, other] = (table.get("friction", 0.0), table.get("restitution", 0.0))
        self.connectors = scene.get("connectors", {})
        starts = {name: self.start(name, table) for name, table in self.connectors.items()}
        for name, table in self.connectors.items():
            self.connector(name, table, *starts[name])
        for name, table in self.connectors.items():
            self.hold(name, table, starts[name][0])

    # Bodies and what they touch.

    def mass(self, mass, inertia):
        made = ode.Mass()
        made.setParameters(mass, 0, 0, 0, *inertia, 0, 0, 0)
        return made

    def body(self, name, table):
        only(table, {"mass", "shape", "position", "rotation", "velocity", "spin", "contact", "hangs"}, "a body")
        body, m, (kind, shape) = ode.Body(self.world), table["mass"], next(iter(table["shape"].items()))
        if kind == "sphere":
            radius, length = shape["diameter"] / 2, 0.0
            inertia = 3 * [0.4 * m * radius**2]
        elif kind == "cylinder":
            radius, length = shape["diameter"] / 2, shape["length"]
            across = m * (3 * radius**2 + length**2) / 12
            inertia = [across, m * radius**2 / 2, across]
        elif kind == "box":
            x, y, z = (size**2 for size in shape["size"])
            inertia = [m * (y + z) / 12, m * (x + z) / 12, m * (x + y) / 12]
        else:
            raise CannotExpress(f"a body that is a {kind}")
        body.setMass(self.mass(m, inertia))
        body.setQuaternion(table.get("rotation", [1.0, 0.0, 0.0, 0.0]))
        body.setPosition(table.get("position", [0.0, 0.0, 0.0]))
        body.setLinearVel(table.get("velocity", [0.0, 0.0, 0.0]))
        body.setAngularVel(table.get("spin", [0.0, 0.0, 0.0]))
        body.setFiniteRotationMode(1)
        if "contact" in table:
            capsule = table["contact"]
            if kind == "box":
                raise CannotExpress("a box that touches")
            radius = capsule.get("radius", radius)
            start = np.array(capsule.get("from", [0.0, min(radius - length / 2, 0.0), 0.0]))
            end = np.array(capsule.get("to", [0.0, max(length / 2 - radius, 0.0), 0.0]))
            self.geom(body, radius, start, end, name)
        return body

    def geom(self, body, radius, start, end, name):
        """A ball or a capsule on a body."""
        length = np.linalg.norm(end - start)
        shape = (ode.GeomCapsule(self.space, radius, length) if length > 0 else ode.GeomSphere(self.space, radius))
        shape.setBody(body)
        shape.setOffsetPosition((start + end) / 2)
        if length > 0:
            shape.setOffsetQuaternion(turn_between(np.array([0.0, 0.0, 1.0]), end - start))
        self.geoms[id(shape)] = (name, None)
        self.kept.append(shape)

    def obstacle(self, name, table):
        only(table, {"shape", "position", "rotation", "friction", "restitution"}, "an obstacle")
        at, turn = np.array(table.get("position", [0.0, 0.0, 0.0])), table.get("rotation", [1.0, 0.0, 0.0, 0.0])
        kind, shape = next(iter(table["shape"].items()))
        if kind == "plane":
            normal = turned(turn, np.array([0.0, 1.0, 0.0]))
            geom = ode.GeomPlane(self.space, normal, normal @ at)
        elif kind == "box":
            geom = ode.GeomBox(self.space, shape["size"])
            geom.setPosition(at)
            geom.setQuaternion(turn)
        else:
            raise CannotExpress(f"an obstacle that is a {kind}")
        self.geoms[id(geom)] = (None, (table.get("friction", 0.0), table.get("restitution", 0.0)))
        self.kept.append(geom)

    def touch(self, _, one, other):
        (name, law), (other_name, other_law) = self.geoms[id(one)], self.geoms[id(other)]
        law = law or other_law or self.touching.get((name, other_name))
        if law is None or name == other_name:
            return
        for contact in ode.collide(one, other):
            contact.setMode(ode.ContactBounce | ode.ContactApprox1)
            contact.setMu(law[0])
            contact.setBounce(law[1])
            contact.setBounceVel(0.0)
            place, normal = (np.array(part) for part in contact.getContactGeomParams()[:2])
            slip = sum((sign * np.array(geom.getBody().getPointVel(place)) for sign, geom in ((1, one), (-1, other))
                        if geom.getBody()), np.zeros(3))
            slip -= (slip @ normal) * normal
            if slip @ slip > 0:  # ODE's friction is a pyramid: with an edge along the slip it is Coulomb's
                contact.setMode(contact.getMode() | ode.ContactFDir1)
                contact.setFDir1(slip / np.linalg.norm(slip))
            joint = ode.ContactJoint(self.world, self.contacts, contact)
            joint.attach(one.getBody(), other.getBody())

    # Connectors.

    def start(self, name, table):
        """Places and velocities of a connector's particles."""
        only(table, {"length", "mass", "particles", "from", "to", "start", "axial_stiffness", "axial_damping",
                     "radius"}, "a connector")
        for end in ("from", "to"):
            only(table[end], {"fixed", "free", "point_mass", "body", "point", "connector", "at"}, "an end")
        count, start = table["particles"], table.get("start", {})
        only(start, {"direction", "points", "spin"}, "a start")
        if table["length"] == 0:
            return np.array(2 * [self.place_of(table["from"])]), np.zeros((2, 3))
        if "points" in start:
            points = np.array(start["points"])
        else:
            first = self.place_of(table["from"])
            if "direction" in start:
                direction = np.array(start["direction"])
                points = [first, first + table["length"] * direction / np.linalg.norm(direction)]
            elif ("body" in table["to"] or "fixed" in table["to"]) and count == 2 or "axial_stiffness" in table:
                points = [first, self.place_of(table["to"])]
            else:
                raise CannotExpress("a start that taut computes")
        points = np.array(points)
        along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        if len(points) == count:
            places = points
        else:
            places = np.array([[np.interp(s, along, points[:, axis]) for axis in range(3)]
                               for s in np.linspace(0, along[-1], count)])
        return places, np.cross(start.get("spin", [0.0, 0.0, 0.0]), places - places[0])

    def place_of(self, end):
        if "fixed" in end:
            return np.array(end["fixed"])
        if "body" in end:
            return np.array(self.bodies[end["body"]].getRelPointPos(end.get("point", [0, 0, 0])))
        raise CannotExpress("a start without places")

    def connector(self, name, table, places, velocities):
        if table["length"] == 0:
            return
        stretches = "axial_stiffness" in table
        links = table["particles"] - 1
        own = np.linalg.norm(np.diff(places, axis=0), axis=1)
        if not stretches and not np.allclose(own, table["length"] / links, rtol=1e-6):
            raise CannotExpress("a string that starts slack" if own.sum() < table["length"] else "such a start")
        masses = np.full(links + 1, table["mass"] / (links + 1))
        for end, particle in (("from", 0), ("to", -1)):
            masses[particle] += table[end].get("point_mass", 0.0)
        if stretches:
            self.beads(name, table, places, velocities, masses)
            return
        for i in range(links):
            halves = masses[i:i + 2] / 2
            if i == 0:
                halves[0] *= 2
            if i == links - 1:
                halves[1] *= 2
            mass, along = halves.sum(), places[i + 1] - places[i]
            if mass <= 0:
                halves, mass = np.full(2, 1e-6), 2e-6
            centre = (halves @ places[i:i + 2]) / mass
            inertia = max(halves[0] * halves[1] / mass * (along @ along), LIGHT)
            body = ode.Body(self.world)
            body.setMass(self.mass(mass, 3 * [inertia]))
            body.setPosition(centre)
            body.setLinearVel((halves @ velocities[i:i + 2]) / mass)
            body.setAngularVel(np.cross(along, velocities[i + 1] - velocities[i]) / (along @ along))
            body.setFiniteRotationMode(1)
            for k in (i, i + 1):
                self.nodes.setdefault((name, k), []).append((body, places[k] - centre))
            if "radius" in table:
                for k in (0, 1) if i == 0 else (1,):
                    if not (i + k == 0 and "fixed" in table["from"]):
                        at = places[i + k] - centre
                        self.geom(body, table["radius"], at, at, name)
        for k in range(1, links):
            self.join(self.nodes[name, k][0], self.nodes[name, k][1], places[k])

    def beads(self, name, table, places, velocities, masses):
        if "fixed" not in table["from"] and "connector" in table["from"] or "connector" in table["to"]:
            raise CannotExpress("a joint of links that stretch")
        for k, (place, velocity) in enumerate(zip(places, velocities)):
            held = "fixed" in table["from" if k == 0 else "to"] and k in (0, len(places) - 1)
            body = ode.Body(self.world)
            body.setMass(self.mass(masses[k], 3 * [1e-3 * masses[k] * table["length"]**2]))
            body.setPosition(place)
            body.setLinearVel(velocity)
            if held:
                body.setKinematic()
            if "radius" in table and not held:
                self.geom(body, table["radius"], np.zeros(3), np.zeros(3), name)
            self.nodes[name, k] = [(body, np.zeros(3))]
            if k > 0:
                rest = table["length"] / (len(places) - 1)
                self.springs.append((self.nodes[name, k - 1][0][0], body, rest, table["axial_stiffness"] / rest,
                                     table.get("axial_damping", 0.0) / rest))

    def join(self, one, other, place):
        joint = ode.BallJoint(self.world)
        joint.attach(one[0], other[0] if other else ode.environment)
        joint.setAnchor(place)
        self.kept.append(joint)

    def hold(self, name, table, places):
        """Joins the ends of a connector to what holds them."""
        count, is_joint = table["particles"], table["length"] == 0
        if is_joint:
            ends = [table["from"], table["to"]]
            things = [(self.bodies[end["body"]], None) if "body" in end else None for end in ends]
            things.sort(key=lambda thing: thing is None)
            self.join(things[0], things[1], places[0])
            return
        for key, particle in (("from", 0), ("to", count - 1)):
            end, thing = table[key], self.nodes[name, particle][0]
            if "axial_stiffness" in table:
                if "body" in end:
                    self.join(thing, (self.bodies[end["body"]], None), places[particle])
            elif "fixed" in end:
                self.join(thing, None, places[particle])
            elif "body" in end:
                self.join(thing, (self.bodies[end["body"]], None), places[particle])
            elif "connector" in end:
                other = self.connectors[end["connector"]]
                at = end["at"] / other["length"] * (other["particles"] - 1)
                if abs(at - round(at)) > 1e-6 or "axial_stiffness" in other:
                    raise CannotExpress("a joint between particles")
                self.join(thing, self.nodes[end["connector"], round(at)][0], places[particle])

    # Its motion.

    def step(self, dt):
        for one, other, rest, stiffness, damping in self.springs:
            along = np.subtract(other.getPosition(), one.getPosition())
            length = math.sqrt(along @ along)
            rate = along @ np.subtract(other.getLinearVel(), one.getLinearVel()) / length
            force = (stiffness * (length - rest) + damping * rate) / length * along
            one.addForce(force)
            other.addForce(-force)
        self.contacts.empty()
        if self.geoms:
            self.space.collide(None, self.touch)
        self.world.step(dt)

    def quantity(self, name):
        """A function that tells the quantity now."""
        words = name.split(".")
        axis = {"x": 0, "y": 1, "z": 2}
        thing, last = words[0], words[-1]
        if len(words) == 2 and thing in self.bodies:
            body = self.bodies[thing]
            if last in axis:
                return lambda: body.getPosition()[axis[last]]
            if last[0] == "q":
                return lambda: body.getQuaternion()["wxyz".index(last[1])]
            if last[0] == "v":
                return lambda: body.getLinearVel()[axis[last[1]]]
            if last[0] == "w":
                return lambda: body.getAngularVel()[axis[last[1]]]
        if len(words) == 3 and words[1].isdigit() and (thing, int(words[1])) in self.nodes:
            body, at = self.nodes[thing, int(words[1])][0]
            if last in axis:
                return lambda: body.getRelPointPos(at)[axis[last]]
            if last[0] == "v":
                return lambda: body.getRelPointVel(at)[axis[last[1]]]
        raise CannotExpress(f"the quantity {last if len(words) < 3 else '.'.join(words[1:])}")


def hang(scene):
    """Places the bodies that hang from a connector's end."""
    for name, body in scene.get("bodies", {}).items():
        if "hangs" not in body:
            continue
        down = np.array(body["hangs"]) / np.linalg.norm(body["hangs"])
        for connector in scene["connectors"].values():
            if connector["to"].get("body") != name or "fixed" not in connector["from"]:
                continue
            point = np.array(connector["to"]["point"])
            direction = np.array(connector.get("start", {}).get("direction", [0.0, 0.0, 0.0]), float)
            length = np.linalg.norm(direction)
            end = np.array(connector["from"]["fixed"]) + connector["length"] * direction / (length or 1)
            body["rotation"] = list(turn_between(-point, down))
            body["position"] = list(end - turned(body["rotation"], point))
            break
        else:
            raise CannotExpress("such a hanging body")


def main():
    file, step = sys.argv[1], float(sys.argv[2])
    asked = [line.split(",") for line in sys.stdin.read().split()[1:]]
    with open(file, "rb") as text:
        scene = tomllib.load(text)
    try:
        hang(scene)
        simulation = Scene(scene)
        quantities = [simulation.quantity(name) for _, name in asked]
    except CannotExpress as reason:
        print(f"cannot express: {reason}")
        return
    now, begun, rows = 0.0, time.process_time(), []
    for (when, name), quantity in zip(asked, quantities):
        left = float(when) - now
        count = max(1, math.ceil(left / step - 1e-9)) if left > 0 else 0
        for _ in range(count):
            simulation.step(left / count)
        now = float(when)
        rows.append(f"{when},{name},{quantity():.17g}")
    print("time,quantity,value", *rows, f"cpu_s,{time.process_time() - begun:.6g}", sep="\n")


if __name__ == "__main__":
    main()
