# SPDX-License-Identifier: Apache-2.0
"""One name is one type: no two headers or sources define a type of the same name in the same namespace. Where both are in
one program, the linker keeps one of the functions that templates make of them, such as those of std::vector, for
both types, which writes beyond the smaller one. Run in the project's root: python3 tests/names.py. It first checks that
it finds such types."""

import re
import sys
from collections import defaultdict
from pathlib import Path

FOLDERS = ["solvers", "collision", "engine", "app", "python", "bench", "tests"]
UNNAMED = re.compile(r"^namespace \{$.*?^\}  // namespace$", re.MULTILINE | re.DOTALL)
NAMESPACE = re.compile(r"^(?:inline )?namespace ([\w:]+) \{", re.MULTILINE)
TYPE = re.compile(r"^(?:template <[^;{]*?>\s*)?(?:struct|class|enum class|enum|union) (?:\[\[[\w:]+\]\] |alignas\(\w+\) )?"
                  r"(\w+)(?: final)?(?: : [^;{]*)?\s*\{", re.MULTILINE)


def types(source):
    """Names of the types that are defined at namespace scope, with their namespace."""
    source = UNNAMED.sub("", source)
    at = [(match.start(), match[1]) for match in NAMESPACE.finditer(source)]
    for match in TYPE.finditer(source):
        around = [name for start, name in at if start < match.start()]
        yield "::".join([*around[-1:], match[1]])


def self_test():
    unnamed = "namespace {\nstruct C {\n};\n}  // namespace\n"
    source = ("namespace a::b {\n" + unnamed + "template <typename T>\nstruct A : B<T> {\n};\nstruct D;\n"
              "enum class E { kOne };\nclass F final {\n};\n}  // namespace a::b\n")
    assert list(types(source)) == ["a::b::A", "a::b::E", "a::b::F"], list(types(source))


def main():
    self_test()
    where = defaultdict(list)
    for folder in FOLDERS:
        for file in sorted([*Path(folder).rglob("*.h"), *Path(folder).rglob("*.cpp")]):
            for name in types(file.read_text(encoding="utf-8")):
                where[name].append(str(file))
    faults = [f"{name} is a type in {' and in '.join(files)}" for name, files in sorted(where.items()) if len(files) > 1]
    print("\n".join(faults) or f"{len(where)} types have a name of their own.")
    return 1 if faults or not where else 0


if __name__ == "__main__":
    sys.exit(main())
