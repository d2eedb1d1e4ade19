# SPDX-License-Identifier: Apache-2.0
"""Worlds as data: a file of worlds/ with its parameters, whose numbers may be formulas of them, becomes a world that
bench/truth/peers/peer.h describes. Its critical friction, the least that Coulomb's law needs to hold, is exact."""

import json
import math
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "worlds"
GRAVITY = 9.80665  # m/s^2

# What every world has unless its file says otherwise. Fingers have mass and a damped slide where an engine has inertia;
# the damping of an object is for engines without [N s/m].
COMMON = {"at": [0, 0, 0], "attitude": [1, 0, 0, 0], "fingers": [], "walls": [], "finger_mass": 0.05,
          "finger_damping": 5, "damping": 1, "step": 1e-3, "duration": 1, "lost": 0.02, "setting": {}}


def lean_in_slot(half_width, half_slot, depth):
    """The angle [rad] at which a peg touches one side of a slot at its mouth and the other one at this depth."""
    angle = 0.0
    for _ in range(100):
        angle = math.asin((2 * half_slot * math.cos(angle) - 2 * half_width) / depth)
    return angle


def least_friction(p1, n1, p2, n2, load, at):
    """The least friction with which two contacts bear a load in the plane (x, z): at points p, their normals n to the
    body, the load with a line of action through a point. Both forces and the load meet in a point of that line; there
    the larger of the two angles between force and normal is least."""
    def slope(meets, p, n):
        dx, dz = meets[0] - p[0], meets[1] - p[1]
        normal, across = dx * n[0] + dz * n[1], dx * n[1] - dz * n[0]
        return math.inf if normal == 0 else abs(across / normal)

    def forces_press(meets):
        a = [meets[0] - p1[0], meets[1] - p1[1]]
        b = [meets[0] - p2[0], meets[1] - p2[1]]
        det = a[0] * b[1] - a[1] * b[0]
        if det == 0:
            return False
        f1 = (-load[0] * b[1] + load[1] * b[0]) / det
        f2 = (-a[0] * load[1] + a[1] * load[0]) / det
        return (f1 * (a[0] * n1[0] + a[1] * n1[1]) > 0) and (f2 * (b[0] * n2[0] + b[1] * n2[1]) > 0)

    def worst(s):
        meets = [at[0] + s * load[0], at[1] + s * load[1]]
        return max(slope(meets, p1, n1), slope(meets, p2, n2)) if forces_press(meets) else math.inf

    best = min((worst(s), s) for s in (k * 1e-5 for k in range(-20000, 20001)))[1]
    width = 1e-5
    while width > 1e-13:
        best = min((worst(s), s) for s in (best - width, best - width / 2, best, best + width / 2, best + width))[1]
        width /= 2
    return worst(best)


def _value(data, names):
    if isinstance(data, str):
        return eval(data, {"__builtins__": {}}, names)  # Of our own files.
    if isinstance(data, list):
        return [_value(item, names) for item in data]
    if isinstance(data, dict):
        return {key: _value(item, names) for key, item in data.items()}
    return data


def world(name, ratio=None, **changes):
    """The world of a file with other parameters. With a ratio its friction is so many times the critical one; what is a
    part of every world (step, duration, setting, damping, and so on) may be changed, too."""
    data = json.loads((FOLDER / f"{name}.json").read_text())
    functions = {key: getattr(math, key) for key in ("sin", "cos", "tan", "atan", "sqrt", "radians")}
    names = {"g": GRAVITY, "lean_in_slot": lean_in_slot, "least_friction": least_friction, **functions, **data["parameters"]}
    common = {key: changes.pop(key) for key in list(changes) if key in COMMON or key == "shape"}
    unknown = set(changes) - set(data["parameters"])
    if unknown:
        raise KeyError(f"{name}.json has no parameter {', '.join(sorted(unknown))}")
    names.update(changes)
    for key, formula in data.get("derived", {}).items():
        names[key] = _value(formula, names)
    made = {**COMMON, **{key: _value(item, names) for key, item in data.items() if key not in ("about", "parameters", "derived")}}
    made.update(mass=names["mass"], friction=names["friction"] if ratio is None else ratio * made["critical"], name=name)
    made.update(common)
    for load in made["loads"]:
        load.setdefault("moment", [0, 0, 0])
        load.setdefault("times", [0])
        load.setdefault("factors", [1])
    return made
