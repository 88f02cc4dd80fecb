#!/usr/bin/python3
"""Known answers of scenes, computed without taut. README.md beside this file says how.

    tests/answers/answers.py pendulum            writes pendulum/answer.csv
    tests/answers/answers.py                     those of all cases
    tests/answers/answers.py --check             computes all again and compares with the files
    tests/answers/answers.py --vary FOLDER       writes every case at other parameters into FOLDER
    tests/answers/answers.py --links FOLDER      writes cases with other numbers of links, and the continuum's answers
    tests/answers/answers.py --set connectors.rope.length=0.7 --to FOLDER pendulum

A case's answer.py has a function answer(scene): the scene as tomllib reads it in, a list of rows
(time, quantity, value, tolerance) out. It computes the values by two routes and compares them. Its
list VARIED has changes of the scene at which it is right as well. Where links refine, continuum(scene)
gives the answer of infinitely many, and LINKS names the numbers at which --links writes the case.
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
            if not h > 1e-9:
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


def write_case(folder, answer, scene):
    """A case as a folder of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    text = "".join(f"{key} = {toml_of(value)}\n" for key, value in scene.items())
    (folder / "scene.toml").write_text(text)
    (folder / "answer.csv").write_text(csv_of(rows_of(answer, scene)))


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
                    write_case(target, module.answer, changed(scene, changes))
            elif arguments.links:
                for links in getattr(module, "LINKS", []):
                    key = f"connectors.{next(iter(scene['connectors']))}.particles"
                    target = pathlib.Path(arguments.links) / f"{name}_{links}"
                    write_case(target, module.continuum, changed(scene, {key: links + 1}))
            elif arguments.to:
                changes = dict(parsed(text) for text in arguments.changes)
                write_case(pathlib.Path(arguments.to), module.answer, changed(scene, changes))
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
