# SPDX-License-Identifier: Apache-2.0
"""The guides say what the program does.

    commands.py run THENAR      runs the commands of the README and the guides as they are printed, in a new folder
    commands.py names THENAR    checks that each command, flag and key that they name exists

`./dev` is the program here: what ./dev does beside that, such as to build and to measure, is not run.
"""
from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
# The first ones make files that others use.
FIRST = ["docs/guide/objects.md", "docs/guide/hands.md"]
LIMIT_S = 600  # Nothing takes a tenth of it on an idle machine.

# Why a command is not run; a name covers all that begin with it. Each must be in a document.
NOT_RUN = {
    "./dev test": "builds and runs all tests",
    "./dev bench": "measures for minutes to hours",
    "/usr/bin/python3 bench/truth/truth.py": "needs the build of ./dev bench truth",
    "./dev demo": "serves a page until it is stopped: tests/app/window_program_test.cpp",
    "./dev run configs/box_grasp.yaml --realtime --time 30s": "takes a minute: tests/app/jitter_floor_test.cpp",
    "./dev export out/grasp.mcap --html": "needs the page, which npm makes: tests/app/export_test.cpp",
    "mpirun": "needs several machines: tests/app/ranks_test.cpp",
    "wc -l FOLDER/journal-": "counts rows of that",
}
# What makes a command shorter here: the same flags, keys and files, and less time.
SHORTER = {
    "./dev run configs/resting_box.yaml": "--time 0.2s",
    "./dev insertion configs/peg_wedged.yaml": "--set time.duration=0.2s",
    "./dev sweep": "--set time.duration=0.05s --set task={}",
    "./dev solve": "--repeat 1",
}
# The exit code of a command that shows a failure.
ENDS_WITH = {
    "./dev run configs/box_grasp.yaml --set contact.friction=0.2": 7,
    "./dev run configs/box_grasp.yaml --set contact.frction=0.2": 2,
    './dev run configs/box_grasp.yaml --set "contact.band=0.3 s"': 2,
    './dev run configs/box_load.yaml --set "control.position.p=800 N/m"': 10,
}
# What a command needs that a machine may lack: it then ends with 2, and names that.
MAY_LACK = {"./dev solve out/problems/contact-000025.fcp --write": "HDF5"}
# In code as flags and keys are, and neither of the program.
FLAGS_OF_OTHERS = ["--enable-recovery"]
TABLES = (NOT_RUN, SHORTER, ENDS_WITH, MAY_LACK)
FILES = (".yaml", ".png", ".svg", ".json", ".csv")


def documents() -> list[Path]:
    guides = sorted(str(path.relative_to(PROJECT)) for path in (PROJECT / "docs/guide").glob("*.md"))
    return [PROJECT / name for name in [*FIRST, "README.md", *(name for name in guides if name not in FIRST)]]


def shell_commands(text: str) -> list[str]:
    """The commands of a document: lines of blocks without a language, with what follows a <<'END'. The other lines of
    such a block show what is printed."""
    commands, in_block, in_shell, here = [], False, False, False
    for line in text.splitlines():
        line = line.strip()
        if line.startswith("```"):
            in_shell = not in_block and line == "```"
            in_block = not in_block
        elif here:
            commands[-1] += "\n" + line
            here = line != "END"
        elif in_shell and re.match(r"(\./dev|thenar(?= [a-z])|cat|awk|mpirun|wc|/usr/bin/python3) ", line):
            commands.append(re.sub(r"\s+#.*", "", line))
            here = line.endswith("<<'END'")
    return commands


def matching(table: dict, command: str) -> str | None:
    """The longest name of a table that a command begins with."""
    return max((name for name in table if command.startswith(name)), key=len, default=None)


def end_of(command: str, folder: Path) -> tuple[int | str, str]:
    """The exit code of a command in a folder, and what it printed."""
    try:
        result = subprocess.run(["sh", "-c", command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return f"no end in {LIMIT_S} s", ""
    return result.returncode, result.stdout


def run_all(program: Path) -> list[str]:
    faults, used, ran = [], set(), 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("configs", "examples", "tests"):
            (folder / part).symlink_to(PROJECT / part)
        (folder / "dev").write_text(f'#!/bin/sh\nexec {shlex.quote(str(program))} "$@"\n')
        (folder / "dev").chmod(0o755)
        for document in documents():
            for command in shell_commands(document.read_text()):
                used.update(filter(None, (matching(table, command) for table in TABLES)))
                if matching(NOT_RUN, command):
                    continue
                shorter = SHORTER.get(matching(SHORTER, command), "")
                code = ENDS_WITH.get(matching(ENDS_WITH, command), 0)
                start = os.times()
                ended, text = end_of(f"{command} {shorter}" if shorter else command, folder)
                ran += 1
                took_s = os.times().children_user - start.children_user  # Of a processor, whatever else runs beside.
                print(f"{took_s:6.1f} s  {document.name}: {command.splitlines()[0]} {shorter}", flush=True)
                lacked = MAY_LACK.get(matching(MAY_LACK, command))
                if ended != code and not (ended == 2 and lacked and lacked in text):
                    faults.append(f"{document.relative_to(PROJECT)}: {command} {shorter}\n"
                                  f"ended with {ended}, not {code}:\n{text[-2000:]}")
    for name in {name for table in TABLES for name in table} - used:
        faults.append(f"no document has the command: {name}")
    for name, reason in NOT_RUN.items():
        faults += [f"no file {test} tests {name}" for test in re.findall(r"tests/\S+", reason)
                   if not (PROJECT / test).is_file()]
    if ran < 20:
        faults.append(f"only {ran} commands were found")
    return faults


def said(*command: str | Path) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def subcommands(help_text: str) -> list[str]:
    return re.findall(r"^  ([a-z]+)  ", help_text.split("Subcommands:")[-1], re.MULTILINE)


def helps_of(program: Path) -> dict[str, str]:
    """The help of each command; of demo its source, because the window is not built everywhere."""
    names = subcommands(said(program, "--help"))
    helps = {name: said(program, name, "--help") for name in names if name != "demo"}
    sources = [PROJECT / "app/window/main.cpp", *(PROJECT / "app").glob("*_flags.cpp")]
    helps["demo"] = "".join(path.read_text() for path in sources)
    for name in subcommands(helps["hand"]):
        helps["hand"] += said(program, "hand", name, "--help")
    return helps


def keys_of(program: Path) -> set[str]:
    """The keys of scenes, and of their maps: of a list's element without the number."""
    keys = {re.sub(r"\[\d*\]", "", line.split()[0]) for line in said(program, "keys").splitlines() if line.strip()}
    return {".".join(key.split(".")[:depth]) for key in keys for depth in range(1, key.count(".") + 2)}


def commands_of_dev(dev: str) -> set[str]:
    """Where ./dev names its commands: `  run | check)`."""
    cases = re.findall(r"^  ([a-z -]+(?: \| [a-z-]+)*)\)(?: |$)", dev, re.MULTILINE)
    return {word for case in cases for word in case.split(" | ")}


def check_names(program: Path) -> list[str]:
    """Commands, flags and keys that documents name in code. What decisions say was true on their day: of them, and of
    references, which the program writes, commands alone."""
    helps, keys, dev = helps_of(program), keys_of(program), (PROJECT / "dev").read_text()
    known = {"thenar": set(helps), "./dev": commands_of_dev(dev)}
    roots = {key.split(".")[0] for key in keys if "." in key}
    flags = " ".join([*helps.values(), dev, (PROJECT / "bench/truth/truth.py").read_text(), *FLAGS_OF_OTHERS])
    faults, checked = [], 0
    pages = [*PROJECT.glob("*.md"), *PROJECT.glob("docs/*.md"), *PROJECT.glob("docs/*/*.md")]
    for page in sorted(set(pages) - {PROJECT / "CHANGELOG.md"}):
        text, where = page.read_text(), page.relative_to(PROJECT)
        codes = shell_commands(text) + [" ".join(code.split()) for code in re.findall(r"(?<!`)`([^`]+)`(?!`)", text)]
        for code in codes:
            if found := re.match(r"(\./dev|thenar) ([a-z]+)\b", code):
                checked += 1
                tool, command = found.groups()
                if command not in known[tool]:
                    faults.append(f"{where}: {tool} has no command '{command}'")
                own = helps.get(command, "") + (dev if tool == "./dev" else "")
                if page in documents():
                    faults += [f"{where}: {tool} {command} has no {flag}"
                               for flag in re.findall(r"(?<= )--[a-z][a-z-]+", code) if not re.search(rf"{flag}\b", own)]
            elif page in documents() and (found := re.match(r"--[a-z][a-z-]+", code)):
                checked += 1
                if not re.search(rf"{found.group()}\b", flags):
                    faults.append(f"{where}: nothing has the flag {found.group()}")
            elif page in documents() and re.fullmatch(r"[a-z_]+(\.[a-z_]+)+", code) and code.split(".")[0] in roots:
                checked += 1
                if code not in keys and not code.endswith(FILES):
                    faults.append(f"{where}: there is no key {code}")
    if checked < 100:
        faults.append(f"only {checked} names were found")
    return faults


def main(what: str, program: Path) -> int:
    faults = {"run": run_all, "names": check_names}[what](program.resolve())
    print("\n".join(sorted(set(faults))))
    return 1 if faults else 0


if __name__ == "__main__":
    os.environ.pop("DISPLAY", None)
    sys.exit(main(sys.argv[1], Path(sys.argv[2])))
