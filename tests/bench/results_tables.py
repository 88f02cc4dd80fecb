"""What results.py writes: a function for each result, which returns Markdown."""
import csv
import dataclasses
import json
import math
import re
import shutil
import typing

from markdown_tables import cells, digits, first_table, markdown

RESULTS = {}
STUDY, SIM, RENDER, SCENES, FRONT = ("sim/study/README.md", "sim/README.md", "render/README.md",
                                     "scenes/README.md", "README.md")
DIRECT = "sim/methods/direct/README.md"
EXPORT = "render/export/README.md"
ANSWERS = "tests/answers/README.md"
OURS = "impulse,dynamic-constraints,multibody,springs,xpbd,direct"


class Failed(Exception):
    """A command failed, or a page has no place for a result."""


@dataclasses.dataclass
class Result:
    name: str
    page: str
    make: typing.Callable
    measured: bool  # false: follows from files of the repository, so that --check can compare it


def result(name, page, measured=True):
    def add(make):
        RESULTS[name] = Result(name, page, make, measured)
        return make
    return add


def keep(work, made, name):
    """Copies a picture that a command made into assets/pictures, smaller where it is a .webp."""
    target = f"assets/pictures/{name}"
    if name.endswith(".webp"):
        work.run(f"ffmpeg -y -v error -i {made} -quality 85 {target}")
    else:
        shutil.copyfile(made, work.source / target)


@dataclasses.dataclass
class Animation:
    """An animated picture in assets/pictures: every other frame of a scene of 60 frames a second."""
    scene: str
    first: int
    last: int

    def pictures(self):
        return (self.last - self.first) // 2 + 1


ANIMATIONS = {"throw.webp": Animation("scenes/nunchaku.toml", 431, 649), "first.webp": Animation("scenes/tutorial/first.toml", 0, 178)}


def pictures_in(file):
    """How many pictures an animated WebP file holds: its chunks ANMF."""
    data, at, count = file.read_bytes(), 12, 0
    while at + 8 <= len(data):
        count += data[at:at + 4] == b"ANMF"
        size = int.from_bytes(data[at + 4:at + 8], "little")
        at += 8 + size + size % 2
    return count


def check_animation(source, name):
    """Its pictures are as many as its command draws: FFmpeg reads on into older frames of a folder."""
    found, drawn = pictures_in(source / "assets/pictures" / name), ANIMATIONS[name].pictures()
    if found != drawn:
        raise Failed(f"assets/pictures/{name} has {found} pictures, its command draws {drawn}")


def check_pictures(source, pages):
    """Every picture is on a page and every picture of a page is there; a function here or among the engines makes it."""
    folder = source / "assets/pictures"
    there = {str(file.relative_to(folder)) for file in folder.rglob("*.*")}
    shown = {name for page in pages for name in re.findall(r"assets/pictures/([\w./]+)\)", page.read_text())}
    sources = "".join((source / "tests/bench" / f"results_{which}.py").read_text() for which in ("tables", "engines"))
    for name in sorted(there ^ shown):
        raise Failed(f"assets/pictures/{name} is {'on no page' if name in there else 'missing'}")
    for name in sorted(there):
        if f'"{name}"' not in sources and not name.startswith("scenes/"):
            raise Failed(f"assets/pictures/{name}: no result makes it")


def animate(work, name):
    animation = ANIMATIONS[name]
    folder = work.out / name.removesuffix(".webp")
    work.run(f"taut render {animation.scene} --frames {animation.first}-{animation.last} --size 640x360 --no-video --out {folder}")
    work.run(f"ffmpeg -y -v error -framerate 60 -start_number {animation.first} -i {folder}/frames/%06d.png "
             f"-vf \"select='not(mod(n,2))',setpts=N/30/TB\" -r 30 -loop 0 -quality 75 -compression_level 6 assets/pictures/{name}")
    check_animation(work.source, name)


# The results in README.md.


@result("first", FRONT)
def first(work):
    """the first scene, its command and its clip"""
    animate(work, "first.webp")
    scene = (work.source / "scenes/tutorial/first.toml").read_text()
    return (f"```toml\n{scene}```\n\n```sh\nbuild/release/taut render scenes/tutorial/first.toml  # out/tutorial/first/first.mp4\n```\n"
            "![A rope lets a weight swing](assets/pictures/first.webp)")


@result("choose", FRONT, measured=False)
def choose(work):
    """which method for what, from the tables of the study"""
    ours = ("direct", "xpbd", "springs", "impulse")

    def cheapest(result, column):
        """Of our methods, the one of the least cost in that column, and its cost."""
        tables = [cells(part) for part in work.place(RESULTS[result]).split("\n\n") if part.startswith("|")]
        table = next(one for one in tables if column in one[0])
        at = table[0].index(column)
        costs = {row[0]: float(row[at].split()[0]) for row in table[1:] if row[0] in ours and row[at] != "-"}
        method = min(costs, key=costs.get)
        return f"`{method}`: {column.split(': ')[1]}, {costs[method]:g} ms"

    swing = {row[0]: row for row in work.table(RESULTS["swing"])}
    by_swing = [f"`{swing[error][1]}`: {error.split()[0]}, {swing[error][3]} ms" for error in ("10% of the length", "0.01% of the length")]
    rows = [["I want", "roughly: method, error, CPU time per simulated second", "exactly"], ["ropes and sticks that swing", *by_swing]]
    for want, result, scene, rough, exact in (
            ("friction on posts", "friction", "Two turns and a half", "30 mm", "3 mm"),
            ("hoses and rods that bend", "materials", "Hose in a wall", "10 mm", "0.1 mm"),
            ("nets", "nets", "Net from a rail", "10 mm", "0.1 mm")):
        rows.append([want, cheapest(result, f"{scene}: {rough}"), cheapest(result, f"{scene}: {exact}")])
    return markdown(rows, ())


@result("summary", FRONT, measured=False)
def summary(work):
    """four lines from the other tables"""
    engines = {row[0]: row[2] for row in work.table(RESULTS["engines"])}
    times = sorted(float(re.search(r"\(([\d.]+)x\)", engines[name])[1]) for name in ("bullet", "mujoco", "ode", "multibody")
                   if "x)" in engines.get(name, ""))
    hard = work.table(RESULTS["hard"])
    column = hard[0].index("direct")
    accurate = sum(row[column].startswith("accurate") for row in hard[1:])
    claims = [row[2] for row in work.table(RESULTS["claims"])[1:]]
    batch = work.table(RESULTS["batch"])
    ropes = next(row for row in batch if row[0].startswith("10,000") and "single" in row[0])
    clip = re.search(r"([\d.]+) s of drawing", work.place(RESULTS["clip"]))[1]
    beside = next(row for row in cells(work.place(RESULTS["beside"]).split("\n\n", 1)[1]) if row[0] == "mean")
    where = "sim/study/README.md"
    return f"""\
- [Other engines]({where}#other-engines): for an error below 1 mm on the rope swing, Bullet, MuJoCo, ODE and Simbody \
take {times[0]:.0f} to {times[-1]:.0f} times as long as `direct`.
- [Hard cases]({where}#where-methods-fail): `direct` stays within 1% in {accurate} of {len(hard) - 1} hard cases. The \
table shows how the other methods fail.
- [The paper]({where}#what-of-the-paper-reproduces): of its {len(claims)} claims {claims.count('reproduced')} reproduce, \
{claims.count('under conditions')} reproduce under conditions, {claims.count('not reproduced')} do not.
- [Speed](sim/README.md#many-connectors-at-once): 10,000 ropes of 21 particles run at {ropes[3]} times real time. A \
1920x1080 frame of the demo takes [{clip} s of drawing](render/README.md#what-a-frame-costs) without a GPU. The demo \
[differs](render/README.md#a-pictures-truth) from a path tracer by a FLIP error of {beside[1]}, Blender's Eevee by {beside[2]}."""


# The results in sim/study/README.md.


@result("conclusions", STUDY, measured=False)
def conclusions(work):
    """the figures of the page's first list, from its tables"""
    errors = work.table(RESULTS["promise"])[-1]
    hard = work.table(RESULTS["hard"])
    column = hard[0].index("direct")
    accurate = sum(row[column].startswith("accurate") for row in hard[1:])
    long_step = next(row[column] for row in hard if row[0] == "A very long step")
    claims = [row[2] for row in work.table(RESULTS["claims"])[1:]]
    saving = re.search(r"saving +([\d.]+) times less by counted work", work.place(RESULTS["plan"]))[1]
    return f"""\
- [Tolerances](#what-a-tolerance-delivers): the error of `direct` stays within its tolerance in {errors[2]} of the drawn
  runs, and is usually far below it. A run's own estimate is right within a factor of 3 in {errors[7]}.
- [Failures](#where-methods-fail): `direct` stays within 1% in {accurate} of {len(hard) - 1} hard cases. It stops if two ends are pulled
  apart farther than the chain is long. With a step as long as a frame it is {long_step}.
- [The paper](#what-of-the-paper-reproduces): of its {len(claims)} claims {claims.count('reproduced')} reproduce, \
{claims.count('under conditions')} reproduce under conditions, {claims.count('not reproduced')} do not.
- [Planning](#the-cheapest-model-that-is-good-enough): `taut plan` finds settings that keep a stick on a cord within 1
  mm with {saving} times less work than the scene as written."""


@result("swing", STUDY)
def swing(work):
    """speed against accuracy of the rope swing, and its two pictures"""
    text = work.run("taut chart scenes/rope_swing.toml --markdown --out out/results/swing")
    keep(work, work.out / "swing/chart.png", "speed_accuracy.png")
    keep(work, work.out / "swing/chart_model.png", "model_error.png")
    return first_table(text)


def cheapest(work, files, shares, methods, options):
    """Rows of the cheapest method at shares of each scene's length; `options` by file."""
    rows = [["scene"] + [f"{100 * share:g}%" for share in shares]]
    for file in files:
        told = json.loads(work.run(f"taut check {file} --json"))
        length = max(one["length_m"] for one in told["connectors"].values())
        errors = ",".join(f"{length * share:.6g}" for share in shares)
        found = cells(work.run(f"taut work-precision {file} --methods {methods} {options(file)} --errors {errors} "
                               "--markdown"))
        row = [file.removeprefix("scenes/").removesuffix(".toml")]
        for i in range(1, len(shares) + 1):
            costs = sorted((float(one[i].split()[0]), one[0]) for one in found[1:] if "x)" in one[i])
            direct = [cost for cost, name in costs if name == "direct"]
            other = direct if costs and costs[0][1] != "direct" else [cost for cost, _ in costs[1:2]]
            row.append(f"{costs[0][1]} {costs[0][0]:.3g}" + (f" ({other[0] / costs[0][0]:.3g}x)" if other else "")
                       if costs else "")
        rows.append(row)
    return markdown(rows, range(1, len(rows[0])))


@result("scenes", STUDY)
def scenes(work):
    """the cheapest method at shares of the length, on scenes of other kinds"""
    files = [f"scenes/{name}.toml" for name in ("bench_swing", "bench_stick", "bench_heavy", "hard/heavy_load",
                                                "hard/falling_chain", "hard/whip")] + ["tests/bench/upright.toml"]
    methods = "direct,impulse,dynamic-constraints,xpbd"
    table = cheapest(work, files, [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6], methods, lambda file: "--budget 12")
    work.commands = [f"taut work-precision {' '.join(files)} --methods {methods} --budget 12 --errors ..."]
    return table


@result("together", STUDY)
def together(work):
    """the cheapest method at shares of the length, where features stand together"""
    files = sorted(str(path.relative_to(work.source)) for path in (work.source / "scenes/together").glob("*.toml"))
    methods = "direct,springs,xpbd"
    table = cheapest(work, files, [1e-1, 1e-2, 1e-3], methods,
                     lambda file: "--budget 15 --quick" + ("" if "[[stage.shots]]" in (work.source / file).read_text()
                                                           else " --set duration=0.2"))
    work.commands = [f"taut work-precision {' '.join(files)} --methods {methods} --budget 15 --quick "
                     "--set duration=0.2 --errors ..."]
    return table


@result("promise", STUDY)
def promise(work):
    """errors over tolerances, and runs' own estimates over errors, on drawn scenes"""
    path = work.out / "promise.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    work.run(f"taut_promise --scenes 350 --estimate --threads 2 --csv {path.relative_to(work.source)}")
    cells_ = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))

    def percent(values, holds):
        return f"{100 * sum(map(holds, values)) / len(values):.1f}%"

    def row(name, some):
        errors = sorted(float(cell["error_in_tolerances"]) for cell in some)
        told = sorted(float(cell["estimate"]) / float(cell["error_in_tolerances"]) for cell in some)
        costs = sorted(float(cell["estimating"]) for cell in some)
        solves = sorted(float(cell["solves"]) for cell in some)
        middle = len(some) // 2
        return [name, len(some), percent(errors, lambda e: e <= 1), percent(errors, lambda e: e <= 3),
                f"{errors[middle]:.2g}", f"{errors[-1]:.2g}", f"{solves[middle]:.0f}", percent(told, lambda t: 1 / 3 <= t <= 3),
                f"{told[middle]:.2g}", f"{costs[middle]:.2g}"]
    rows = [["tolerance / length", "scenes", "at most 1", "at most 3", "median", "largest", "solves a second",
             "told within 3 times", "told, median", "its cost"]]
    for tolerance in dict.fromkeys(cell["tolerance_of_length"] for cell in cells_):
        rows.append(row(tolerance, [cell for cell in cells_ if cell["tolerance_of_length"] == tolerance]))
    rows.append(row("all", cells_))
    return markdown(rows, range(1, len(rows[0])))


@result("schemes", STUDY)
def schemes(work):
    """which scheme of direct takes which steps, and its picture"""
    path = work.out / "schemes.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    work.run(f"taut_promise --scenes 70 --schemes {path.relative_to(work.source)}")
    work.run("gnuplot tests/bench/schemes.gnuplot")
    keep(work, work.out / "schemes.png", "schemes.png")
    steps = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    columns = [("scheme", name) for name in ("dop853", "adams", "rosenbrock")]
    columns += [("limit", name) for name in ("error", "waves", "frame", "longest")]
    rows = [["tolerance / length", "DOP853", "Adams", "ROS34PW2", "error", "waves", "frame", "longest"]]
    for tolerance in dict.fromkeys(step["tolerance_of_length"] for step in steps):
        some = [step for step in steps if step["tolerance_of_length"] == tolerance]
        rows.append([tolerance] + [f"{100 * sum(step[key] == value for step in some) / len(some):.0f}%"
                                   for key, value in columns])
    return "![Schemes by waves and step](../../assets/pictures/schemes.png)\n\n" + markdown(rows, range(1, len(rows[0])))


@result("net", DIRECT)
def net(work):
    """what a second of a large net takes"""
    told = json.loads(work.run("taut simulate scenes/topology/net.toml --set duration=1 --no-estimate --json -q"))
    return ("The first second of a net of 100 x 100 that swings from a rail ([scene](../../../scenes/topology/net.toml), 1 mm) "
            f"takes {told['steps']} steps, {told['solves']} solves and {told['stepping_ms_per_second'] / 1000:.2g} s of one core.")


@result("compare", STUDY)
def compare(work):
    """the picture of methods side by side"""
    work.run("taut compare scenes/rope_swing.toml --size 1280x720 --frames 45 --out out/results/compare")
    made = sorted((work.out / "compare/frames").glob("*.png"))
    keep(work, made[-1], "compare.png")
    return "![Methods side by side](../../assets/pictures/compare.png)"


@result("hard", STUDY)
def hard(work):
    """what each method makes of the hard cases"""
    return work.run("taut classify " + " ".join(f"scenes/hard/{name}.toml" for name in (
        "coincident", "falling_chain", "heavy_load", "long_step", "pulled_apart", "release_straight_up",
        "rotating_chain", "taut_snap", "whip")) + f" --methods {OURS} --markdown")


@result("stability", STUDY)
def stability(work):
    """the map of where methods fail"""
    work.run("taut stability scenes/rope_swing.toml --out out/results/stability")
    keep(work, work.out / "stability/stability_mass_ratio.png", "stability_mass_ratio.png")
    return "![Stability by mass ratio](../../assets/pictures/stability_mass_ratio.png)"


@result("claims", STUDY)
def claims(work):
    """what the paper says, and what is measured"""
    return work.run("taut claims scenes/rope_swing.toml --markdown")


@result("paper-ratio", STUDY)
def paper_ratio(work):
    """springs that cost as much as the paper says, and the picture of costs"""
    work.run("taut bench scenes/rope_swing.toml --out out/results/cost")
    keep(work, work.out / "cost/bench.png", "cost.png")
    with (work.out / "cost/bench_paper_ratio.csv").open(newline="") as file:
        rows = [row for row in csv.reader(file)]
    return markdown(rows, range(len(rows[0])))


@result("plan", STUDY)
def plan(work):
    """the plan of one scene"""
    return "```\n" + work.run("taut plan scenes/bench_stick.toml --tolerance 1mm") + "```"


@result("plans", STUDY, measured=False)
def plans(work):
    """the plans that the shipped scenes hold"""
    files = sorted(str(file.relative_to(work.source)) for file in (work.source / "scenes").glob("*.toml"))
    return work.run("taut check --plans " + " ".join(files))


# The results in sim/README.md.


def benchmarks(work, which):
    return json.loads(work.run(f"taut_bench --benchmark_filter='{which}' --benchmark_format=json"))["benchmarks"]


@result("interventions", SIM)
def interventions(work):
    """what a pin or its release costs"""
    rows = [["method", "particles", "µs", "of a frame", "of the method's own step"]]
    for one in benchmarks(work, "Intervention"):
        _, method, particles = one["name"].split("/")[:3]
        rows.append([f"`{method}`", particles.split(":")[1], f"{one['us']:.3g}", f"{one['in_frames']:.3g}",
                     f"{one['in_own_steps']:.3g}"])
    return markdown(rows, (1, 2, 3, 4))


@result("storm", SIM)
def storm(work):
    """a frame of impulse under 3600 pins and releases a minute"""
    rows = [["a frame of `impulse`, 21 particles", "µs"]]
    for one in benchmarks(work, "Frame"):
        after = re.search(r"after:(\d+)", one["name"])
        rows.append([f"after {after[1]} frames with a pin or release each" if after else "without any",
                     f"{one['cpu_time'] / 1000:.3g}"])
    return markdown(rows, (1,))


@result("batch", SIM)
def batch(work):
    """thousands of ropes at once"""
    rows = [["ropes", "vectors of", "ns per particle and step", "times real time", "of the floor"]]
    widths = ["one number", "16 bytes", "32 bytes", "64 bytes"]
    for one in benchmarks(work, "Step|TenThousand"):
        kind = "single precision" if "float" in one["name"] else "double precision"
        width = re.search(r"width:(\d)", one["name"])
        if width:
            rows.append([kind, widths[int(width[1])], f"{one['ns']:.3g}", "", f"{one['ratio']:.3g}"])
        else:
            rows.append([f"10,000 of 21 particles, {kind}", "the widest", "",
                         f"{one['times real time on all cores']:.3g}", ""])
    return markdown(rows, (2, 3, 4))


@result("exemptions", SIM, measured=False)
def exemptions(work):
    """what methods do not keep to; the data of the method contract's test"""
    text = work.run("test_physics --gtest_filter=MethodContractTable.StandsInTheReadme", codes=(0, 1))
    table = re.search(r"should hold:\n((?:\|.*\n)+)", text)
    return table[1] if table else work.place(RESULTS["exemptions"])


@result("features", SIM, measured=False)
def features(work):
    """methods by the features that they follow, and those that they do not follow together"""
    return work.run("taut check --features").rstrip("\n")


# The results in tests/answers/README.md.


@result("answers", ANSWERS, measured=False)
def answers(work):
    """the laws of the known answers, from the headings of their scenes"""
    rows = [["case", "law"]]
    for scene in sorted((work.source / "tests/answers").glob("*/scene.toml")):
        lines = [line[1:].strip() for line in scene.read_text().split("title =")[0].splitlines()]
        law = " ".join(lines).split(" Compared:")[0].rstrip(".")
        rows.append([f"[{scene.parent.name}]({scene.parent.name}/scene.toml)", law])
    return markdown(rows, ())


@result("answers-methods", ANSWERS)
def answers_methods(work):
    """how many of the known answers each method gives, and at what cost"""
    methods = "direct,truth,multibody,dynamic-constraints,springs,xpbd"
    told = json.loads(work.run(f"taut verify --methods {methods} --cap 10 --json -q", codes=(0, 1)))
    rows = [["method", "passes", "within ten tolerances", "fails", "not followed", "CPU time (s)"]]
    for method in methods.split(","):
        mine = [one for case in told["cases"] for one in case["methods"] if one["method"] == method]
        ran = [one for one in mine if one["verdict"] != "not run"]
        passes = [one for one in ran if one["verdict"] == "passes"]
        near = [one for one in ran if one["verdict"] == "fails" and one["worst"]["share_of_tolerance"] is not None
                and one["worst"]["share_of_tolerance"] <= 10]
        rows.append([f"`{method}`", len(passes), len(near), len(ran) - len(passes) - len(near), len(mine) - len(ran),
                     digits(sum(one["cpu_s"] for one in ran), 2)])
    return f"{len(told['cases'])} cases.\n\n" + markdown(rows, (1, 2, 3, 4, 5))


def verified(work, command):
    """What `taut verify --json` tells, by case and method."""
    told = json.loads(work.run(command, codes=(0, 1)))
    return {case["case"]: {one["method"]: one for one in case["methods"]} for case in told["cases"]}


def median_of(values, scale=1):
    values = sorted(value for value in values if value is not None)
    return digits(scale * (values[(len(values) - 1) // 2] + values[len(values) // 2]) / 2, 2) if values else "-"


@result("answers-costs", ANSWERS)
def answers_costs(work):
    """the order of each method and the cost of its errors, over all known answers"""
    methods = "direct,truth,multibody,dynamic-constraints,springs,xpbd"
    told = verified(work, f"taut verify --methods {methods} --converge --cap 0.25 --chart out/results/answers --json -q")
    keep(work, work.out / "answers.png", "answers_costs.png")
    rows = [["method", "cases followed", "median order", "within 10%", "1%", "0.1%", "median ms for 10%", "1%", "0.1%"]]
    for method in methods.split(","):
        ran = [case[method] for case in told.values() if case[method]["verdict"] != "not run"]
        costs = [[one["costs"][k]["cpu_s"] for one in ran] for k in range(3)]
        rows.append([f"`{method}`", len(ran), median_of([one["order"] for one in ran]),
                     *(sum(cost is not None for cost in column) for column in costs),
                     *(median_of(column, 1000) for column in costs)])
    cases = [["case", *(f"`{method}`" for method in methods.split(",") if method != "truth")]]
    for name, case in told.items():
        row = [name]
        for method in methods.split(","):
            one = case[method]
            if method == "truth":
                continue
            if one["verdict"] == "not run":
                row.append("")
                continue
            order = "-" if one["order"] is None else f"{one['order']:.1f}".replace("-0.0", "0.0")
            row.append(f"{order}; " + ", ".join("-" if cost["cpu_s"] is None else digits(1000 * cost["cpu_s"], 2)
                                                for cost in one["costs"]))
        cases.append(row)
    return ("![How many of the known answers each method gives, by CPU time](../../assets/pictures/answers_costs.png)\n\n"
            + markdown(rows, tuple(range(1, 9))) + "\nBy case: the order in the step; ms of CPU time for an error of 10%, "
            "1% and 0.1% of the length. Empty: the method does not follow the scene.\n\n" + markdown(cases, ()))


@result("answers-links", ANSWERS)
def answers_links(work):
    """how known answers approach those of the continuum with the number of links"""
    folder = work.out / "links"
    shutil.rmtree(folder, ignore_errors=True)
    work.run(f"tests/answers/answers.py --links {folder}")
    told = verified(work, f"taut verify {folder} --converge --json -q")
    errors = {}
    for name, case in told.items():
        case_name, links = name.rsplit("_", 1)
        errors.setdefault(case_name, []).append((int(links), case["direct"]["least_error"]))
    rows = [["case", "links", "error by `direct`", "order in the links"]]
    for name, column in sorted(errors.items()):
        before = None
        for links, error in sorted(column):
            order = "" if before is None else f"{math.log(before[1] / error) / math.log(links / before[0]):.2f}"
            rows.append([name, links, f"{digits(100 * error, 2)}%", order])
            before = links, error
    return markdown(rows, (1, 2, 3))


# The results in render/README.md and scenes/README.md.


@result("frame", RENDER)
def frame(work):
    """the stages of a frame, and the least that each could take"""
    told = json.loads(work.run("taut render scenes/nunchaku.toml --frames 400-420 --profile --no-video --anew --json -q "
                               "--out out/results/frame"))
    rows = [["stage", "CPU ms", "floor ms", "frames of 21"]]
    for stage in told["profile"]:
        floor = digits(1e3 * stage["floor"], 2) if "floor" in stage else ""
        rows.append([stage["stage"], digits(1e3 * stage["cpu"], 3), floor, stage["frames"]])
    return markdown(rows, (1, 2, 3))


@result("beside", RENDER)
def beside(work):
    """ten frames of the demo beside Blender's engines, and a picture of three of them"""
    table = work.run(f"tests/bench/pictures/beside_blender.py {work.build}/taut scenes/nunchaku.toml --size 320x180 "
                     f"--samples 128 --out {work.out}/beside")
    keep(work, work.out / "beside/sheet.png", "beside.webp")
    return "![taut, Eevee and Cycles](../assets/pictures/beside.webp)\n\n" + table.strip()


@result("export", EXPORT)
def export(work):
    """sizes of the demo as glTF"""
    sizes = []
    for options in ("", " --scenery"):
        work.run(f"taut export scenes/nunchaku.toml{options} -o out/results/nunchaku.glb -q")
        sizes.append((work.out / "nunchaku.glb").stat().st_size / 1e6)
    return f"The demo's file has {sizes[0]:.2g} MB, with `--scenery` {sizes[1]:.2g} MB."


@result("clip", RENDER)
def clip(work):
    """seconds per frame of the whole demo"""
    told = json.loads(work.run("taut render scenes/nunchaku.toml --anew --json -q --out out/results/nunchaku"))
    times = told["seconds_per_frame"]
    return (f"The whole demo takes {times['rendering']:.2g} s of drawing, {times['simulation']:.2g} s of simulating and "
            f"{times['encoding']:.2g} s of encoding a frame, with {told['mean_exposures']:.1f} exposures on average.")


@result("phases", RENDER)
def phases(work):
    """the contact sheet of the demo, and the throw"""
    work.run("taut render scenes/nunchaku.toml --contact-sheet --size 1440x810 --out out/results/phases")
    keep(work, work.out / "phases/contact_sheet.png", "nunchaku.png")
    animate(work, "throw.webp")
    return "![Phases of the demonstration](../assets/pictures/nunchaku.png)"


@result("curtain", SIM)
def curtain(work):
    """the picture of a thousand cords"""
    work.run("taut render scenes/bead_curtain.toml --frames 42 --size 960x540 --no-video --out out/results/curtain")
    keep(work, work.out / "curtain/frames/000042.png", "bead_curtain.webp")
    return "![A thousand cords, struck by a stick](../assets/pictures/bead_curtain.webp)"


def rows_of(schema, prefix):
    """A row for each key of a table of the schema, those of its tables below it."""
    rows = []
    for name, key in schema.get("properties", {}).items():
        inner = key.get("additionalProperties")
        kind = key.get("type", "choice")
        below, path = None, f"{prefix}{name}"
        if "enum" in key:
            kind = ", ".join(f'"{one}"' for one in key["enum"])
        elif "anyOf" in key:
            kind = ", ".join([f'"{one}"' for one in key["anyOf"][0]["enum"]] + ["table"])
        elif kind == "array" and key["items"].get("type") == "object":
            below, path, kind = key["items"], f"[[{path}]]" if "." not in path else f"{path}[]", "tables"
        elif kind == "array":
            most = key.get("maxItems")
            kind = f"{most} numbers" if most else "list"
        elif kind == "object" and isinstance(inner, dict):
            below, path, kind = inner, f"{path}.NAME", "tables"
        elif kind == "object":
            below, kind = key, "table"
        rows.append([f"`{path}`", kind, (key.get("description") or "").replace("|", "\\|")])
        if below and "oneOf" not in below and name != "plan":
            rows += rows_of(below, path.strip("[]") + ".")
    return rows


@result("settings", SCENES, measured=False)
def settings(work):
    """the settings of the methods, from the schema of scene files"""
    schema = json.loads((work.source / "scenes/scene.schema.json").read_text())
    rows = [["method", "setting", "default", "unit", "range", "meaning"]]
    for method in schema["properties"]["method"]["oneOf"]:
        for name, key in method["properties"].items():
            if name == "name":
                continue
            meaning, unit = re.fullmatch(r"(.*?)(?: \[(.*)\])?", key["description"]).groups()
            rows.append([f"`{method['properties']['name']['const']}`", f"`{name}`", f"`{plain(key['default'])}`",
                         unit or "", allowed(key), meaning])
    return markdown(rows)


def plain(value):
    """A value as a scene file has it; whole numbers without a point."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else json.dumps(value)


def allowed(key):
    """The values that a key of the schema accepts, in words."""
    if "enum" in key:
        return ", ".join(f'`"{one}"`' for one in key["enum"])
    if key["type"] == "boolean":
        return "`true`, `false`"
    least = f"more than {key['exclusiveMinimum']:g}" if "exclusiveMinimum" in key else f"at least {key['minimum']:g}"
    return least + (f", at most {key['maximum']:g}" if "maximum" in key else "") + (", whole" if key["type"] == "integer" else "")


@result("keys", SCENES, measured=False)
def keys(work):
    """the keys of a scene file, from its schema"""
    schema = json.loads((work.source / "scenes/scene.schema.json").read_text())
    return markdown([["key", "is", "meaning"]] + rows_of(schema, ""))
