# SPDX-License-Identifier: Apache-2.0
"""The examples in Python, and the programs that the documents show: each runs as it is shown, says what it should, and
draws its picture. Ends with 77 where numpy or, for an example, matplotlib is missing.

    test_examples.py EXAMPLE | README | GUIDE
"""

import importlib.util
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
# What an example says.
SAYS = {
    "first_grasp": r"^held; the largest slip of a finger is 0\.\d{3} mm$",
    "your_object": r"^lifted: held$",
    "forces_and_cones": r"^optimal: forces of ",
    "your_controller": r"^in one loop held, in real time ",
    "slip_map": r"^\d+ of 42 were held$",
    "gym_grasp": r"^reward [\d.-]+ before, [\d.-]+ after: ",
}
README_LINES = 10


def run(program, folder, *arguments):
    """What a program says. It must end well, and may warn of nothing."""
    environment = {**os.environ, "MPLBACKEND": "Agg", "MPLCONFIGDIR": str(folder)}
    if importlib.util.find_spec("gymnasium") is None:
        environment["PYTHONPATH"] += os.pathsep + str(SOURCE / "tests" / "python" / "stand_in")
    result = subprocess.run([sys.executable, "-B", str(program), *map(str, arguments)], cwd=folder, env=environment,
                            capture_output=True, text=True)
    if result.returncode != 0 or result.stderr:
        sys.exit(f"{program} ended with {result.returncode}:\n{result.stdout}{result.stderr}")
    return result.stdout


def check(holds, what, text=""):
    if not holds:
        sys.exit(f"{what}\n{text}")


def test_example(name, folder):
    picture = folder / "picture.png"
    text = run(SOURCE / "examples" / "python" / f"{name}.py", folder, picture)
    check(re.search(SAYS[name], text, re.MULTILINE), f"{name} does not say {SAYS[name]}:", text)
    if name == "your_controller":
        # At rest the box gives way by F / K. The fingers' viscosity keeps it from all of that within the push's 1 s;
        # more than F / K would be another stiffness.
        gave, asked = map(float, re.search(r"gave way by ([\d.]+) mm; F / K is ([\d.]+) mm", text).groups())
        check(0.9 * asked <= gave <= asked, "the spring is of another stiffness:", text)
    if name == "gym_grasp":
        # Some of the boxes slip out of the grip that it begins with, and none of those that it has learned to hold.
        before, after = map(float, re.search(r"reward ([\d.-]+) before, ([\d.-]+) after", text).groups())
        check(after > before + 0.05, "it has learned nothing:", text)
    if name == "slip_map":
        # A feather with the most friction is held, and a brick with the least is not.
        held = int(re.match(r"\d+", text).group())
        check(0 < held < 42, "a map of one outcome:", text)
    data = picture.read_bytes()
    check(data.startswith(b"\x89PNG") and len(data) > 5000, f"{name} has drawn no picture")


def blocks(document):
    """The Python programs of a document."""
    text = (SOURCE / document).read_text(encoding="utf-8")
    return re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def test_readme(folder):
    programs = blocks("README.md")
    check(len(programs) == 1, f"README.md has {len(programs)} programs in Python, not one")
    check(len(programs[0].splitlines()) <= README_LINES, f"README.md: its program has more than {README_LINES} lines")
    program = folder / "readme.py"
    program.write_text(programs[0], encoding="utf-8")
    check(run(program, folder).endswith("\nheld\n"), "the README's program does not hold the box")


def test_guide(document, folder):
    """All blocks of a guide are one program."""
    program = folder / "guide.py"
    program.write_text("\n".join(blocks(document)), encoding="utf-8")
    run(program, folder)


def main(what):
    try:
        import numpy  # noqa: F401
        if what in SAYS:
            import matplotlib  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error} (Debian: python3-numpy, python3-matplotlib)")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        if what in SAYS:
            test_example(what, Path(folder))
        elif what == "README":
            test_readme(Path(folder))
        else:
            test_guide(f"docs/guide/{what}.md", Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
