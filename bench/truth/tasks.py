# SPDX-License-Identifier: Apache-2.0
"""Tasks as data: a file of tasks/ names worlds, what is varied, and which of the functions below judges a run."""

import itertools
import json
import math
from pathlib import Path

import numpy

import measures
import worlds

FOLDER = Path(__file__).resolve().parent / "tasks"


def products(cases):
    """All combinations of what each entry varies, {name: values}, as a list of {name: value}."""
    return [dict(zip(of, values)) for of in cases for values in itertools.product(*of.values())]


def task(name, quick=False, **changes):
    """The task of a file, with its cases as a list of {what is varied: value}."""
    data = json.loads((FOLDER / f"{name}.json").read_text())
    data["changes"] = {**data["changes"], **(data.get("quick", {}) if quick else {}), **changes}
    data["name"] = name
    data["cases"] = products(data["cases"])
    return data


def names():
    return sorted(file.stem for file in FOLDER.glob("*.json"))


def slope_of(case):
    """The tangent of the slope of a case of the grid."""
    return math.tan(math.radians(case["slope_degrees"]))


def world_of(case, engine, setting, **more):
    """The world of a case for an engine at a setting."""
    changes = {**case, **more}
    name = changes.pop("world")
    if changes.get("step") == "own":
        changes["step"] = engine.peer["step"]
    if "slope_degrees" in changes:
        changes["margin"] = changes["friction"] / slope_of(changes)
        del changes["slope_degrees"]
    return worlds.world(name, setting=engine.peer["settings"][setting].get("sets", {}), **changes)


def contacts_of(run):
    """How many there are, as a rule; None of an engine that does not tell."""
    return None if numpy.isnan(run.contacts).any() else float(numpy.median(run.contacts))


def creep(engine, world, task):
    run = engine.run(world())
    return {"um_per_s": measures.creep_um_per_s(run), "lost_s": measures.lost_s(run), "contacts": contacts_of(run)}


def held(engine, world, task):
    return {"held": measures.held(engine.run(world()))}


def critical(engine, world, task):
    """The least friction that holds over the exact one, less 1, in %; None where nothing in the range holds."""
    (low, high), steps = task["range"], 0
    if not measures.held(engine.run(world(ratio=high))):
        return {"error_percent": None}
    if measures.held(engine.run(world(ratio=low))):
        return {"error_percent": 100 * (low - 1), "at_least": True}
    while high - low > task["resolution"]:
        middle = 0.5 * (low + high)
        # Most engines are near the exact value: the first steps look there.
        middle = {0: 1.005, 1: 0.995 if high < 1.01 else middle}.get(steps, middle)
        steps += 1
        if measures.held(engine.run(world(ratio=middle))):
            high = middle
        else:
            low = middle
    return {"error_percent": 100 * (0.5 * (low + high) - 1)}


def energy(engine, world, task):
    asked = world()
    push, end = task["push"], asked["duration"]
    rest = engine.run(asked)
    since = push["from"] + push["over"]
    times = [push["from"], push["from"], since, since]
    asked["loads"].append({"force": push["force"], "moment": [0, 0, 0], "times": times, "factors": [0, 1, 1, 0]})
    pushed = engine.run(asked)
    watts = measures.injected_J(rest, 2.0) / (end - 2.0)
    return {"rest_W": watts, "contacts": contacts_of(rest), "pushed_J": measures.injected_J(pushed, since, since + 4.0)}


def reversals(engine, world, task):
    asked = world()
    of = asked["loads"][0]
    times, factors = [], []
    for k in range(task["times"]):
        start = task["from"] + k * task["period"]
        times += [start, start + 0.25 * task["period"], start + 0.75 * task["period"]]
        factors += [0, task["share"], -task["share"]]
    end = task["from"] + task["times"] * task["period"]
    asked["loads"].append({"force": of["force"], "moment": [0, 0, 0], "times": times + [end], "factors": factors + [0]})
    run = engine.run(asked)
    if measures.lost_s(run) is not None:
        return {"lost_s": measures.lost_s(run)}
    at = lambda cycles: float(run.along()[round((task["from"] + cycles * task["period"]) / asked["step"]) - 1])
    # The first ones may shift what is sheared the other way, until the patches have settled.
    last = (run.time > end - task["period"]) & (run.time <= end)
    return {"travel_nm": 1e9 * float(numpy.ptp(run.along()[last])), "open_nm": 1e9 * abs(at(task["times"]) - at(task["times"] - 1)),
            "walk_nm": 1e9 * abs(at(task["times"]) - at(1))}


def answer(engine, world, task):
    asked = world()
    mass, step = asked["mass"], asked["step"]
    weight = mass * worlds.GRAVITY
    push = task["excess"] * asked["friction"] * weight
    asked["loads"].append({"force": [push, 0, 0], "moment": [0, 0, 0], "times": [task["from"], task["from"]], "factors": [0, 1]})
    run = engine.run(asked)
    first = round(task["from"] / step)
    went = (run.at[first:, 0] - run.at[first - 1, 0])
    net, k = push - asked["friction"] * weight, numpy.arange(1, len(went) + 1)
    # Without inertia it goes v h k. With it, a step that takes the new speed for its whole length goes a h^2 k (k + 1) / 2,
    # one that is cut into parts less, and never less than a t^2 / 2.
    speed = net / asked["damping"] * step * k
    least, most = (speed, speed) if engine.peer.get("ours") else (0.5 * net / mass * (step * k)**2, 0.5 * net / mass * step**2 * k * (k + 1))
    late = numpy.flatnonzero((went > 0.9 * least) & (went < 1.1 * most))
    return {"steps": int(late[0]) + 1 if len(late) else None}


def speed(engine, world, task):
    return {"us": measures.median_us(engine.run(world()))}


JUDGES = {judge.__name__: judge for judge in (creep, held, critical, energy, reversals, answer, speed)}
