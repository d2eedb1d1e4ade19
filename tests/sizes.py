# SPDX-License-Identifier: Apache-2.0
"""What keeps the source small enough to be read: no file above 500 lines, no function above 60, no line above 120
columns, no source without its licence in its first lines, and no two modules that include one another, however many lie
between. A module is a header with its source. Run in the project's root: python3 tests/sizes.py. It first checks that it finds long functions."""

import re
import sys
from pathlib import Path

ROOMS = ["solvers", "solvers/muscles", "collision", "collision/solids", *(f"engine/{room}" for room in (
    "environment", "hand", "grasp", "control", "pulps", "finder", "formats", "scenes", "models", "loops", "results",
    "recordings", "studies", "sweeps", "stiffness", "capacity", "problems", "insertion", "figures", "imports")),
    "app", "app/run", "app/studies", "app/window", "python"]
NARROW = ["solvers", "collision", "engine", "app", "python", "tests", "bench", "examples"]  # Their lines are counted.
LICENSED = [*NARROW, "cmake", "docs"]
LICENCE = "SPDX-License-Identifier: Apache-2.0"
MOST_IN_FILE, MOST_IN_FUNCTION, MOST_COLUMNS = 500, 60, 120
# They hold a table, which may be as long as it is: of keys, of fields, or of measures.
TABLES = {"engine/scenes/keys.cpp", "engine/results/tick_fields.cpp", "engine/results/run_measures.cpp"}
# Where functions begin that the self-test makes long.
HEADS = ["int f(int a,\n      A b = {}) {", "A::A(char a)\n    : a_{a},\n      b_('{') {", "auto f =\n    [](int a) {",
         "template <class T>\n  requires requires(T t) { t.a(); }\nT f(T t) {", "int f() try {\n} catch (A&) {",
         "[[nodiscard]] bool A::operator()(\n    int a) const  // {\n    noexcept {"]
AROUND = [("int a{1};\n", "int b;\n"), ("template <class T>\nclass A : B {\n public:\n", " private:\n  int a_;\n};\n")]

# Read as blanks: comments, strings, characters, directives and access labels. A brace in them opens no block.
NO_CODE = re.compile(r'//.*|/\*[\s\S]*?\*/|R"(\w*)\([\s\S]*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.[^\'\n]*|[^\\\n])\''
                     r"|^ *#(?:.*\\\n)*.*|^ *(?:public|private|protected):", re.MULTILINE)
SCOPE = re.compile(r"( template <[^(]*>)?( inline)? (namespace|struct|class|enum|union|extern)\b( alignas\(\))?[^(]*")
# A brace ends a declaration if the next one follows, and not the rest of an initialiser list, a requirement or a try.
AFTER = re.compile(r"\s*(?!catch\b)[\w\[~}]|\s*$")
REQUIREMENT = re.compile(r" requires(\(\))?\{\}$")


def functions(source):
    """(first line, length) of each function at namespace or class scope, from its signature to its closing brace."""
    code = NO_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), source)
    head, first, depth = "", 0, 0  # The declaration so far; what its `depth` brackets hold is left out.
    for token in re.finditer(r"[(){};]|[^\s(){};]+", code):
        text, end = token[0], token.end()
        first = first if head else token.start()
        depth -= text in ")}"
        if depth < 0 or depth == 0 and text == "{" and SCOPE.fullmatch(head):  # A scope ends or begins.
            head, depth = "", 0
            continue
        if depth == 0:
            head += text if text in "(){}" else " " + text
        depth += text in "({"
        if depth == 0 and (text == ";" or text == "}" and AFTER.match(code, end) and not REQUIREMENT.search(head)):
            if "{" in head:
                yield code.count("\n", 0, first) + 1, code.count("\n", first, end) + 1
            head = ""


def self_test():
    """Two functions of a known length, one after the other, are found with this length."""
    for head in HEADS:
        for before, after in AROUND:
            for length in (MOST_IN_FUNCTION, MOST_IN_FUNCTION + 1):
                end = "};\n" if "[]" in head else "}\n"
                function = head + "\n" + "  a();\n" * (length - head.count("\n") - 2) + end
                long = [found for found in functions(before + 2 * function + after) if found[1] > 1]
                first = before.count("\n") + 1
                assert long == [(first, length), (first + length, length)], (head, length, long)


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
    self_test()
    faults, includes, read = [], {}, 0
    for room in ROOMS:
        for file in sorted([*Path(room).glob("*.h"), *Path(room).glob("*.cpp")]):
            source = file.read_text(encoding="utf-8")
            lines = source.splitlines()
            read += 1
            if len(lines) > MOST_IN_FILE and str(file) not in TABLES:
                faults.append(f"{file} has {len(lines)} lines")
            faults += [f"{file}:{first} has a function of {length} lines" for first, length in functions(source)
                       if length > MOST_IN_FUNCTION and str(file) not in TABLES]
            module = str(file.with_suffix(""))
            named = re.findall(r'^#include "(.*)\.h"$', source, re.MULTILINE)
            includes.setdefault(module, set()).update(name for name in named if name != module)
        if not list(Path(room).glob("*.cpp")):
            faults.append(f"{room} has no sources")
    for folder in LICENSED:
        for file in sorted(file for kind in ("h", "cpp", "py", "pyi", "js", "mjs", "css", "cmake", "txt")
                           for file in Path(folder).rglob(f"*.{kind}") if kind != "txt" or file.name == "CMakeLists.txt"):
            if LICENCE not in file.read_text(encoding="utf-8")[:200]:
                faults.append(f"{file} does not name its licence: {LICENCE}")
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
