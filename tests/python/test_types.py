# SPDX-License-Identifier: Apache-2.0
"""The package's types: its stubs name what is there and say what it is, and the examples are right by them (mypy
--strict).

Ends with 77 where mypy or numpy is missing.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
# What stubtest cannot see through: classes of pybind11, those without a constructor, and what `typing` has as functions.
KNOWN = (r"metaclass differs$|__init__ is inconsistent, stub does not have \*args|"
         r"(NamedTuple|Mapping|Sequence) is not a type$")
# matplotlib 3.6, which examples draw with, has no types.
SETTINGS = "[mypy]\nstrict = True\nignore_missing_imports = True\n"


def main():
    try:
        import mypy.stubtest  # noqa: F401
        import numpy  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error} (Debian: mypy, python3-numpy)")
        return 77
    subprocess.run([sys.executable, "-B", SOURCE / "python" / "stub.py", "--check"], check=True)
    environment = {**os.environ, "MYPYPATH": os.environ["PYTHONPATH"]}
    environment["PYTHONPATH"] += os.pathsep + str(SOURCE / "tests" / "python" / "stand_in")  # stubtest imports thenar.gym.
    with tempfile.TemporaryDirectory() as folder:
        settings = Path(folder) / "mypy.ini"
        settings.write_text(SETTINGS, encoding="utf-8")

        def said(*command):
            result = subprocess.run([sys.executable, "-B", "-m", *map(str, command)], cwd=folder, env=environment,
                                    capture_output=True, text=True)
            return result.returncode, result.stdout + result.stderr

        examples = sorted((SOURCE / "examples" / "python").glob("*.py"))
        code, faults = said("mypy", "--config-file", settings, "--cache-dir", folder, *examples)
        if code != 0:
            sys.exit(faults)
        _, text = said("mypy.stubtest", "thenar", "--concise", "--mypy-config-file", settings)
        faults = [line for line in text.splitlines() if line and not re.search(KNOWN, line)]
        if faults:
            sys.exit("\n".join(faults))
    return 0


if __name__ == "__main__":
    sys.exit(main())
