"""The examples, and the Python in README files, run and say what they should."""
import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

from support import SOURCE

EXAMPLES = SOURCE / "render/python/examples"


def run(source, folder):
    """Standard output of a program that runs in a folder where it finds scenes and assets."""
    if not os.path.exists(os.path.join(folder, "scenes")):
        os.symlink(SOURCE / "scenes", os.path.join(folder, "scenes"))
    environment = {**os.environ, "TAUT_ASSETS": str(SOURCE)}
    result = subprocess.run(
        [sys.executable, "-c", source], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


class Examples(unittest.TestCase):
    EXPECTED = {
        "ropes_in_numpy": r"(?s)0\.00 s: lowest 0\.0000 m, energy [+-]0\.000000 J\n.*2\.00 s: lowest -\d\.\d{4} m",
        "chart_row": r"direct,[^\n]*tolerance[^\n]*,done,\d",
        "pin_and_release": r"\w+ ends at \[.*\]\n\w+' ends at \[.*\]\n",
        "frame_into_array": r"\(270, 480, 4\) mean colour \[",
        "ten_thousand_ropes": r"10000 ropes: the lowest end hangs 0\.\d{4} m below",
    }

    def test_run(self):
        self.assertEqual({file.stem for file in EXAMPLES.glob("*.py")}, set(self.EXPECTED))
        for name, expected in self.EXPECTED.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                self.assertRegex(run((EXAMPLES / f"{name}.py").read_text(), folder), expected)

    def test_the_notebook_s_cells_run(self):
        notebook = json.loads((EXAMPLES / "rope_over_post.ipynb").read_text())
        script = ""
        for cell in notebook["cells"]:
            if cell["cell_type"] != "code":
                continue
            self.assertEqual((cell["outputs"], cell["execution_count"]), ([], None), "outputs are cleared")
            needs = [tag.removeprefix("needs-") for tag in cell["metadata"].get("tags", [])]
            if all(importlib.util.find_spec(name) for name in needs):
                script += "".join(cell["source"]) + "\n"
        with tempfile.TemporaryDirectory() as folder:
            self.assertRegex(run(script, folder), r"ends at \[\S+ \S+\] m, largest tension \d+\.\d N")
            self.assertGreater(os.path.getsize(os.path.join(folder, "swing.mp4")), 1000)

    def test_energy_of_the_swing_stays(self):
        with tempfile.TemporaryDirectory() as folder:
            said = run((EXAMPLES / "ropes_in_numpy.py").read_text(), folder)
        self.assertTrue(all(abs(float(j)) < 1e-4 for j in re.findall(r"energy (\S+) J", said)), said)

    def test_readme_files(self):
        blocks = 0
        rooms = (SOURCE / room for room in ("assets", "render", "scenes", "sim", "tests"))
        pages = [SOURCE / "README.md", *(page for room in rooms for page in room.rglob("README.md"))]
        for page in pages:
            for block in re.findall(r"(?ms)^```python\n(.*?)^```", page.read_text()):
                if "import taut" not in block and "numpy, taut" not in block:
                    continue
                with self.subTest(page), tempfile.TemporaryDirectory() as folder:
                    run(block, folder)
                    self.assertLessEqual(len(block.splitlines()), 12)
                    blocks += 1
        self.assertGreater(blocks, 0)


if __name__ == "__main__":
    unittest.main()
