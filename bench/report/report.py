#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the report of all parts in a folder: report.py FOLDER writes FOLDER/report.html. With a second folder, the
project's root, it also writes docs/measured.md there, and the README's table."""

import sys
from pathlib import Path

import analysis
import documents

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


def main():
    if len(sys.argv) not in (2, 3):
        print("usage: report.py FOLDER [ROOT]", file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    try:
        parts = analysis.read_parts(folder)
        if len(sys.argv) == 3:
            documents.write(Path(sys.argv[2]), parts, documents.dates_of(folder, parts))
        import page  # Needs gnuplot, which reading does not.

        (folder / "report.html").write_text(page.render(parts, analysis.scenes(CONFIGS), analysis.trials(folder)), encoding="utf-8")
    except (analysis.ReportError, OSError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 3
    print(folder / "report.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
