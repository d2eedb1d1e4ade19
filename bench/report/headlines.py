# SPDX-License-Identifier: Apache-2.0
"""The report in a few lines, from the figures that have them: a line whose figure is missing is left out."""

import re

import analysis
from analysis import number

# Of the parts of growth: the figure, its curve, and what grows over what.
GROWTH = (
    ("growth_computation", "in all", "the contact computation over contacts"),
    ("samples", "find, a grip that creeps", "contact finding over the object's samples"),
    ("samples_memory", "surface", "memory over the object's samples"),
    ("controls", "find, a grip that creeps", "contact finding over control points"),
    ("growth_contact_time", "Gauss-Seidel, W in factors", "the contact solve over contacts and fingers"),
)


def headlines(parts):
    return [line for make in (_contact_computation, _defaults, _nearest_edge, _stiffness, _model, _growth) if (line := make(parts))]


def _figures(parts, part, kind):
    return [figure for p in parts if p["part"] == part for figure in p["figures"] if figure["kind"] == kind]


def _rows(parts, part, **columns):
    """The rows of the first table of a part that has all these columns, found by words of their names: {key: cell}."""
    for table in _figures(parts, part, "table"):
        names = [str(name).lower() for name in table["columns"]]
        found = {key: next((i for i, name in enumerate(names) if any(word in name for word in words)), None)
                 for key, words in columns.items()}
        if None not in found.values():
            return [{key: row[i] for key, i in found.items()} for row in table["rows"]]
    return []


def published_table(parts):
    """The table of published times, row by row; where there is no published time, the cell is no number."""
    return _rows(parts, "published", name=("computation",), published=("published",), here=("median",), p99=("p99",),
                 accuracy=("accuracy",))


def _published_rows(parts):
    rows = _rows(parts, "published", name=("computation",), published=("published",), here=("median",),
                 ratio=("times as fast",), rest=("hardware",), accuracy=("accuracy",))
    return [row for row in rows if _is_number(row["published"]) and _is_number(row["here"])]


def _is_number(value):
    return isinstance(value, (int, float))


def _told(value):
    return number(value) if _is_number(value) else str(value)


def _time(us):
    return f"{number(us / 1e3)} ms" if us >= 1e3 else f"{number(us)} µs"


def published(parts):
    """The published timings beside ours, a line each."""
    return [f"{row['name']}: {_time(row['here'])} for {_time(row['published'])}, {_told(row['ratio'])} times as fast "
            f"({_told(row['rest'])} without the hardware's share); {_told(row['accuracy'])}"
            for row in _published_rows(parts)]


def _contact_computation(parts):
    rows = [row for row in _published_rows(parts) if "contact computation" in row["name"]]
    if not rows:
        return ""
    row = max(rows, key=lambda row: row["published"])
    forces = re.search(r"Hertz (\S+ %), solver ([^\s;]+)", str(row["accuracy"]))
    right = f"forces {forces.group(1)} off Hertz, solved to {forces.group(2)}" if forces else _told(row["accuracy"])
    return f"{row['name'].capitalize()}: {_time(row['here'])} (published {_time(row['published'])}), {right}."


def _defaults(parts):
    ratios = [ratio for figures in analysis.choices(parts).values() for figure in figures
              for _, _, ratio, _ in analysis.default_ratios(figure)]
    near = sum(ratio <= analysis.NEAR for ratio in ratios)
    return f"Defaults on their front, or within 10 % of it: {near} of {len(ratios)} (choice, scene)." if ratios else ""


def _nearest_edge(parts):
    rows = _rows(parts, "stability", setting=("setting",), way=("way",), ratio=("ratio",), end=("what becomes",))
    edges = []
    for row in rows:
        # What the scene file refuses, and what held as far as it was tried, is no edge.
        if re.match("slipping|unstable|off target|solver failed", str(row["end"])):
            edges.append((float(row["ratio"]), row))
    if not edges:
        return ""
    ratio, row = min(edges, key=lambda edge: edge[0])
    return (f"Nearest edge of the reference scene: {row['setting']} may go {row['way']} {number(ratio)} times, no "
            f"further ({analysis.first_clause(row['end'])}).")


def _stiffness(parts):
    rows = _rows(parts, "stiffness", grasp=("grasp",), alike=("their effort, times the least",),
                 stiffness=("off the stiffness",), effort=("off its least effort",))
    rows = [row for row in rows if all(_is_number(row[key]) for key in ("alike", "stiffness", "effort"))]
    if not rows:
        return ""
    most = {key: number(max(row[key] for row in rows)) for key in ("alike", "stiffness", "effort")}
    return (f"A stiffness that is chosen: runs of {len(rows)} grasps have it within {most['stiffness']} %, at an "
            f"effort within {most['effort']} % of the least; all muscles raised alike take up to {most['alike']} times "
            "as much.")


def _model(parts):
    rows = _rows(parts, "model", scene=("scene",), out=("left out",), ratio=("times as fast",))
    ratios = [float(row["ratio"]) for row in rows]
    if not ratios:
        return ""
    return (f"`model: auto` makes {len(ratios)} scenes {number(min(ratios))} to {number(max(ratios))} times as fast, "
            "within their tolerance.")


def _growth(parts):
    powers = {}
    for figure in _figures(parts, "growth", "curves") + _figures(parts, "contact_growth", "curves"):
        for curve in (curve for panel in figure["panels"] for curve in panel["curves"]):
            if curve.get("exponent") is not None:
                powers.setdefault((figure["id"], curve["name"]), []).append(f"n^{curve['exponent']:.2f}")
    told = []
    for figure, name, words in GROWTH:
        if found := sorted(set(powers.get((figure, name), []))):
            told.append(f"{words} {' to '.join(dict.fromkeys((found[0], found[-1])))}")
    return f"Growth: {'; '.join(told)}." if told else ""


def unanswered(parts):
    """Of fresh contact problems: what each solver had no answer to, a line a solver."""
    solvers = {}
    for row in _rows(parts, "contact_families", family=("family",), solver=("solver",), solved=("said solved",),
                     none=("said none",), unanswered=("no answer",)):
        solvers.setdefault(row["solver"], []).append(row)
    lines = []
    for solver, rows in solvers.items():
        worst = sorted((row for row in rows if row["unanswered"]), key=lambda row: -row["unanswered"])[:3]
        of = sum(row["solved"] + row["none"] + row["unanswered"] for row in rows)
        where = ", ".join(f"{row['family']} {row['unanswered']}" for row in worst)
        lines.append(f"{solver}: {sum(row['unanswered'] for row in rows)} of {of}" + (f" ({where})" if where else ""))
    return lines
