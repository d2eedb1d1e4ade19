# SPDX-License-Identifier: Apache-2.0
"""The truth bench as a part of the report: tables of rows that truth.py measured, and speed against accuracy."""

import math

import engines
import tasks

NONE = "-"


def number(value):
    """As few digits as a reader compares."""
    if value == 0:
        return "0"
    if abs(value) < 1e-2 or abs(value) >= 1e4:
        mantissa, exponent = f"{value:.0e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def cell(row):
    """What a row's task found, in words or a number."""
    if row is None:
        return NONE
    values = row["values"]
    if "error" in values:
        return "refused"
    if values.get("lost_s") is not None:
        return f"lost {values['lost_s']:.2g} s"
    if "um_per_s" in values:
        return number(values["um_per_s"])
    if "error_percent" in values:
        if values["error_percent"] is None:
            return "never holds"
        return ("below " if values.get("at_least") else "") + f"{values['error_percent']:+.1f}".replace("+0.0", "0").replace("-0.0", "0")
    if "held" in values:
        return "held" if values["held"] else "slips"
    if "steps" in values:
        return NONE if values["steps"] is None else str(values["steps"])
    return NONE


def name_of(row):
    mark = ", WebAssembly" if engines.PEERS[row["engine"]].get("wasm") else ""
    return row["engine"] + mark + (" (stored)" if row.get("stored") else "")


def settings_of(row):
    setting = engines.PEERS[row["engine"]]["settings"][row["setting"]]
    return len(setting.get("sets", {})) + setting.get("needs", 0)


def label(case, shared):
    """What tells a case from the others of its table."""
    units = {"margin": "M {}", "direction": "{} deg", "step": "{} ms", "ratio": "{}"}
    words = []
    for key, value in case.items():
        if key in shared:
            continue
        if key == "step" and value != "own":
            value = f"{1e3 * value:g}"
        words.append(value if key == "world" or value == "own" else units[key].format(value))
    return " ".join(words)


class Rows:
    """All rows by task, engine, setting and case."""

    def __init__(self, rows):
        self.rows = rows
        self._by = {(r["task"], r["engine"], r["setting"], repr(sorted(r["case"].items()))): r for r in rows}
        self.kinds = list(dict.fromkeys((r["engine"], r["setting"]) for r in sorted(rows, key=lambda r: list(engines.PEERS).index(r["engine"]))))

    def get(self, task, kind, case):
        return self._by.get((task, *kind, repr(sorted(case.items()))))

    def of_kind(self, kind):
        return next(r for r in self.rows if (r["engine"], r["setting"]) == kind)


def figure(kind, task, title, caption, **more):
    return {"kind": kind, "id": f"truth_{task}", "title": title, "caption": caption, "runs": "", **more}


def less_time(task):
    """Which engines are given less time for a task, in words."""
    given = [f"{name} {peer['creep_s']} s" for name, peer in engines.PEERS.items() if peer.get("creep_s", math.inf) < task["changes"]["duration"]]
    return f" As they are slow, less time: {', '.join(given)}." if given and task["measure"] == "creep" else ""


def case_table(rows, task, cases, title, shared=()):
    """A row an engine's setting, a column a case."""
    kinds = [kind for kind in rows.kinds if any(rows.get(task["name"], kind, case) for case in cases)]
    made = []
    for kind in kinds:
        first = rows.of_kind(kind)
        made.append([name_of(first), kind[1], settings_of(first), *(cell(rows.get(task["name"], kind, case)) for case in cases)])
    return figure("table", title.lower().replace(" ", "_").replace(",", ""), title, task["about"] + less_time(task),
                  columns=["engine", "setting", "settings", *(label(case, shared) for case in cases)], rows=made)


def hold_tables(rows, task):
    worlds = list(dict.fromkeys(case["world"] for case in task["cases"]))
    return [case_table(rows, task, [c for c in task["cases"] if c["world"] == world], f"Hold creep, {world}", ("world",)) for world in worlds]


def values_table(rows, task, columns):
    """A row an engine's setting; columns of {title: value}."""
    case, made = task["cases"][0], []
    for kind in rows.kinds:
        row = rows.get(task["name"], kind, case)
        if row is None:
            continue
        values = row["values"]
        lost = f"lost {values['lost_s']:.2g} s" if values.get("lost_s") is not None else None
        shown = [lost or (NONE if values.get(key) is None else number(values[key])) for key in columns.values()]
        made.append([name_of(row), kind[1], settings_of(row), *shown])
    return figure("table", task["name"], task["title"], task["about"], columns=["engine", "setting", "settings", *columns], rows=made)


def factor_table(rows, task, slopes):
    """MotrixSim's factors, with the published verdicts, and how many cells of Newton's grid are wrong."""
    made = case_table(rows, task, task["cases"], task["title"], ("world",))
    made["columns"].append("wrong cells of the grid")
    for line, kind in zip(made["rows"], [k for k in rows.kinds if rows.get(task["name"], k, task["cases"][0])]):
        line.append(wrong_cells(rows, slopes, kind))
    for name, verdicts in task["published"].items():
        made["rows"].append([f"{name} (published)", "", "", *("held" if held else "slips" for held in verdicts), NONE])
    made["caption"] += " The last column: " + slopes["about"]
    return made


def wrong_cells(rows, task, kind):
    wrong = cells = 0
    for case in task["cases"]:
        row = rows.get(task["name"], kind, case)
        margin = case["friction"] / tasks.slope_of(case)
        if row is None or "held" not in row["values"] or abs(margin - 1) < 0.01:
            continue
        cells += 1
        wrong += row["values"]["held"] != (margin > 1)
    return f"{wrong} of {cells}" if cells else NONE


def speed_figure(rows, task, other, case, value, title, error, floor):
    """Time of a step against an error of another task; programs of WebAssembly are no part of it."""
    points = []
    for kind in rows.kinds:
        timed, judged = rows.get(task["name"], kind, task["cases"][0]), rows.get(other, kind, case)
        if engines.PEERS[kind[0]].get("wasm") or timed is None or "us" not in timed["values"] or timed.get("stored"):
            continue
        found = (judged or {"values": {}})["values"].get(value)
        if found is None:
            continue
        ours = engines.PEERS[kind[0]].get("ours", False)
        points.append({"method": f"{kind[0]}" if not ours else kind[1], "setting": "" if ours else kind[1],
                       "error": max(abs(found), floor), "us": timed["values"]["us"], "us_p99": None,
                       "default": ours and kind[1] == "rigid tips", "peer": not ours, "published": False})
    return figure("work_precision", f"speed_{other}", title, f"{task['about']} {error} of the held box.", error=error,
                  time="us a step", choice="engine", cases=[{"name": "box, margin 1.5", "points": points}])


def part(rows, measured):
    """The part of the report that rows of all tasks make."""
    rows, of = Rows(rows), {name: tasks.task(name) for name in tasks.names()}
    box = {"world": "box", "direction": 45}
    figures = [
        *hold_tables(rows, of["hold"]),
        case_table(rows, of["critical_friction"], of["critical_friction"]["cases"], of["critical_friction"]["title"]),
        factor_table(rows, of["factors"], of["slopes"]),
        values_table(rows, of["energy"], {"at rest, W": "rest_W", "after the push, J": "pushed_J"}),
        case_table(rows, of["halved_steps"], of["halved_steps"]["cases"], of["halved_steps"]["title"], ("world", "margin")),
        values_table(rows, of["reversals"], {"travel, nm": "travel_nm", "open after the last, nm": "open_nm", "walked in 99, nm": "walk_nm"}),
        case_table(rows, of["answer"], of["answer"]["cases"], of["answer"]["title"], ("world", "margin")),
        values_table(rows, of["speed"], {"us": "us"}),
        speed_figure(rows, of["speed"], "hold", {"world": "box", "margin": 1.5}, "um_per_s", "Speed against hold creep", "creep, um/s", 1e-9),
        speed_figure(rows, of["speed"], "critical_friction", box, "error_percent", "Speed against friction across two axes", "error of friction at 45 deg, %", 0.05),
    ]
    text = ("Bodies that are held by friction, with answers that mechanics knows, given to Thenar and to what others would take "
            "instead: each engine at its defaults and at its manual's advice, with the number of settings and further lines that "
            "a user has to know of. What is measured is the object's motion, by one definition for all. Peers are shown, never "
            "judged; where one is better, it stands here.")
    return {"part": "truth", "title": "Truth beside other engines", "text": text, "measured": measured, "figures": figures}
