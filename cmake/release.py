# SPDX-License-Identifier: Apache-2.0
"""Makes a version of the project: release.py <project> <version> [--dry-run].

Writes the version where it stands (CMakeLists.txt, CITATION.cff, CHANGELOG.md), commits that, tags it, and packs the
source of the tag in out/release. A dry run checks the same and shows the changes, but makes none.
"""
import argparse
import datetime
import difflib
import pathlib
import re
import subprocess
import sys

NEXT = "## Next\n"
FILES = ["CMakeLists.txt", "CITATION.cff", "CHANGELOG.md"]


def replaced(text, pattern, new, file):
    """The text with the one match of the pattern replaced."""
    text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
    if count != 1:
        sys.exit(f"release: {file}: has {count} places for {new!r}, and must have one")
    return text


def with_version(file, text, version, date):
    """The file's text in the new version."""
    if file == "CMakeLists.txt":
        return replaced(text, r"^project\(thenar VERSION \S+", f"project(thenar VERSION {version}", file)
    if file == "CITATION.cff":
        text = replaced(text, r"^version: .*$", f"version: {version}", file)
        return replaced(text, r"^date-released: .*$", f"date-released: {date}", file)
    return replaced(text, f"^{NEXT}", f"{NEXT}\n## {version} ({date})\n", file)


def parts(version):
    return tuple(map(int, version.split(".")))


def check(project, version):
    """What forbids a release."""
    if not re.fullmatch(r"(0|[1-9]\d*)(\.(0|[1-9]\d*)){2}", version):
        sys.exit(f"release: '{version}' is no version such as 1.2.3")
    now = re.search(r"^project\(thenar VERSION (\S+)", (project / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
    if parts(version) <= parts(now):
        sys.exit(f"release: {version} is not later than {now}, which CMakeLists.txt has")
    change = re.search(f"^{NEXT}(.*?)(?=^## |\\Z)", (project / "CHANGELOG.md").read_text(), re.MULTILINE | re.DOTALL)
    if not change or not change[1].strip():
        sys.exit("release: CHANGELOG.md says nothing under 'Next'")


def write(project, git, version, dry_run):
    """Writes the version, commits and tags it; in a dry run shows what would be written."""
    date = datetime.date.today().isoformat()
    before = {file: (project / file).read_text() for file in FILES}
    after = {file: with_version(file, text, version, date) for file, text in before.items()}
    if dry_run:
        for file in FILES:
            lines = [text[file].splitlines(keepends=True) for text in (before, after)]
            sys.stdout.writelines(difflib.unified_diff(*lines, f"a/{file}", f"b/{file}", n=1))
        return
    for file, text in after.items():
        (project / file).write_text(text)
    git("commit", "--quiet", "--message", f"Release {version}", *FILES)
    git("tag", "--annotate", "--message", f"Thenar {version}", f"v{version}")


def main():
    parser = argparse.ArgumentParser(prog="./dev release", description="Makes a version of the project.")
    parser.add_argument("project", type=pathlib.Path)
    parser.add_argument("version", help="such as 1.2.3")
    parser.add_argument("--dry-run", action="store_true", help="checks, and shows the changes, but makes none")
    options = parser.parse_args()
    project, version = options.project, options.version

    def git(*arguments):
        done = subprocess.run(["git", "-C", project, *arguments], stdout=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"release: git {arguments[0]} failed")
        return done.stdout

    changed = git("status", "--porcelain")
    if changed:
        sys.exit(f"release: these files are not committed:\n{changed}")
    # A release that ended before its files were made is not begun again.
    if f"v{version}" not in git("tag", "--points-at", "HEAD").split():
        check(project, version)
        write(project, git, version, options.dry_run)
    if not options.dry_run:
        folder = project / "out" / "release"
        folder.mkdir(parents=True, exist_ok=True)
        archive = folder / f"thenar-{version}.tar.gz"
        git("archive", f"--prefix=thenar-{version}/", f"--output={archive.resolve()}", f"v{version}")


if __name__ == "__main__":
    main()
