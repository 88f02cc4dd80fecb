"""The results that are pictures of the shipped scenes: the gallery and the tutorial."""
import pathlib
import tomllib

from results_tables import Failed, result

GALLERY, TUTORIAL = "scenes/gallery/README.md", "scenes/tutorial/README.md"
PICTURES = "assets/pictures/scenes"
HEIGHT = 270  # px of a picture
WIDEST = 480  # px
TIMES = {  # of the clip (s), by scene: others show theirs at two fifths
    "new/rope.toml": 0.75, "new/chain.toml": 1.25, "new/net.toml": 0.5, "new/crane.toml": 3.4, "new/nunchaku.toml": 2.33,
    "new/character.toml": 4.5, "tutorial/02_chain.toml": 0.6, "tutorial/03_picture.toml": 1.0, "tutorial/04_path.toml": 3.6,
    "tutorial/05_pin.toml": 1.33, "tutorial/06_obstacle.toml": 1.0, "tutorial/07_rubber.toml": 1.4, "tutorial/08_joint.toml": 1.6,
    "tutorial/09_winch.toml": 2.9, "tutorial/10_figure.toml": 4.4, "nunchaku.toml": 10.9, "contact/ball_in_net.toml": 0.62}

SECTIONS = {"new": "To begin with: `taut new NAME --like ...`", "tutorial": "The tutorial", "": "Demonstrations", "contact": "Contact",
            "materials": "Materials", "topology": "Joints, nets, winches and pulleys", "together": "Features together",
            "choreography": "Choreography", "hard": "Hard cases"}


def shipped_scenes(source):
    """Every scene file below scenes/, as a path from there."""
    return sorted(str(file.relative_to(source / "scenes")) for file in (source / "scenes").rglob("*.toml"))


def picture_name(scene):
    return scene.removesuffix(".toml").replace("/", "_") + ".webp"


def told(source, scene):
    """The scene's own keys, and those of the scene that it extends."""
    file = source / "scenes" / scene
    keys = tomllib.loads(file.read_text())
    if "extends" in keys:
        keys = tomllib.loads((file.parent / keys["extends"]).read_text()) | keys
    return keys


def title(source, scene):
    """The scene's title or, without one, the sentence that it begins with."""
    keys = told(source, scene)
    return keys["title"] if "title" in keys else (source / "scenes" / scene).read_text().split("\n")[0].strip("# .")


def picture(work, scene):
    """Makes the scene's picture in assets/pictures/scenes."""
    keys = told(work.source, scene)
    width, height = keys.get("size", [1920, 1080])
    width = min(WIDEST, round(HEIGHT * width / height / 2) * 2)
    made = work.out / "gallery" / picture_name(scene).replace(".webp", ".png")
    time = TIMES.get(scene, round(0.4 * keys["duration"], 2))
    made.parent.mkdir(parents=True, exist_ok=True)
    work.run(f"taut render scenes/{scene} --poster {time:g} --size {width}x{HEIGHT} --no-estimate -q --out out/results/poster -o {made.relative_to(work.source)}")
    (work.source / PICTURES).mkdir(exist_ok=True)
    work.run(f"ffmpeg -y -v error -i {made.relative_to(work.source)} -quality 80 -compression_level 6 {PICTURES}/{picture_name(scene)}")


@result("gallery", GALLERY)
def gallery(work):
    """a picture of every shipped scene"""
    scenes = shipped_scenes(work.source)
    for old in (work.source / PICTURES).glob("*.webp"):
        if old.name not in map(picture_name, scenes):
            old.unlink()
    for scene in scenes:
        picture(work, scene)
    work.commands = [command for command in work.commands if "scenes/nunchaku.toml" in command or "/nunchaku.webp" in command]
    return "\n\n".join(section(work.source, folder, heading, scenes) for folder, heading in SECTIONS.items())


def section(source, folder, heading, scenes):
    """A heading, and a table of three scenes side by side."""
    own = [scene for scene in scenes if str(pathlib.Path(scene).parent) == (folder or ".")]
    if not own:
        raise Failed(f"scenes/{folder}: has no scene")
    cells = [[f"[{pathlib.Path(scene).stem}](../{scene})", f"![{title(source, scene)}](../../{PICTURES}/{picture_name(scene)})",
              title(source, scene)] for scene in own]
    lines = []
    for first in range(0, len(cells), 3):
        some = cells[first:first + 3] + [["", "", ""]] * (3 - len(cells[first:first + 3]))
        lines += [[cell[row] for cell in some] for row in range(3)]
    rows = ["| " + " | ".join(line) + " |" for line in lines]
    return "\n".join([f"## {heading}", "", rows[0], "|---|---|---|", *rows[1:]])


@result("tutorial", TUTORIAL, measured=False)
def tutorial(work):
    """ten steps: a sentence, the tables that are new, a picture"""
    scenes = work.source / "scenes"
    seen, text = set(), []
    for step in ["new/rope.toml"] + sorted(str(file.relative_to(scenes)) for file in (scenes / "tutorial").glob("[0-9]*.toml")):
        lines = (scenes / step).read_text().splitlines()
        name, sentence = "A scene of your own", "`taut new swing` writes this scene to swing.toml."
        if text:
            name, sentence = title(work.source, step), lines[0].split(". ", 1)[1]
        kept = [line for line in lines if not text or not line.startswith(("# ", "title"))]
        tables = [table for table in "\n".join(kept).split("\n\n") if meaning(table) not in seen | {""} or not text]
        seen |= set(map(meaning, tables))
        text.append("\n".join([f"## {len(text) + 1}. {name}", "", f"{sentence} ([{pathlib.Path(step).name}](../{step}))", "",
                               "```toml", "\n\n".join(tables).strip(), "```", "",
                               f"![{name}](../../{PICTURES}/{picture_name(step)})"]))
    return "\n\n".join(text)


def meaning(table):
    """A table without its comments and its spacing; the duration does not count."""
    lines = [line.split("#")[0].strip() for line in table.splitlines()]
    return "\n".join(line for line in lines if line and not line.startswith("duration"))
