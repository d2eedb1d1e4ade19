#!/usr/bin/env python3
"""Gives tasks with exact answers to Thenar and to what others would take instead.

usage: truth.py BUILD OUT [--quick] [--task NAME] ...   BUILD is a build folder; OUT/truth.json is written, a part of
                                                        the report; engines that are missing are shown as they are stored
       truth.py BUILD OUT --store                       measures, and renews bench/truth/stored.json
"""

import argparse
import json
import statistics
import sys
import time
from pathlib import Path

import engines
import tasks


def measure(engine, setting, task, case):
    """What a task finds of an engine in a case: {measure: value}, or {"error": text}."""
    world = lambda **more: tasks.world_of(case, engine, setting, **task["changes"], **more)
    try:
        return tasks.JUDGES[task["measure"]](engine, world, task)
    except RuntimeError as error:
        return {"error": str(error)}


def wants(engine, setting, task):
    return task["name"] in engine.peer["settings"][setting].get("only", [task["name"]])


def measure_all(task, running, say):
    """Rows of all engines at all settings. Timed tasks go round by round, so that none has the machine at its best."""
    rows = {}
    for _ in range(task.get("rounds", 1)):
        for engine in running:
            for setting in engine.peer["settings"]:
                for case in task["cases"] if wants(engine, setting, task) else []:
                    key = (engine.name, setting, json.dumps(case))
                    rows.setdefault(key, []).append(measure(engine, setting, task, case))
                    say(task, engine, setting, case, rows[key][-1])
    made = []
    for (name, setting, case), found in rows.items():
        values = found[0] if len(found) == 1 else {"us": statistics.median(f["us"] for f in found)}
        made.append({"task": task["name"], "engine": name, "setting": setting, "case": json.loads(case), "values": values})
    return made


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("out")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--no-peers", action="store_true")
    parser.add_argument("--task", action="append")
    parser.add_argument("--engine", action="append")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    out = Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    chosen = options.engine or (["Thenar"] if options.no_peers else list(engines.PEERS))
    running = [engines.Engine(name, command, out / "truth") for name, command in engines.commands(options.build).items() if name in chosen]

    def say(task, engine, setting, case, values):
        if options.verbose:
            print(task["name"], engine.name, setting, case, values, flush=True)

    rows = []
    for name in options.task or tasks.names():
        start = time.monotonic()
        rows += measure_all(tasks.task(name, options.quick), running, say)
        print(f"truth: {name}, {time.monotonic() - start:.0f} s", file=sys.stderr)
    for engine in running:
        engine.close()
    (out / "truth_rows.json").write_text(json.dumps({"engines": {e.name: e.version for e in running}, "rows": rows}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
