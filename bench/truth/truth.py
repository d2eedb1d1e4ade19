#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gives tasks with exact answers to Thenar and to what others would take instead."""

import argparse
import concurrent.futures
import json
import math
import os
import statistics
import sys
import time
from pathlib import Path

import engines
import pages
import tasks

STORED = Path(__file__).resolve().parent / "stored.json"


def changes_of(engine, task):
    """What a task changes in its worlds. A slow engine is given less time for what only drifts, which pages.py tells."""
    longest = engine.peer.get("creep_s", math.inf) if task["measure"] == "creep" else math.inf
    return {**task["changes"], "duration": min(task["changes"]["duration"], longest)}


def measure(engine, setting, task, case):
    """What a task finds of an engine in a case: {measure: value}, or {"error": text}."""
    world = lambda **more: tasks.world_of(case, engine, setting, **changes_of(engine, task), **more)
    try:
        return tasks.JUDGES[task["measure"]](engine, world, task)
    except RuntimeError as error:
        return {"error": str(error)}


def measure_all(task, running, say):
    """Rows of all engines at all settings. What is not timed runs on all processors; what is timed goes round by round on
    one, so that no engine has the machine at its best."""
    rounds, values = task.get("rounds", 1), {}

    def measure_cases(of):
        engine, setting = of
        found = []
        if task["name"] in engine.peer["settings"][setting].get("only", [task["name"]]):
            for case in task["cases"]:
                found.append((case, measure(engine, setting, task, case)))
                say(task, engine, setting, *found[-1])
        return found

    turns = running * rounds
    with concurrent.futures.ThreadPoolExecutor(1 if rounds > 1 else os.cpu_count()) as pool:
        for (engine, setting), found in zip(turns, pool.map(measure_cases, turns)):
            for case, value in found:
                values.setdefault((engine.name, setting, json.dumps(case)), []).append(value)
    return [{"task": task["name"], "engine": name, "setting": setting, "case": json.loads(case),
             "values": {"us": statistics.median(f["us"] for f in found)} if len(found) > 1 else found[0]}
            for (name, setting, case), found in values.items()]


def each_once(running):
    """The engines, at the first of their settings."""
    return [engine for engine, setting in running if setting == next(iter(engine.peer["settings"]))]


def measured(running, quick):
    """What a part of the report says of how it was measured."""
    ours = next((engine for engine in each_once(running) if engine.build), None)
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    model = next((line.split(": ", 1)[1] for line in lines if line.startswith("model name")), "an unknown processor")
    peers = ", ".join(engine.version for engine in each_once(running) if engine is not ours)
    return {**(ours.build if ours else {}), "machine": model, "threads": os.cpu_count(), "peers": peers, "quick": quick}


def with_stored(rows, chosen):
    """The rows, and those of missing engines as they are stored."""
    stored = json.loads(STORED.read_text())["rows"] if STORED.exists() else []
    have = {row["engine"] for row in rows}
    tasks_run = {row["task"] for row in rows}
    return rows + [{**row, "stored": True} for row in stored
                   if row["engine"] in chosen and row["engine"] not in have and row["task"] in tasks_run]


def store(rows, running):
    """Renews what is stored of the engines that ran; the others keep theirs."""
    before = json.loads(STORED.read_text()) if STORED.exists() else {"engines": {}, "rows": []}
    ran = {engine.name: engine.version for engine in each_once(running) if not engine.peer.get("ours")}
    kept = [row for row in before["rows"] if row["engine"] not in ran]
    made = {"engines": {**before["engines"], **ran}, "rows": kept + [row for row in rows if row["engine"] in ran]}
    STORED.write_text(json.dumps(made, separators=(",", ":")).replace('{"task"', '\n{"task"') + "\n")


def options_of(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", help="the build folder that has the engines' programs")
    parser.add_argument("out", help="the folder of the report: truth.json is written there")
    parser.add_argument("--quick", action="store_true", help="shorter runs")
    parser.add_argument("--no-peers", action="store_true", help="Thenar alone")
    parser.add_argument("--store", action="store_true", help="renews bench/truth/stored.json, what is shown of a missing engine")
    parser.add_argument("--task", action="append", choices=tasks.names(), help="this task alone, printed and not written")
    parser.add_argument("--engine", action="append", choices=list(engines.PEERS), help="this engine alone")
    return parser.parse_args(arguments)


def main():
    options = options_of(sys.argv[1:])
    out = Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    chosen = options.engine or (["Thenar"] if options.no_peers else list(engines.PEERS))
    commands = {name: command for name, command in engines.commands(options.build).items() if name in chosen}
    missing = [name for name in chosen if name not in commands]
    if "Thenar" in missing:
        print(f"truth: {options.build} has no program of Thenar: build truth_thenar", file=sys.stderr)
        return 2
    if missing:
        print(f"truth: not here, and shown as stored: {', '.join(missing)}", file=sys.stderr)
    running = [(engines.Engine(name, command, out / "truth" / f"{name} {i}"), setting)
               for name, command in commands.items() for i, setting in enumerate(engines.PEERS[name]["settings"])]

    def say(task, engine, setting, case, values):
        if options.task:
            print(engine.name, setting, case, values, sep=" | ", flush=True)

    rows = []
    for name in options.task or tasks.names():
        start = time.monotonic()
        rows += measure_all(tasks.task(name, options.quick), running, say)
        print(f"truth: {name}, {time.monotonic() - start:.0f} s", file=sys.stderr)
    for engine, _ in running:
        engine.close()
    if options.store:
        store(rows, running)
    if not options.task:
        part = pages.part(with_stored(rows, chosen), measured(running, options.quick))
        (out / "truth.json").write_text(json.dumps(part, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
