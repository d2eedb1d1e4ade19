# SPDX-License-Identifier: Apache-2.0
"""Builds the site of the documents, searchable and without a network: `./dev docs`.

    build.py WORK HTML   WORK holds what is made on the way, HTML becomes the site.

The site is laid out as the project is: the documents, the headers that are installed, and the sources that documents
link to, each a page where it lies in the project, so that relative links lead to the same place here and there.
PYTHONPATH must name the built package. Ends with 77 where a program or a library is missing.
"""
from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
NEEDED = {"sphinx": "python3-sphinx", "myst_parser": "python3-myst-parser", "furo": "furo", "breathe": "python3-breathe",
          "numpy": "python3-numpy"}
LINK = re.compile(r"\]\((?![a-z]+:)([^)#\s]+)")


def missing() -> list[str]:
    """The Debian packages that are not there."""
    packages = [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]
    return packages + ([] if shutil.which("doxygen") else ["doxygen"])


def documents() -> list[Path]:
    """All but the README, in whose place the site has docs/index.md."""
    found = [*PROJECT.glob("*.md"), *PROJECT.glob("docs/*.md"), *PROJECT.glob("docs/*/*.md")]
    return [path for path in found if path != PROJECT / "README.md"]


def headers() -> list[Path]:
    """The headers that are installed, as cmake/install.cmake has them."""
    found = [path for room in ("solvers", "collision", "engine") for path in (PROJECT / room).rglob("*.h")]
    return [path for path in found if "imports" not in path.parts]


def linked() -> list[Path]:
    """The files, but for other headers, that documents link to or show."""
    targets = ((page.parent / target).resolve() for page in documents() for target in LINK.findall(page.read_text()))
    return [target for target in targets if target.is_file() and target.suffix not in (".md", ".h")]


def lay_out(tree: Path) -> None:
    """Makes the tree of what the site shows, of links to the project's files."""
    shutil.rmtree(tree, ignore_errors=True)
    for path in {*documents(), *headers(), *linked(), *PROJECT.glob("docs/site/*.rst")}:
        link = tree / path.relative_to(PROJECT)
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(path)


def describe_headers(work: Path) -> None:
    """Reads the comments of the headers into XML."""
    settings = (PROJECT / "docs/site/Doxyfile").read_text()
    settings += f'OUTPUT_DIRECTORY = "{work}/doxygen"\nSTRIP_FROM_PATH = "{PROJECT}"\nSTRIP_FROM_INC_PATH = "{PROJECT}"\n'
    made = work / "doxygen/xml/index.xml"
    if made.exists() and all(path.stat().st_mtime < made.stat().st_mtime for path in headers()):
        return  # What depends on it need not be read again.
    (work / "doxygen").mkdir(exist_ok=True)
    subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=PROJECT, check=True)


def main(work: Path, html: Path) -> int:
    if packages := missing():
        print(f"skipped: the site needs the packages {', '.join(packages)}: `./dev docs` installs them", file=sys.stderr)
        return 77
    if importlib.util.find_spec("thenar") is None:
        print("skipped: the site needs the built Python package: `./dev docs` builds it", file=sys.stderr)
        return 77
    work.mkdir(parents=True, exist_ok=True)
    lay_out(work / "tree")
    describe_headers(work)
    environment = {**os.environ, "THENAR_DOXYGEN": f"{work}/doxygen/xml"}
    command = [sys.executable, "-B", "-m", "sphinx", "-W", "--keep-going", "-q", "-N", "-b", "html",
               "-c", str(PROJECT / "docs/site"), "-d", f"{work}/doctrees", str(work / "tree"), str(html)]
    return subprocess.run(command, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()))
