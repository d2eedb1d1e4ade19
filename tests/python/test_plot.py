"""python -m thenar.plot: the figures of a folder and of a Run, and what it says of bad input.

Ends with 77 where numpy or matplotlib is missing.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from support import PROGRAM, np, thenar, unittest

try:
    import matplotlib
except ImportError:
    print("skipped: matplotlib is missing (Debian: python3-matplotlib)")
    sys.exit(77)
matplotlib.use("Agg")
import thenar.plot

SHORT = {"time.duration": "50 ms", "object.points": 4000, "fingertips.leaves": 100}
NAMES = {"path", "forces", "grip", "muscles", "solver"}


def plot(*arguments, **environment):
    """(exit code, what it prints, what it complains)."""
    result = subprocess.run([sys.executable, "-B", "-m", "thenar.plot", *map(str, arguments)],
                            env={**os.environ, "MPLBACKEND": "Agg", **environment}, capture_output=True, text=True)
    return result.returncode, result.stdout, result.stderr


class Folder(unittest.TestCase):
    """What `thenar run --out` has written."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = Path(tempfile.mkdtemp())
        cls.out = cls.scratch / "out"
        changes = [part for key, value in SHORT.items() for part in ("--set", f"{key}={value}")]
        subprocess.run([PROGRAM, "run", "box_grasp", *changes, "--quiet", "--out", str(cls.out)], check=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def broken(self, name):
        copy = self.scratch / name
        shutil.copytree(self.out, copy)
        return copy

    def test_is_drawn_into_itself_or_another(self):
        other = self.scratch / "new" / "place"
        for place, arguments in ((self.out, []), (other, ["--to", other])):
            code, said, complaint = plot(self.out, *arguments)
            self.assertEqual((code, complaint), (0, ""))
            files = [Path(line) for line in said.splitlines()]
            self.assertEqual({file.stem for file in files}, NAMES)
            for file in files:
                self.assertEqual(file.parent, place)
                self.assertTrue(file.read_bytes().startswith(b"\x89PNG"))

    def test_is_read_whole(self):
        """The curves are the columns of signals.csv, to its nine digits."""
        figures = thenar.plot._read(self.out)
        drawn = figures["forces"].axes[0].get_lines()[0].get_ydata()
        run = thenar.run(thenar.Scene("box_grasp", SHORT))
        np.testing.assert_allclose(drawn, run.signals["thumb_normal_N"], rtol=1e-8)

    def test_that_is_missing_or_broken_is_named(self):
        no_signals, no_summary = self.broken("no_signals"), self.broken("no_summary")
        (no_signals / "signals.csv").unlink()
        (no_summary / "summary.json").unlink()
        short, words, other = self.broken("short"), self.broken("words"), self.broken("other")
        lines = (self.out / "signals.csv").read_text().splitlines()
        (short / "signals.csv").write_text("\n".join([*lines[:2], "1,2,3"]))
        (words / "signals.csv").write_text("\n".join([*lines[:2], lines[2].replace(lines[2].split(",")[3], "much", 1)]))
        (other / "signals.csv").write_text("a,b\n1,2\n")
        empty, json, whole, binary = map(self.broken, ("empty", "json", "whole", "binary"))
        (empty / "signals.csv").write_text(lines[0] + "\n")
        (json / "summary.json").write_text("{")
        (whole / "summary.json").write_text("{}")
        (binary / "signals.csv").write_bytes(b"\xff\xfe\x00")
        for folder, place, what in (
            (self.scratch / "nowhere", "nowhere/signals.csv", "No such file"),
            (no_signals, "no_signals/signals.csv", "No such file"),
            (no_summary, "no_summary/summary.json", "No such file"),
            (short, "short/signals.csv:3", "3 values"),
            (words, "words/signals.csv:3", "much"),
            (other, "other/signals.csv:1", "no header"),
            (empty, "empty/signals.csv", "no tick"),
            (json, "json/summary.json", "Expecting"),
            (whole, "whole/summary.json", "'scene' is missing"),
            (binary, "binary", "not text"),
        ):
            code, said, complaint = plot(folder)
            self.assertEqual((code, said), (3, ""), complaint)
            self.assertEqual(complaint.count("\n"), 1, complaint)
            self.assertTrue(complaint.startswith("thenar.plot: "), complaint)
            self.assertIn(place, complaint)
            self.assertIn(what, complaint)

    def test_that_cannot_be_written_is_named(self):
        code, _, complaint = plot(self.out, "--to", self.out / "signals.csv")
        self.assertEqual(code, 3)
        self.assertIn("signals.csv", complaint)
        self.assertEqual(complaint.count("\n"), 1, complaint)

    def test_wrong_command(self):
        self.assertEqual(plot()[0], 2)
        self.assertEqual(plot(self.out, "--form", "svg")[0], 2)

    def test_without_matplotlib(self):
        fake = self.scratch / "fake"
        (fake / "matplotlib").mkdir(parents=True)
        (fake / "matplotlib" / "__init__.py").write_text("raise ImportError('not here')")
        path = os.pathsep.join([str(fake), os.environ.get("PYTHONPATH", "")])
        code, said, complaint = plot(self.out, PYTHONPATH=path)
        self.assertEqual((code, said), (2, ""))
        self.assertEqual(complaint, "thenar.plot: needs matplotlib (Debian: python3-matplotlib)\n")


class OfRun(unittest.TestCase):
    def test_without_control_or_muscles(self):
        """`slide` has no controller: no desired forces, and no figure of muscles."""
        run = thenar.run(thenar.Scene("slide", SHORT))
        figures = thenar.plot.figures(run)
        self.assertEqual(set(figures), NAMES - {"muscles"})
        self.assertEqual(len(figures["forces"].axes[0].get_lines()), 2)

    def test_leaves_the_style_of_others_alone(self):
        before = dict(matplotlib.rcParams)
        thenar.plot.figures(thenar.run(thenar.Scene("minimal", {"time.duration": "20 ms"})))
        self.assertEqual(before, dict(matplotlib.rcParams))

    def test_that_lost_its_object_says_when(self):
        scene = thenar.Scene("minimal", {"time.duration": "400 ms", "contact.friction": 0.05})
        run = thenar.run(scene)
        self.assertEqual(run.outcome, "lost")
        title = thenar.plot.figures(run)["path"]._suptitle.get_text()
        self.assertEqual(title, f"minimal: lost at {run.summary['grasp']['lost_at_s']:.2f} s")


if __name__ == "__main__":
    unittest.main()
