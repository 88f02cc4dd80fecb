#!/usr/bin/python3
"""Known answers of scenes, computed without taut. README.md beside this file says how.

    tests/answers/answers.py pendulum            writes pendulum/answer.csv
    tests/answers/answers.py                     those of all cases
    tests/answers/answers.py --check             computes all again and compares with the files
    tests/answers/answers.py --vary FOLDER       writes every case at other parameters into FOLDER
    tests/answers/answers.py --links FOLDER      writes cases with other numbers of links, and the continuum's answers
    tests/answers/answers.py --random 7 5 FOLDER writes every case at five draws of seed 7 into FOLDER
    tests/answers/answers.py --set connectors.rope.length=0.7 --to FOLDER pendulum

A case's answer.py has a function answer(scene): the scene as tomllib reads it in, a list of rows
(time, quantity, value, tolerance) out. It computes the values by two routes and compares them. Its
list VARIED has changes of the scene at which it is right as well; --random draws parameters between the scene's
and one of these changes, or of DRAWN, where not all have a middle. Where links refine, continuum(scene) gives the answer of infinitely many, and LINKS names
the numbers at which --links writes the case. A scene whose start depends on its other numbers has it from
prepared(scene).
"""

import argparse
import copy
import importlib.util
import pathlib
import sys
import tomllib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
COLUMNS = "time,quantity,value,tolerance"


# What answers share: comparison, integration, roots, elliptic functions, particles on rods.


def agree(one, other, tolerance, what="the two routes"):
    """Fails where two results differ by more than `tolerance`."""
    gap = np.max(np.abs(np.asarray(one, float) - np.asarray(other, float)))
    if not gap <= tolerance:
        raise AssertionError(f"{what} differ by {gap:.3g}, expected at most {tolerance:.3g}")


def gravity(scene):
    return np.array(scene.get("gravity", [0.0, -9.81, 0.0]), float)


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def frames(scene, count=4):
    """`count` times, even, up to the scene's end."""
    return [scene["duration"] * (k + 1) / count for k in range(count)]


def places(times, name, states, tolerance, axes="xyz"):
    """Rows of the places of something at all times."""
    return [(t, f"{name}.{axis}", state["xyz".index(axis)], tolerance)
            for t, state in zip(times, states) for axis in axes]


def _midpoint(f, t, y, h, n):
    """Gragg's modified midpoint rule: n substeps of a step h."""
    s = h / n
    before, now = y, y + s * f(t, y)
    for k in range(1, n):
        before, now = now, before + 2 * s * f(t + k * s, now)
    return 0.5 * (now + before + s * f(t + h, now))


def integrate(f, y, times, t=0.0, tolerance=1e-12):
    """y' = f(t, y) from y at t: the states at `times` (Bulirsch and Stoer's extrapolation)."""
    y = np.asarray(y, float)
    h, states, columns = 1e-2, [], 7
    for end in times:
        while t < end:
            h = min(h, end - t)
            table = []
            for k in range(columns):
                n = 2 * (k + 1)
                row = [_midpoint(f, t, y, h, n)]
                for j, last in enumerate(table[-1] if table else []):
                    ratio = (n / (n - 2 * (j + 1))) ** 2
                    row.append(row[-1] + (row[-1] - last) / (ratio - 1))
                table.append(row)
            scale = tolerance * np.maximum(1.0, np.abs(y))
            error = np.max(np.abs(table[-1][-1] - table[-1][-2]) / scale)
            if error <= 1:
                t, y = (end if h == end - t else t + h), table[-1][-1]
            h *= min(4.0, max(0.2, 0.9 * (1 / max(error, 1e-12)) ** (1 / (2 * columns - 1))))
            if error > 1 and not h > 1e-9:
                raise AssertionError(f"the integration stops at {t} s")
        states.append(y)
    return np.array(states)


def root(g, low, high):
    """The root of g between two values of different sign (bisection and secants)."""
    g_low, g_high = g(low), g(high)
    if not g_low * g_high <= 0:
        raise AssertionError(f"no root between {low} and {high}")
    for k in range(200):
        middle = 0.5 * (low + high)
        if k % 3 and g_high != g_low:
            middle = high - g_high * (high - low) / (g_high - g_low)
        if not low <= middle <= high or high - low < 1e-15 * max(1.0, abs(high)):
            break
        g_middle = g(middle)
        if g_low * g_middle <= 0:
            high, g_high = middle, g_middle
        else:
            low, g_low = middle, g_middle
    return 0.5 * (low + high)


def event(f, y, t, g, step, until):
    """The time and the state at which g(t, y) first passes zero from above, found in steps."""
    while t < until:
        later = integrate(f, y, [t + step], t)[0]
        if g(t + step, later) <= 0:
            at = root(lambda s: g(s, integrate(f, y, [s], t)[0] if s > t else y), t, t + step)
            return at, integrate(f, y, [at], t)[0] if at > t else y
        t, y = t + step, later
    raise AssertionError(f"no event until {until} s")


def quadrature(f, low, high, points=60):
    """The integral of a smooth function (Gauss and Legendre)."""
    x, w = np.polynomial.legendre.leggauss(points)
    middle, half = 0.5 * (high + low), 0.5 * (high - low)
    return half * sum(wk * f(middle + half * xk) for xk, wk in zip(x, w))


def elliptic_k(m):
    """The complete elliptic integral of the first kind, of the parameter m (the AGM)."""
    a, b = 1.0, np.sqrt(1 - m)
    while abs(a - b) > 1e-15:
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return np.pi / (2 * a)


def jacobi(u, m):
    """sn, cn, dn of u and the parameter m (Abramowitz and Stegun 16.4)."""
    a, c, b = [1.0], [np.sqrt(m)], np.sqrt(1 - m)
    while abs(c[-1]) > 1e-15:
        a_next, c_next = 0.5 * (a[-1] + b), 0.5 * (a[-1] - b)
        b = np.sqrt(a[-1] * b)
        a.append(a_next)
        c.append(c_next)
    phi = 2 ** (len(a) - 1) * a[-1] * u
    for n in range(len(a) - 1, 0, -1):
        phi = 0.5 * (phi + np.arcsin(c[n] / a[n] * np.sin(phi)))
    return np.sin(phi), np.cos(phi), np.sqrt(1 - m * np.sin(phi) ** 2)


def pendulum_angles(start, rate, times):
    """The angles (rad, from below) of a pendulum that starts at rest; `rate` is that of small swings (rad/s).

    By elliptic functions, and by integrating theta'' = -rate^2 sin(theta).
    """
    k = np.sin(start / 2)
    states = integrate(lambda t, s: np.array([s[1], -rate**2 * np.sin(s[0])]), [start, 0], times)
    angles = [2 * np.arcsin(k * jacobi(elliptic_k(k * k) - rate * t, k * k)[0]) for t in times]
    for angle, state in zip(angles, states):
        agree(angle, state[0], 1e-9)
    return angles


def between_keys(keys, name, t):
    """A motion between two keys, from rest to rest: value, rate and second derivative at t. It is the
    polynomial of fifth degree (that of least jerk: Flash and Hogan, 1985)."""
    (start, low), (end, high) = [(key["t"], np.asarray(key[name], float)) for key in keys]
    h = end - start
    u = min(max((t - start) / h, 0.0), 1.0)
    return (low + (high - low) * u**3 * (10 - 15 * u + 6 * u * u),
            (high - low) / h * 30 * u**2 * (1 - u) ** 2,
            (high - low) / h**2 * 60 * u * (1 - u) * (1 - 2 * u))


class Particles:
    """Point masses on rigid rods, in Cartesian coordinates with Lagrange's multipliers."""

    def __init__(self, points, masses, rods, force, velocities=None):
        """A mass of infinity: a point that stays. rods: pairs of points. force(t, x, v)."""
        self.x = np.array(points, float)
        self.v = np.zeros_like(self.x) if velocities is None else np.array(velocities, float)
        self.w = 1 / np.array(masses, float)
        self.rods, self.force = rods, force

    def accelerations(self, t, x, v):
        """The accelerations, and the tension of each rod."""
        free = self.w[:, None] * self.force(t, x, v)
        if not self.rods:
            return free, np.zeros(0)
        jacobian = np.zeros((len(self.rods),) + x.shape)
        bias = np.zeros(len(self.rods))
        for k, (i, j) in enumerate(self.rods):
            e, de = x[j] - x[i], v[j] - v[i]
            jacobian[k, i], jacobian[k, j] = -e, e
            bias[k] = de @ de
        flat = jacobian.reshape(len(self.rods), -1)
        inverse = np.repeat(self.w, x.shape[1])
        multiplier = np.linalg.solve(flat * inverse @ flat.T, flat @ free.ravel() + bias)
        a = free - (inverse * (multiplier @ flat)).reshape(x.shape)
        lengths = [np.linalg.norm(x[j] - x[i]) for i, j in self.rods]
        return a, multiplier * lengths

    def run(self, times):
        """Places and velocities at the times: arrays [time][point][axis]."""
        shape, size = self.x.shape, self.x.size

        def f(t, y):
            x, v = y[:size].reshape(shape), y[size:].reshape(shape)
            return np.concatenate([v.ravel(), self.accelerations(t, x, v)[0].ravel()])

        y = integrate(f, np.concatenate([self.x.ravel(), self.v.ravel()]), times)
        return y[:, :size].reshape(-1, *shape), y[:, size:].reshape(-1, *shape)


# Chains of links that bend, at rest (Bergou and others, Discrete elastic rods, 2008).


def bend_moment(ei, s, angle, rest=0.0):
    """The moment of a bend of the length s, and its slope; `rest` is the curvature at rest (1/m)."""
    tangent, squared = np.tan(angle / 2), 1 / np.cos(angle / 2) ** 2
    c = 2 * tangent - rest * s
    return ei / s * c * squared, ei / s * (squared**2 + c * tangent * squared)


class Rest:
    """A chain of equal links in a plane at rest: Newton's method on the angles of the links, with Lagrange's
    multipliers for held places and for the floor, which only presses."""

    def __init__(self, l, weights, ei=0.0, rest=0.0, start=None, clamp=None, last_clamp=None, end=None, floor=None,
                 supports=None):
        """weights: N, of all particles. start: the place of the first particle, without one it is loose along y.
        clamp, last_clamp: angles. end: the place of the last particle. floor: the height of beads that lie;
        supports: those above the floor, all without a list."""
        # In units of a link's length and of the mean weight.
        self.unit, self.force = l, np.mean(weights)
        self.l, self.weights, self.ei, self.rest = 1.0, np.asarray(weights, float) / self.force, ei / (self.force * l * l), rest * l
        self.start, self.end = (None if place is None else np.array(place) / l for place in (start, end))
        self.clamp, self.last_clamp, self.floor = clamp, last_clamp, None if floor is None else floor / l
        self.n = len(weights) - 1
        self.supports = range(0 if start is None else 1, self.n + 1) if supports is None else supports

    def places(self, q):
        x0, y0 = (0.0, q[-1]) if self.start is None else self.start
        steps = self.l * np.array([np.cos(q[: self.n]), np.sin(q[: self.n])]).T
        return np.vstack([[x0, y0], [x0, y0] + np.cumsum(steps, axis=0)])

    def bends(self):
        """Of each bend: the links before and after, -1 for a clamp; its length."""
        found = [(k, k + 1, self.l) for k in range(self.n - 1)]
        if self.clamp is not None:
            found.append((-1, 0, self.l / 2))
        if self.last_clamp is not None:
            found.append((self.n - 1, -1, self.l / 2))
        return found

    def slopes(self, q):
        """Of the energy: gradient and second derivatives; and those of the heights and of x of the end."""
        n, size, l = self.n, len(q), self.l
        g, h = np.zeros(size), np.zeros((size, size))
        beyond = np.cumsum(self.weights[::-1])[::-1][1:]
        g[:n] = beyond * l * np.cos(q[:n])
        h[range(n), range(n)] = -beyond * l * np.sin(q[:n])
        if size > n:
            g[n] = np.sum(self.weights)
        for before, after, s in self.bends() if self.ei else []:
            first = q[before] if before >= 0 else self.clamp
            angle = (q[after] if after >= 0 else self.last_clamp) - first
            moment, slope = bend_moment(self.ei, s, angle, self.rest)
            for i, si in ((before, -1), (after, 1)):
                if i < 0:
                    continue
                g[i] += si * moment
                for j, sj in ((before, -1), (after, 1)):
                    if j >= 0:
                        h[i, j] += si * sj * slope
        return g, h

    def solve(self, q, closed):
        """The equilibrium where `closed` are the beads on the floor: q, the forces of the floor, of the end."""
        n, size, l = self.n, len(q), self.l
        count = len(closed) + (0 if self.end is None else 2)
        force = np.zeros(count)
        for _ in range(300):
            g, h = self.slopes(q)
            places = self.places(q)
            rows, gaps = np.zeros((count, size)), np.zeros(count)
            for c in range(count):
                is_x = self.end is not None and c == count - 2
                k = closed[c] if c < len(closed) else n
                if is_x:
                    rows[c, :k] = -l * np.sin(q[:k])
                    h[range(k), range(k)] += force[c] * l * np.cos(q[:k])
                    gaps[c] = places[k][0] - self.end[0]
                else:
                    rows[c, :k] = l * np.cos(q[:k])
                    rows[c, n:] = 1
                    h[range(k), range(k)] += force[c] * l * np.sin(q[:k])
                    gaps[c] = places[k][1] - (self.floor if c < len(closed) else self.end[1])
            matrix = np.block([[h, -rows.T], [rows, np.zeros((count, count))]])
            step = np.linalg.lstsq(matrix, -np.concatenate([g - rows.T @ force, gaps]), rcond=1e-13)[0]
            share = min(1.0, 0.2 / max(1e-300, np.max(np.abs(step[:n]))))
            q, force = q + share * step[:size], force + share * step[size:]
            if np.max(np.abs(step[:size])) < 1e-12 and share == 1.0:
                return q, force
        raise AssertionError("the shape at rest is not found")

    def find(self, q, closed=()):
        """From the angles q (and the height of the first particle, if it is loose): places, forces of the floor by
        bead, force that holds the end."""
        q, closed = np.array(q, float), list(closed)
        q[self.n:] /= self.unit
        for _ in range(200):
            q, force = self.solve(q, closed)
            floor = dict(zip(closed, force))
            low = [k for k in self.supports if self.floor is not None and k not in closed
                   and self.places(q)[k][1] < self.floor - 1e-12]
            if any(f < -1e-12 for f in floor.values()):
                closed.remove(min(floor, key=floor.get))
            elif low:
                closed = sorted(closed + [min(low, key=lambda k: self.places(q)[k][1])])
            else:
                floor = {k: f * self.force for k, f in floor.items()}
                return self.places(q) * self.unit, floor, force[len(closed):] * self.force
        raise AssertionError("the beads that lie are not found")


def bends_energy(x, l, ei, clamp=None, last_clamp=None, rest=0.0):
    """The energy of all bends of links of the length l at rest, in space; `rest` as a vector or 0."""
    edges = np.diff(x, axis=0)
    ways = edges / np.linalg.norm(edges, axis=1)[:, None]
    lengths = np.full(len(ways) - 1, l)
    if clamp is not None:
        ways, lengths = np.vstack([clamp, ways]), np.append(l / 2, lengths)
    if last_clamp is not None:
        ways, lengths = np.vstack([ways, last_clamp]), np.append(lengths, l / 2)
    c = 2 * np.cross(ways[:-1], ways[1:]) / (1 + np.sum(ways[:-1] * ways[1:], axis=1))[:, None]
    c = c - np.outer(lengths, rest * np.ones(3))
    return np.sum(ei * np.sum(c * c, axis=1) / (2 * lengths))


def forces_of_energy(energy, x, step=1e-6):
    """Minus the gradient of energy(x) by central differences."""
    forces = np.zeros_like(x)
    for k in np.ndindex(x.shape):
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        forces[k] = (energy(behind) - energy(ahead)) / (2 * step)
    return forces


def tensions_at_rest(x, forces, held):
    """The tensions of rigid links with which all particles that are not held are in balance, the forces of the
    holds, and the largest force that nothing balances (in points of space, force by force)."""
    ways = np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1)[:, None]
    n = len(ways)
    matrix = np.zeros(x.shape + (n,))
    for k in range(n):
        matrix[k, :, k], matrix[k + 1, :, k] = ways[k], -ways[k]
    free = [k for k in range(n + 1) if k not in held]
    tensions = np.linalg.lstsq(matrix[free].reshape(-1, n), -forces[free].ravel(), rcond=None)[0]
    left = forces + matrix @ tensions
    return tensions, {k: -left[k] for k in held}, np.max(np.abs(left[free]))


def in_space(places):
    """Places (x, y) with z = 0."""
    return np.hstack([places, np.zeros((len(places), 1))])


def beam_stiffness(n, l, ei, first=True, last=False):
    """The stiffness matrix of small motions across of a straight chain of n links that bends: of the places of
    all its particles and, where the last end has a clamp, of the clamp's angle. first: whether the first end has one."""
    matrix = np.zeros((n + 2, n + 2))
    links = np.zeros((n, n + 2))
    for k in range(n):
        links[k, k], links[k, k + 1] = -1 / l, 1 / l
    bends = [(links[k + 1] - links[k], l) for k in range(n - 1)]
    if first:
        bends.append((links[0], l / 2))
    if last:
        turn = np.zeros(n + 2)
        turn[-1] = 1
        bends.append((turn - links[-1], l / 2))
    for bend, s in bends:
        matrix += ei / s * np.outer(bend, bend)
    return matrix


def swings(mass, stiffness, start, speed, times):
    """Places and speeds of M u'' + K u = 0 at the times, by the ways to swing and by integration."""
    root_mass = np.linalg.cholesky(mass)
    inner = np.linalg.solve(root_mass, np.linalg.solve(root_mass, stiffness).T)
    squares, ways = np.linalg.eigh((inner + inner.T) / 2)
    rates = np.sqrt(np.maximum(squares, 0) + 0j)
    back = np.linalg.solve(root_mass.T, ways)
    a, b = back.T @ mass @ start, back.T @ mass @ speed
    places = []
    for t in times:
        rises = np.where(np.abs(rates) > 0, np.sin(rates * t) / np.where(np.abs(rates) > 0, rates, 1), t)
        places.append((back @ (a * np.cos(rates * t) + b * rises)).real)
    n, matrix = len(start), np.linalg.solve(mass, stiffness)
    other = integrate(lambda t, y: np.append(y[n:], -matrix @ y[:n]), np.append(start, speed), times, 0.0, 1e-11)
    agree(np.array(places), other[:, :n], 1e-7 * (1e-9 + np.max(np.abs(other[:, :n]))))
    return places


# Cases.


def load_scene(folder):
    with open(folder / "scene.toml", "rb") as file:
        return tomllib.load(file)


def load_case(folder):
    sys.path.insert(0, str(HERE))
    spec = importlib.util.spec_from_file_location(f"case_{folder.name}", folder / "answer.py")
    module = importlib.util.module_from_spec(spec)
    sys.dont_write_bytecode = True
    spec.loader.exec_module(module)
    return module


def changed(scene, changes):
    """The scene with values in place of its own, by their dotted keys."""
    scene = copy.deepcopy(scene)
    for key, value in changes.items():
        *way, last = key.split(".")
        table = scene
        for name in way:
            table = table.setdefault(name, {})
        table[last] = value
    return scene


def between(own, other, share):
    """The value at a share of the way from one to the other; whole numbers stay whole. What has no middle is the
    other."""
    if isinstance(own, dict) and isinstance(other, dict) and own.keys() == other.keys():
        return {key: between(own[key], other[key], share) for key in own}
    if isinstance(own, list) and isinstance(other, list) and len(own) == len(other):
        return [between(a, b, share) for a, b in zip(own, other)]
    if any(isinstance(value, bool) or not isinstance(value, (int, float)) for value in (own, other)):
        return copy.deepcopy(other)
    value = own + share * (other - own)
    return round(value) if isinstance(own, int) and isinstance(other, int) else float(value)


def value_at(scene, key):
    """The value of a dotted key, or None."""
    for name in key.split("."):
        scene = scene.get(name) if isinstance(scene, dict) else None
    return scene


def drawn(module, scene, rng):
    """The scene at parameters between its own and those of one of the case's variations."""
    among = getattr(module, "DRAWN", module.VARIED)
    changes = among[rng.integers(len(among))]
    share = rng.uniform()
    return changed(scene, {key: between(value_at(scene, key), value, share) for key, value in changes.items()})


def rows_of(answer, scene):
    rows = [(float(t), quantity, float(value), float(tolerance))
            for t, quantity, value, tolerance in answer(scene)]
    for row in rows:
        if not (row[0] <= scene["duration"] * (1 + 1e-9) and np.isfinite(row[2]) and row[3] > 0):
            raise AssertionError(f"a wrong row: {row}")
    return rows


def csv_of(rows):
    lines = ["# Written by tests/answers/answers.py from scene.toml.", COLUMNS]
    lines += [f"{t:.17g},{quantity},{value:.15g},{tolerance:.6g}"
              for t, quantity, value, tolerance in rows]
    return "\n".join(lines) + "\n"


def read_csv(file):
    lines = [line for line in file.read_text().splitlines() if line and line[0] != "#"]
    return [(float(t), quantity, float(value), float(tolerance))
            for t, quantity, value, tolerance in (line.split(",") for line in lines[1:])]


def toml_of(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{toml_of(k)} = {toml_of(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_of, value)) + "]"
    return repr(value)


def write_case(folder, module, scene, answer=None):
    """A case as a folder of its own, with the values of the module's answer or of another."""
    answer = answer or module.answer
    scene = module.prepared(scene) if hasattr(module, "prepared") else scene
    rows = rows_of(answer, scene)
    folder.mkdir(parents=True, exist_ok=True)
    text = "".join(f"{key} = {toml_of(value)}\n" for key, value in scene.items())
    (folder / "scene.toml").write_text(text)
    (folder / "answer.csv").write_text(csv_of(rows))


def write_drawn(folder, module, scene, rng):
    """A case at drawn parameters. Draws at which the answer does not hold are drawn again."""
    for attempt in range(20):
        try:
            return write_case(folder, module, drawn(module, scene, rng))
        except AssertionError:
            if attempt == 19:
                raise


def compare(rows, kept):
    """What differs between computed and kept rows, or nothing."""
    if [row[:2] for row in rows] != [row[:2] for row in kept]:
        return "other rows than computed"
    for now, before in zip(rows, kept):
        if abs(now[3] - before[3]) > 1e-5 * now[3]:
            return f"{now[1]} at {now[0]} s: tolerance {before[3]}, computed {now[3]}"
        if not abs(now[2] - before[2]) <= 0.01 * now[3] + 1e-12 * abs(now[2]):
            return f"{now[1]} at {now[0]} s: {before[2]}, computed {now[2]}"
    return None


def parsed(text):
    key, _, value = text.partition("=")
    return key, tomllib.loads(f"value = {value}")["value"]


def main():
    parser = argparse.ArgumentParser(description="Known answers of scenes, computed without taut")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of cases; default: all")
    parser.add_argument("--check", action="store_true", help="compare with the files; write none")
    parser.add_argument("--vary", metavar="FOLDER", help="the cases at other parameters, into there")
    parser.add_argument("--links", metavar="FOLDER", help="the cases at other numbers of links, into there")
    parser.add_argument("--random", metavar=("SEED", "N", "FOLDER"), nargs=3, help="the cases at N drawn parameters")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    parser.add_argument("--to", metavar="FOLDER", help="the case with the changes of --set, there")
    arguments = parser.parse_args()
    names = arguments.cases or sorted(path.parent.name for path in HERE.glob("*/answer.py"))
    failed = 0
    for name in names:
        folder = HERE / name
        try:
            module, scene = load_case(folder), load_scene(folder)
            if arguments.vary:
                for k, changes in enumerate(module.VARIED):
                    target = pathlib.Path(arguments.vary) / f"{name}_{k + 1}"
                    write_case(target, module, changed(scene, changes))
            elif arguments.random:
                seed, count, target = arguments.random
                rng = np.random.default_rng([int(seed), *name.encode()])
                for k in range(int(count)):
                    write_drawn(pathlib.Path(target) / f"{name}_{k + 1}", module, scene, rng)
            elif arguments.links:
                for links in getattr(module, "LINKS", []):
                    key = f"connectors.{next(iter(scene['connectors']))}.particles"
                    target = pathlib.Path(arguments.links) / f"{name}_{links}"
                    write_case(target, module, changed(scene, {key: links + 1}), module.continuum)
            elif arguments.to:
                changes = dict(parsed(text) for text in arguments.changes)
                write_case(pathlib.Path(arguments.to), module, changed(scene, changes))
            elif arguments.check:
                difference = compare(rows_of(module.answer, scene), read_csv(folder / "answer.csv"))
                if difference:
                    raise AssertionError(difference)
            else:
                (folder / "answer.csv").write_text(csv_of(rows_of(module.answer, scene)))
        except Exception as error:  # so that each case has its turn
            failed += 1
            print(f"{name}: {type(error).__name__}: {error}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
