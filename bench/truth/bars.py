#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether Thenar holds to the bars of bars.json: bars.py BUILD. Each is asked of the program that the truth bench gives
its tasks to, and judged by the object's motion."""

import json
import sys
import tempfile
from pathlib import Path

try:
    import engines
    import measures
    import shapes
    import tasks
except ImportError as error:
    print(f"bars: {error}", file=sys.stderr)
    sys.exit(77)


def found(bar, engine, task, ask):
    """What is measured of a case, in the bar's measure, and whether it is within the bar."""
    if bar["measure"] == "least_friction":
        held = [measures.held(engine.run(ask(ratio=ratio))) for ratio in (1 + bar["most"], 1 - bar["most"])]
        return {(True, False): "held, slips", (True, True): "held below", (False, False): "slips above", (False, True): "the wrong way"}[tuple(held)], held == [True, False]
    values = tasks.JUDGES[task["measure"]](engine, ask, task)
    value = values.get(bar["measure"])
    if value is not None and bar.get("per_contact"):
        value /= max(values["contacts"], 1)
    return value, value is not None and value <= bar["most"]


def asked_by(engine, bar, case, folder):
    """The world of a case, with more changes: a function as the judges of tasks take it."""
    case = dict(case)
    name = case.pop("world")
    setting = dict(engine.peer["settings"][bar["setting"]].get("sets", {}))
    if "points" in case:
        setting["points"] = case.pop("points")
    return lambda **more: shapes.world(name, folder, setting=setting, **{**case, **bar["changes"], **more})


def main():
    if len(sys.argv) not in (2, 3):
        print("usage: bars.py BUILD [PART OF A NAME]", file=sys.stderr)
        return 2
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        engine = engines.Engine("Thenar", engines.commands(sys.argv[1])["Thenar"], folder)
        for bar in json.loads((Path(__file__).parent / "bars.json").read_text())["bars"]:
            if sys.argv[2:] and sys.argv[2] not in bar["name"]:
                continue
            task = tasks.task(bar["task"], **bar["changes"])
            for case in tasks.products(bar["cases"]):
                value, holds = found(bar, engine, task, asked_by(engine, bar, case, Path(folder)))
                missed += not holds
                print("ok    " if holds else "MISSED", bar["name"], case, value, flush=True)
        engine.close()
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
