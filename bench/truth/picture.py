#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws one held box in MuJoCo and in Thenar, side by side, as both moved it: picture.py BUILD FILE.svg."""

import sys
import tempfile
from pathlib import Path

import engines
import measures
import tasks

MARGIN, SECONDS, EVERY = 1.5, 40, 10
SHOWN = [("MuJoCo", "manual: elliptic, impratio 10", "MuJoCo {}, as its manual advises"),
         ("Thenar", "rigid tips", "Thenar, as it comes")]
SCALE, WIDTH, HEIGHT = 2.6, 380, 270  # pixels a mm, and of a panel


def moved_mm(name, setting, command, folder):
    """How far the box went by each of the times that are drawn, and its engine's version."""
    engine = engines.Engine(name, command, folder)
    world = tasks.world_of({"world": "box", "margin": MARGIN}, engine, setting, duration=SECONDS + measures.LOADED_s, lost=0.1)
    run = engine.run(world)
    engine.close()
    moved = 1e3 * measures.moved(run)
    ticks = [min(len(moved) - 1, round((measures.LOADED_s + t) / world["step"])) for t in range(0, SECONDS + 1, EVERY)]
    return [float(moved[i]) for i in ticks], engine.version


def nanometres(moved_mm):
    """What cannot be seen, as a number."""
    return "" if moved_mm > 0.05 else f": {1e6 * abs(moved_mm):.2g} nm"


def panel(x, title, moved):
    half, tip, apart = 20 * SCALE, 8 * SCALE, 10 * SCALE
    middle, top = x + WIDTH / 2, 125
    parts = [f'<text x="{middle}" y="24" class="title">{title}</text>',
             f'<circle cx="{middle - half - tip}" cy="{top}" r="{tip}" class="tip"/>',
             f'<circle cx="{middle + half + tip}" cy="{top}" r="{tip}" class="tip"/>']
    for k, mm in enumerate(moved):
        last = k == len(moved) - 1
        y = top - half + SCALE * mm
        parts.append(f'<rect x="{middle - half}" y="{y:.2f}" width="{2 * half}" height="{2 * half}" class="{"box" if last else "was"}"/>')
    for k, mm in reversed(list(enumerate(moved))):
        if k == len(moved) - 1 or moved[-1] > 5:
            parts.append(f'<text x="{middle + half + 6}" y="{top + half + SCALE * mm - 4:.2f}" class="time">{EVERY * k} s</text>')
    way = f"{moved[-1]:.1f} mm" if moved[-1] > 0.05 else "nowhere"
    parts.append(f'<text x="{middle}" y="{HEIGHT - 12}">It went {way} in {SECONDS} s{nanometres(moved[-1])}.</text>')
    return parts


def main():
    if len(sys.argv) != 3:
        print("usage: picture.py BUILD FILE.svg", file=sys.stderr)
        return 2
    commands, parts = engines.commands(sys.argv[1]), []
    with tempfile.TemporaryDirectory() as folder:
        for i, (name, setting, title) in enumerate(SHOWN):
            moved, version = moved_mm(name, setting, commands[name], folder)
            parts += panel(i * WIDTH, title.format(version.split()[-1]), moved)
    style = ("text{font:13px 'DejaVu Sans',sans-serif;fill:#1c1c1c;text-anchor:middle}.title{font-weight:bold}"
             ".time{font-size:11px;fill:#5a5a5a;text-anchor:start}.tip{fill:#e8b89a;stroke:#8a5a3c}"
             ".box{fill:#9cc3e4;stroke:#1f4f8a;stroke-width:1.5}.was{fill:none;stroke:#1f4f8a;stroke-dasharray:4 3}")
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * WIDTH}" height="{HEIGHT}" viewBox="0 0 {2 * WIDTH} {HEIGHT}">',
             f"<style>{style}</style>", f'<rect width="{2 * WIDTH}" height="{HEIGHT}" fill="white"/>', *parts, "</svg>"]
    Path(sys.argv[2]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
