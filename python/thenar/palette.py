# SPDX-License-Identifier: Apache-2.0
"""The colours of the live window and of the program's figures, for figures of your own. Colour-blind viewers tell those of
fingers, of axes and of normal and tangential forces apart."""
from __future__ import annotations

import json
from pathlib import Path

_colors = json.loads((Path(__file__).parent / "share" / "palette.json").read_text(encoding="utf-8"))

#: "x", "y", "z" of paths, "normal" and "tangential" of forces.
SIGNALS: dict[str, str] = _colors["light"]
#: Of each finger, the thumb first.
FINGERS: list[str] = _colors["fingers"]
#: Of other curves.
OTHERS: list[str] = _colors["others"]
#: Of each outcome of a run, as areas of a map.
OUTCOMES: dict[str, str] = _colors["outcomes"]
