# SPDX-License-Identifier: Apache-2.0
"""What Python costs: a step, a batch of 1000, a law, many simulations on two cores, a law that stalls in real time.

Each figure is beside what the engine takes alone, in turns, and beside the proof that both did the same; in real time
beside what became of the object. Results also go to the file that is named. Ends with 1 if a proof fails.
"""

import gc
import json
import sys
import time
from statistics import median

import numpy as np
import thenar


def seconds(work):
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def in_turns(turns, *works):
    """Medians of what each takes [s]."""
    taken = [[seconds(work) for work in works] for _ in range(turns)]
    return [median(column) for column in zip(*taken)]


def steps(name, turns=41, ticks=1000):
    """One by one, in a batch, and by run(), whose loop is the engine's. Settled, so that every tick is the same work."""
    scene = thenar.Scene(name, {"time.duration": "1000 s"})
    one, batch, engine = (thenar.Simulation(scene) for _ in range(3))
    for simulation in (one, batch, engine):
        simulation.step(2 * ticks)

    def single():
        step = one.step
        for _ in range(ticks):
            step()

    span_s = ticks * scene.step_s
    taken = in_turns(turns, single, lambda: batch.step(ticks), lambda: engine.run(until=engine.time_s + span_s))
    same = np.array_equal(one.object, batch.object) and np.array_equal(one.object, engine.object)
    tick_us, batch_us, engine_us = (1e6 * t / ticks for t in taken)
    return {"scene": name, "step_us": tick_us, "batch_us": batch_us, "engine_us": engine_us, "same_bits": same}


def law(name, turns=21, periods=200):
    """A law that asks for the published torques, against none."""
    scene = thenar.Scene(name)
    ticks = round(scene.control_period_s / scene.step_s) * periods
    own = thenar.Simulation(scene, torques=lambda period: period.published_torques())
    none = thenar.Simulation(scene)
    taken = in_turns(turns, lambda: own.step(ticks), lambda: none.step(ticks))
    same = np.array_equal(own.object, none.object)
    return {"scene": name, "per_call_us": 1e6 * (taken[0] - taken[1]) / periods, "same_bits": same}


def cores(name, count=64, ticks=200, turns=7):
    """rollout() of many simulations with one thread and with two."""
    start = [thenar.Simulation(thenar.Scene(name)) for _ in range(count)]
    results = {}

    def roll(threads):
        copies = [simulation.copy() for simulation in start]
        begin = time.perf_counter()
        results[threads] = thenar.rollout(copies, ticks, every=ticks, threads=threads)["object"]
        return time.perf_counter() - begin

    ratios = []
    for _ in range(turns):
        one, two = roll(1), roll(2)
        ratios.append(one / two)
    same = np.array_equal(results[1], results[2])
    return {"scene": name, "simulations": count, "ratio": median(ratios), "all": ratios, "same_bits": same}


def real_time(name, duration="6 s", turns=9):
    """The contact tick's times without a law, with one, with one that collects garbage, and with one that stalls."""
    scene = thenar.Scene(name, {"time.step": "1 ms", "time.control_period": "5 ms", "time.duration": duration})
    litter = []

    def plain(period):
        return period.published_torques()

    def collect(period):
        if round(period.time_s / scene.control_period_s) % 200 == 199:
            litter[:] = [[i] for i in range(1_000_000)]
            gc.collect()
        return period.published_torques()

    def stall(period):
        if round(period.time_s / scene.control_period_s) % 200 == 199:
            time.sleep(0.3)
        return period.published_torques()

    results = {}
    for _ in range(turns):
        for label, own in (("none", None), ("law", plain), ("collects", collect), ("stalls", stall)):
            with thenar.Realtime(scene, torques=own) as loops:
                loops.wait()
                end_m = loops.state()["position_m"].tolist()
            report = loops.report
            kept = {"outcome": report["outcome"], "hold": report["hold"], "end_m": end_m}
            results.setdefault(label, []).append({**kept, "contact": report["loops"]["contact"]})
    return {"scene": name, "runs": results}


def main(file=None, *parts):
    works = {
        "steps": lambda: [steps("minimal"), steps("box_grasp")],
        "law": lambda: law("box_grasp"),
        "cores": lambda: [cores("box_grasp")],
        "real_time": lambda: real_time("box_grasp"),
    }
    unknown = [part for part in parts if part not in works]
    if unknown:
        sys.exit(f"there is no part '{unknown[0]}': {', '.join(works)}")
    figures = {}
    for part in parts or works:
        figures[part] = works[part]()
        print(json.dumps({part: figures[part]}, indent=1), flush=True)
        if '"same_bits": false' in json.dumps(figures[part]):
            sys.exit(f"{part}: not the same bits")
    if file:
        with open(file, "w", encoding="utf-8") as to:
            json.dump(figures, to, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
