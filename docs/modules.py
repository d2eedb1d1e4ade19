# SPDX-License-Identifier: Apache-2.0
"""Makes docs/MODULES.md of the headers: for each room a table of its modules, each with its main declaration and the
first sentence of that declaration's comment.

    python3 docs/modules.py            writes docs/MODULES.md
    python3 docs/modules.py --check    fails if the page is not what the headers say

The main declaration of a header is the documented one whose name is most like the header's; of several alike, the
first. Constants, tests such as is_...() and helpers such as ...Settings come after all others that are as like. A
comment that stands above the namespace, or above no declaration, is the header's own and takes precedence. MAIN names
the main declaration where names do not show it.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tests"))
from sizes import ROOMS  # noqa: E402

PAGE = ROOT / "docs" / "MODULES.md"
LONGEST = 200  # A longer sentence ends at its colon or semicolon, where it has one.
HELPER = r"^(?:most_|check_)|(?:Options|Flags|Settings|Error|Report|Request|Target|Noise|Place|Limits|Message|Channel)$"
MAIN = {
    "app/studies/hand.h": "run_hand",
    "app/studies/hand_capacity.h": "run_hand_capacity",
    "collision/solids/exact_shape.h": "nearest_place",
    "collision/solids/solid.h": "features",
    "engine/control/control.h": "desired_torques",
    "engine/control/stiff_control.h": "StiffnessControl",
    "engine/environment/room_for.h": "find_overlap",
    "engine/finder/carry.h": "add_travel",
    "engine/finder/fit.h": "StanceFit",
    "engine/finder/oppositions.h": "Opposition",
    "engine/formats/mcap_reader.h": "read_mcap",
    "engine/formats/problem_file.h": "read_problem",
    "engine/grasp/environment_tick.h": "look_around",
    "engine/grasp/patches.h": "PatchReport",
    "engine/loops/realtime.h": "Schedule",
    "engine/models/new_scene.h": "write_new_scene",
    "engine/scenes/scene_file.h": "load_scene",
    "engine/scenes/units.h": "read_quantity",
    "engine/capacity/hand_capacity.h": "largest_pinch",
    "solvers/dual_active_set.h": "project",
    "solvers/muscles/stiff_proof.h": "stiff_kkt_error",
}
HEAD = """# Modules

This page is generated from the comments of the headers: `python3 docs/modules.py` writes it, and the test `modules`
fails when it is stale. [ARCHITECTURE.md](ARCHITECTURE.md) explains the rooms and how data flows between them.

A row is a module, which is a header with its source, if it has one; its main declaration; and the first sentence of
that declaration's comment.
"""


def words(name):
    """The words of a name in snake_case or PascalCase, in small letters, without the endings of plurals and verbs."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z][a-z]*|[a-z]+|\d+", name)
    return {re.sub(r"(?<=ch)es$|s$|ing$", "", part.lower()) for part in parts}


def likeness(name, stem):
    """How like a declaration's name is to its header's: 1 for the same words, 0 for none in common."""
    if name.lower() == stem.replace("_", ""):
        return 1.1  # It differs from a singular or plural beside it.
    ours, theirs = words(name), words(stem)
    shared = len(ours & theirs) / max(1, len(ours | theirs))
    if re.match(r"k[A-Z]|is_", name):
        return shared / 2 - 0.02
    return shared - 0.01 * bool(re.search(HELPER, name))


def declared_name(code):
    """The name of the type, function or constant declared; None where the comment belongs to the whole header."""
    code = re.sub(r"\[\[.*?\]\]|template\s*<.*?>\s|alignas\(.*?\)", " ", code)
    if not code.strip() or code.lstrip().startswith("namespace"):
        return None
    for pattern in (r"\b(?:class|struct|enum class|enum|concept)\s+(\w+)", r"\busing\s+(\w+)\s*=", r"(\w+)\s*\("):
        found = re.search(pattern, code)
        if found:
            return found[1]
    found = re.search(r"(\w+)\s*(?:=|$)", code)
    return found[1] if found else None


def comments(text):
    """(comment, name) of each documented declaration of a header, class members excepted: they are indented."""
    lines = text.splitlines()
    at = 0
    while at < len(lines):
        comment = []
        while at < len(lines) and lines[at].startswith("///"):
            comment.append(lines[at][3:].strip())
            at += 1
        if comment:
            code = " ".join(lines[at:at + 3]) if at < len(lines) and lines[at] else ""
            yield comment, declared_name(re.split(r"///|;|\{", code)[0])
        at += 1


def first_sentence(comment):
    """The first sentence of a comment's first paragraph."""
    paragraph = []
    for line in comment:
        if not line:
            break
        paragraph.append(line)
    text = " ".join(paragraph)
    for end in re.finditer(r"(?<!\beq)(?<!\bFig)(?<!\b[A-Z])\.\s+(?=[A-Z`\"\[])", text):
        if text.count("[", 0, end.start()) == text.count("]", 0, end.start()):  # Not within a citation.
            text = text[:end.start()]
            break
    if len(text) > LONGEST:
        text = re.split(r"[:;]\s", text)[0]
    return text.rstrip(" .:;,") + "."


def cell(text):
    """Text that Markdown shows as it is, within a table."""
    return re.sub(r"([|*\\\[\]])", r"\\\1", text).replace("<", "&lt;")


def row(header):
    """The row of a module."""
    stem = header.stem
    documented = list(comments(header.read_text(encoding="utf-8")))
    link = f"[{stem}](../{header.relative_to(ROOT)})"
    if not documented:
        return f"| {link} | | |"
    main = MAIN.get(str(header.relative_to(ROOT)))
    if main and main not in (name for _, name in documented):
        sys.exit(f"docs/modules.py: MAIN names {main}, but {header.relative_to(ROOT)} documents no such declaration")
    # max() takes the first of several that are equal.
    comment, name = max(documented, key=lambda entry: 3 if entry[1] == main and main else
                        2 if entry[1] is None else likeness(entry[1], stem))
    return f"| {link} | {f'`{name}`' if name else ''} | {cell(first_sentence(comment))} |"


def page():
    """The whole page."""
    parts = [HEAD]
    for room in ROOMS:
        headers = sorted((ROOT / room).glob("*.h"))
        if headers:
            rows = "\n".join(row(header) for header in headers)
            parts.append(f"## {room}\n\n| module | declares | first sentence |\n|---|---|---|\n{rows}\n")
    return "\n".join(parts)


def main():
    made = page()
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(made, encoding="utf-8")
        return 0
    kept = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    stale = sorted(set(made.splitlines()) ^ set(kept.splitlines()))
    for line in stale[:20]:
        print(("now: " if line in made else "was: ") + line)
    if made != kept:
        print("docs/MODULES.md is not what the headers say: run python3 docs/modules.py")
        return 1
    print(f"{made.count('](../')} modules are as their headers say.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
