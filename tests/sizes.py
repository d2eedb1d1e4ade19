"""What keeps the source small enough to be read: no file above 500 lines, no function above 60, no line above 120
columns, and no two modules that include one another, however many lie between. A module is a header with
its source. Run in the project's root: python3 tests/sizes.py"""

import re
import sys
from pathlib import Path

ROOMS = ["solvers", "solvers/muscles", "collision", "collision/solids", *(f"engine/{room}" for room in (
    "environment", "hand", "grasp", "control", "pulps", "finder", "formats", "scenes", "loops", "results", "studies",
    "insertion", "figures", "imports")), "app", "app/window", "python"]
NARROW = ["solvers", "collision", "engine", "app", "python", "tests", "bench", "examples"]  # Their lines are counted.
MOST_IN_FILE, MOST_IN_FUNCTION, MOST_COLUMNS = 500, 60, 120
# They hold a table, which may be as long as it is: of keys, or of what Python sees.
TABLES = {"engine/scenes/keys.cpp", "engine/results/tick_fields.cpp", *(f"python/{name}.cpp" for name in ("laws", "realtime", "scene", "simulation"))}


def functions(lines):
    """(first line, length) of each function at namespace or class scope; clang-format has laid them out."""
    start = None
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if start is None and indent in (0, 2) and line.endswith("{"):
            # The line with the name may be some lines above.
            if re.match(r"\s*(namespace|struct|class|enum|union|extern)\b", line) or line.strip() == "{":
                continue
            start = (number, indent)
        elif start is not None and line.startswith("}" if start[1] == 0 else "  }"):
            yield start[0] + 1, number - start[0] + 1
            start = None


def cycles(includes):
    """Modules that reach themselves."""
    found, done = [], set()

    def visit(module, way):
        if module in way:
            found.append(" -> ".join([*way[way.index(module):], module]))
        if module in way or module in done:
            return
        for other in sorted(includes.get(module, ())):
            visit(other, [*way, module])
        done.add(module)

    for module in sorted(includes):
        visit(module, [])
    return found


def main():
    faults, includes, read = [], {}, 0
    for room in ROOMS:
        for file in sorted([*Path(room).glob("*.h"), *Path(room).glob("*.cpp")]):
            lines = file.read_text(encoding="utf-8").splitlines()
            read += 1
            if len(lines) > MOST_IN_FILE and str(file) not in TABLES:
                faults.append(f"{file} has {len(lines)} lines")
            faults += [f"{file}:{first} has a function of {length} lines" for first, length in functions(lines)
                       if length > MOST_IN_FUNCTION and str(file) not in TABLES]
            module = str(file.with_suffix(""))
            named = re.findall(r'^#include "(.*)\.h"$', "\n".join(lines), re.MULTILINE)
            includes.setdefault(module, set()).update(name for name in named if name != module)
        if not list(Path(room).glob("*.cpp")):
            faults.append(f"{room} has no sources")
    for folder in NARROW:
        for file in sorted([*Path(folder).rglob("*.h"), *Path(folder).rglob("*.cpp")]):
            lines = file.read_text(encoding="utf-8").splitlines()
            faults += [f"{file}:{i} has {len(line)} columns" for i, line in enumerate(lines, 1)
                       if len(line) > MOST_COLUMNS]
    faults += [f"a cycle: {cycle}" for cycle in cycles(includes)]
    print("\n".join(faults) or f"{read} files in {len(ROOMS)} rooms keep to the sizes.")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
