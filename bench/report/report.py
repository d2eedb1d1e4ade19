#!/usr/bin/env python3
"""Draws the report of all parts in a folder: report.py FOLDER writes FOLDER/report.html."""

import sys
from pathlib import Path

import analysis

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


def main():
    if len(sys.argv) != 2:
        print("usage: report.py FOLDER", file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    try:
        parts = analysis.read_parts(folder)
        import page  # Needs matplotlib, which reading does not.

        (folder / "report.html").write_text(page.render(parts, analysis.scenes(CONFIGS), analysis.trials(folder)), encoding="utf-8")
    except (analysis.ReportError, OSError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 3
    print(folder / "report.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
