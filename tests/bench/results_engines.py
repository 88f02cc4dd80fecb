"""What results.py writes of other engines."""
import json
import math

from markdown_tables import cells, digits, first_table, markdown
from results_tables import STUDY, Failed, keep, result, verified


@result("engines", STUDY)
def engines(work):
    """other engines on the same scenes, and their picture"""
    every = "direct,dynamic-constraints,xpbd,multibody,bullet,mujoco,ode,sdfast,sdfast:ball"
    some = "direct,multibody,bullet,mujoco,ode"
    spaces = " ".join(f"tests/bench/engines/{name}.toml" for name in ("stick_in_space", "swing_30", "swing_in_space"))
    tables = [first_table(work.run(f"taut_engines work-precision {files} --methods {methods} --budget {budget} --markdown"))
              for files, methods, budget in (("scenes/bench_swing.toml scenes/bench_stick.toml", every, 70),
                                             ("scenes/bench_heavy.toml", every, 270), (spaces, some, 100))]
    if any("not installed" in table for table in tables):
        raise Failed("an engine is not installed; sim/README.md says how to get SD/FAST")
    work.run(f"taut_engines chart scenes/bench_swing.toml --methods {every} --budget 70 --out out/results/engines")
    keep(work, work.out / "engines/chart.png", "engines.png")
    return "\n\n".join(tables)


@result("touching", STUDY)
def touching(work):
    """other engines where ropes touch something"""
    scenes = "tests/bench/engines/rope_on_floor.toml tests/bench/engines/rope_on_ball.toml scenes/contact/post.toml"
    printed = work.run(f"taut_engines work-precision {scenes} --methods direct,xpbd,bullet,mujoco,ode "
                       "--budget 100 --errors 0.03,0.01,0.003,0.001 --markdown")
    costs, details = printed.split("\n\n")[:2]
    names, *rows = cells(details)
    kept = ["scene", "method", "error asked for (m)", "settings", "error (m)", "penetration (m)", "energy gained (J)"]
    some = [[row[names.index(name)] for name in kept] for row in rows if row[names.index(kept[2])] == "0.01"]
    for row in some:
        row[0] = row[0].rpartition("/")[2]
    return costs + "\n\n" + markdown([kept] + some, range(4, 7))


def costs_and_nearest(told):
    """A row for each method: its cost at each error on each scene, and the least error that it comes to."""
    def cost(point, cheapest):
        ms = point["cpu_ms_per_simulated_s"]
        return f"{digits(ms, 3)} ({digits(ms / cheapest, 3)}x)" if ms else "-"

    head = ["ms per simulated second"]
    rows = {entry["method"]: [entry["method"]] for entry in told["scenes"][0]["methods"]}
    for scene in told["scenes"]:
        entries = scene["methods"]
        for i, point in enumerate(entries[0]["work_precision"]):
            head.append(f"{scene['title']}: {1000 * point['error_asked_m']:g} mm")
            points = [entry["work_precision"][i] for entry in entries]
            cheapest = min(one["cpu_ms_per_simulated_s"] or math.inf for one in points)
            for entry, one in zip(entries, points):
                rows[entry["method"]].append(cost(one, cheapest))
        head.append("nearest (m)")
        for entry in entries:
            least = entry["least_rms_error_m"]
            rows[entry["method"]].append("-" if least is None else f"{least:.2g}")
    return markdown([head, *rows.values()], range(1, len(head)))


def cheapest_or_nearest(told, error):
    """A row for each scene and method: its cheapest settings within an error (m), else those that come nearest."""
    rows = [["scene", "method", "settings", "error (m)", "penetration (m)", "energy gained (J)"]]
    for scene in told["scenes"]:
        for entry in scene["methods"]:
            within = next(one for one in entry["work_precision"] if one["error_asked_m"] == error)
            found = within if within["cpu_ms_per_simulated_s"] else entry.get("nearest")
            row = [scene["title"], entry["method"]]
            if found:
                row.append(", ".join(f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
                                     for name, value in found["settings"].items()))
                row += [f"{found[key]:.2g}" for key in ("rms_error_m", "penetration_m", "energy_gained_j")]
            rows.append(row if found else row + ["no run came to its end", "-", "-", "-"])
    return markdown(rows, range(3, 6))


@result("friction", STUDY)
def friction(work):
    """other engines at a capstan, between sticks that touch, and with strings on a plate"""
    ways = (("tests/bench/engines/capstan_half.toml tests/bench/engines/capstan_once.toml "
             "tests/bench/engines/capstan_twice.toml", "direct,xpbd,bullet,mujoco,ode", "--reference-step 0.00013"),
            ("tests/bench/engines/nunchaku.toml", "direct,xpbd,bullet,mujoco,ode", "--reference-step 0.00005"),
            ("scenes/contact/scale.toml", "direct,springs,xpbd,mujoco-net,ode-net", ""))
    parts, known = [], [["scene", "scored until (s)", "the reference's own error (m)"]]
    for scenes, methods, reference in ways:
        told = json.loads(work.run(f"taut_engines work-precision {scenes} --methods {methods} --budget 100 "
                                   f"--errors 0.03,0.01,0.003 --json {reference}".strip()))
        known += [[scene["title"], f"{scene['horizon_s']:.3g}", f"{scene['self_error_m']:.1g}"]
                  for scene in told["scenes"]]
        parts += [costs_and_nearest(told), cheapest_or_nearest(told, 0.01)]
    return "\n\n".join([markdown(known, range(1, 3)), *parts])


@result("materials", STUDY)
def materials(work):
    """other engines where a connector bends"""
    scenes = " ".join(f"tests/bench/engines/{name}.toml" for name in ("hose", "rod", "hose_in_space"))
    return costs_and_nearest(json.loads(work.run(
        f"taut_engines work-precision {scenes} --methods direct,springs,xpbd,bullet,mujoco,mujoco:moments,ode "
        "--budget 100 --errors 0.01,0.001,0.0001 --json")))


@result("nets", STUDY)
def nets(work):
    """other engines where connectors are joined"""
    return costs_and_nearest(json.loads(work.run(
        "taut_engines work-precision tests/bench/engines/net.toml --methods direct,springs,xpbd,bullet-net,mujoco-net,ode-net "
        "--budget 100 --errors 0.01,0.001,0.0001 --json")))


@result("answers-engines", STUDY)
def answers_engines(work):
    """the known answers by other engines, each at its best step"""
    names = {"direct": "`direct`", "ode": "ODE", "bullet": "Bullet", "mujoco": "MuJoCo", "simbody": "Simbody"}
    engines = [name for name in names if name != "direct"]
    versions = [work.run(f"dpkg-query -W -f '${{Version}}' lib{name}-dev") for name in engines]
    told = verified(work, "taut verify --methods direct " + " ".join(
        f"--engine '{name}=tests/answers/engines/rigid_adapter.py {name}'" for name in engines) + " --cap 0.3 --json -q")
    def cell(one):
        if one["verdict"] in ("not run", "passes"):
            return one["verdict"].replace("not run", "")
        least = one.get("least_error")
        return one["verdict"] if least is None else f"{digits(100 * least, 2)}%"

    total = [["engine", "version", "expresses", "passes", "within 0.1%", "within 1%"]]
    for name, version in zip(engines, versions):
        ran = [case[name] for case in told.values() if case[name]["verdict"] != "not run"]
        near = [sum(one["verdict"] == "passes" or (one["least_error"] or math.inf) <= error for one in ran) for error in (1e-3, 1e-2)]
        total.append([names[name], version, len(ran), sum(one["verdict"] == "passes" for one in ran), *near])
    passes = sum(case["direct"]["verdict"] == "passes" for case in told.values())
    total.append(["`direct`", "", len(told), passes, "", ""])
    rows = [["case", *names.values(), "cannot express"]]
    for name, case in told.items():
        reasons = {case[engine]["reason"].removeprefix("cannot express: ") for engine in engines
                   if case[engine]["verdict"] == "not run"}
        rows.append([name, *(cell(case[method]) for method in names), "; ".join(sorted(reasons))])
    return markdown(total, (2, 3, 4, 5)) + "\n" + markdown(rows, ())
