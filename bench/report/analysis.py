# SPDX-License-Identifier: Apache-2.0
"""What the report is made of and what it concludes: nothing here draws. figure.h has the format of a part."""

import itertools
import json
import re
from collections import Counter
from pathlib import Path

# The sections of the report, in order, and the parts that each has. Figures whose id begins with growth_ go to Growth.
SECTIONS = (
    ("The published timings", ("published", "limits")),
    ("Truth beside other engines", ("truth",)),
    ("Speed against accuracy", ("grasp_force", "muscle", "contact", "finding", "pulp", "rate")),
    ("Sticking, sliding, converging", ("motion", "curved_surface", "edges")),
    ("Where methods fail", ("stability", "contact_families")),
    ("Touch and reflex", ("partial_slip", "reflex", "felt_margin", "pose_loop")),
    ("Stiffness that is chosen", ("stiffness", "untuned_stiffness")),
    ("Tasks, and a peg in a hole", ("task", "insertion")),
    ("No more than a scene needs", ("model",)),
    ("Grasps that are found", ("grasp_finding",)),
    ("Around the object", ("environment",)),
    ("Growth", ("growth", "contact_growth", "compression")),
)
GOOD = ("held", "task done", "free", "two points")
OUTCOMES = (*GOOD, "over limits", "off target", "slipping", "resting", "outside", "jammed", "wedged", "task failed",
            "unstable", "lost",
            "solver failed", "refused")
NEAR = 1.10  # On the front, as far as clocks can tell.
ENOUGH_SCENES = 3  # On which a default should be.
SAME_ERROR = 1.0000001
ROUNDING = 1e-12  # Errors below it are all alike.

_PART_KEYS = ("part", "title", "text", "measured", "figures")
_FIGURE_KEYS = ("kind", "id", "title", "caption", "runs")
_KIND_KEYS = {
    "work_precision": ("error", "time", "cases"),
    "map": ("x", "y", "panels"),
    "curves": ("x", "y", "panels"),
    "table": ("columns", "rows"),
}


class ReportError(Exception):
    """A file that the report cannot be made of; says which, where and why."""


def read_parts(folder):
    """The parts among the JSON files of a folder, by file name; other JSON, as Google Benchmark's, is passed over."""
    parts = []
    for file in sorted(Path(folder).glob("*.json")):
        try:
            part = json.loads(file.read_text(encoding="utf-8"))
        except (ValueError, OSError) as error:
            raise ReportError(f"{file}: {error}") from error
        if isinstance(part, dict) and "part" in part:
            _check_part(part, file)
            parts.append(part)
    if not parts:
        raise ReportError(f"{folder}: has no part of the report")
    return parts


def _check_part(part, file):
    def require(value, keys, where):
        for key in keys:
            if key not in value:
                raise ReportError(f"{file}: {where}: lacks '{key}'")

    require(part, _PART_KEYS, "the part")
    for figure in part["figures"]:
        require(figure, _FIGURE_KEYS, f"figure '{figure.get('id', '?')}'")
        if figure["kind"] not in _KIND_KEYS:
            raise ReportError(f"{file}: figure '{figure['id']}': no kind is named '{figure['kind']}'")
        require(figure, _KIND_KEYS[figure["kind"]], f"figure '{figure['id']}'")


def sections(parts):
    """[(title, [(part, figures)], [names of missing parts])]; what no section names is in one more at the end."""
    by_name = {part["part"]: part for part in parts}
    title_of = {name: title for title, names in SECTIONS for name in names}

    def title(part, figure):
        return "Growth" if figure["id"].startswith("growth_") else title_of.get(part["part"], "Others")

    result = []
    for name, names in (*SECTIONS, ("Others", ())):
        in_order = [by_name[n] for n in names if n in by_name] + [part for part in parts if part["part"] not in names]
        groups = [(part, [figure for figure in part["figures"] if title(part, figure) == name]) for part in in_order]
        result.append((name, [group for group in groups if group[1]], [n for n in names if n not in by_name]))
    return result if result[-1][1] else result[:-1]


def solved(points):
    """The points that have an error and a time: what no number was found for is no candidate for anything."""
    return [p for p in points if p["error"] is not None and p["us"] is not None]


def _error(point):
    return max(point["error"], ROUNDING)


def front(points):
    """The points than which no other is both as fast and as accurate, and better in one of them; by time."""
    result = []
    for point in sorted(solved(points), key=lambda p: (p["us"], _error(p))):
        if not result or _error(point) < _error(result[-1]):
            result.append(point)
    return result


def ratio_to_front(point, points):
    """The time of a point over the least among the points that are as accurate: 1 is on the front. And that point."""
    as_accurate = [p for p in solved(points) if _error(p) <= SAME_ERROR * _error(point)] + [point]
    best = min(as_accurate, key=lambda p: p["us"])
    return (point["us"] / best["us"] if best["us"] > 0 else 1.0), best


def default_ratios(figure):
    """[(case, default point, ratio, best point)] of a work-precision figure, where a case has a default with a number.
    It is held against ours that are free to be chosen: neither other projects' nor kept for the published model."""
    result = []
    for case in figure["cases"]:
        ours = [p for p in case["points"] if not p.get("peer") and not p.get("published")]
        for point in solved(case["points"]):
            if point.get("default"):
                result.append((case["name"], point, *ratio_to_front(point, ours)))
    return result


def verdict(ratios):
    """What default_ratios say of a default: "few" scenes to judge by, "good" or "bad"; and in words."""
    near = sum(ratio <= NEAR for _, _, ratio, _ in ratios)
    if len(ratios) < ENOUGH_SCENES:
        return "few", f"fewer than three scenes: on {near} of {len(ratios)}"
    return "good" if near >= ENOUGH_SCENES else "bad", f"on {near} of {len(ratios)} scenes"


def choices(parts):
    """{choice: its work-precision figures}; a figure without a choice shows none."""
    result = {}
    for part in parts:
        for figure in part["figures"]:
            if figure["kind"] == "work_precision" and figure.get("choice"):
                result.setdefault(figure["choice"], []).append(figure)
    return result


def not_needed(figures):
    """The methods of a choice that ours could do without: to be deleted. Needed is what is within 10 % of our front in
    three cases or more, or what has a point in some case that no other comes within 10 % of, in time and in error.
    What is not part of Thenar, and what is of the published model, is not asked."""
    near, methods, needed = Counter(), {}, set()
    for case in (case for figure in figures for case in figure["cases"]):
        ours = [p for p in case["points"] if not p.get("peer")]
        methods.update((p["method"], True) for p in ours)
        needed |= {p["method"] for p in ours if p.get("published") or not _others_serve(p, solved(ours))}
        near.update({p["method"] for p in solved(ours) if ratio_to_front(p, ours)[0] <= NEAR})
    return [method for method in methods if method not in needed and near[method] < ENOUGH_SCENES]


def _others_serve(point, points):
    if not solved([point]):
        return True
    return any(p["us"] <= NEAR * point["us"] and _error(p) <= NEAR * _error(point)
               for p in points if p["method"] != point["method"])


def outcome_counts(panel):
    counts = Counter(cell["outcome"] for row in panel["cells"] for cell in row)
    others = sorted(set(counts) - set(OUTCOMES))
    return {outcome: counts[outcome] for outcome in (*OUTCOMES, *others) if counts[outcome]}


def first_clause(reason):
    return re.split("[;,] ", reason)[0]


def failures(panel):
    """[(outcome, count, a typical reason)] of the cells that are not good, the most frequent first. Reasons count as
    one whose first clause differs in its numbers alone. A cell that fails without a reason has an empty one."""
    groups = {}
    for row in panel["cells"]:
        for cell in row:
            if cell["outcome"] not in GOOD:
                reason = cell.get("reason") or ""
                clause = re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", first_clause(reason))
                groups.setdefault((cell["outcome"], clause), []).append(reason)
    ranked = sorted(groups.items(), key=lambda group: -len(group[1]))
    return [(outcome, len(reasons), reasons[len(reasons) // 2]) for (outcome, _), reasons in ranked]


def scenes(folder):
    """[(name, what it is)] of the scene files: the first sentence of the comment that each begins with."""
    result = []
    for file in sorted(Path(folder).glob("*.yaml")):
        lines = itertools.takewhile(lambda line: line.startswith("#"), file.read_text(encoding="utf-8").splitlines())
        lines = [line for line in lines if not line.startswith("# yaml-language-server")]
        sentence = re.match(r".*?\.(?= |$)", " ".join(line.lstrip("# ") for line in lines))
        if sentence and file.stem != "hand":
            result.append((file.stem, sentence.group()))
    return result


def trials(folder):
    """{"faults": ..., "soak": ...} of what `./dev faults` and `./dev soak` left in folders beside this one."""
    files = {name: Path(folder).parent / name / f"{name}.json" for name in ("faults", "soak")}
    return {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items() if file.exists()}


def maps(parts):
    return [figure for part in parts for figure in part["figures"] if figure["kind"] == "map"]


def number(value, digits=3):
    """A number as a reader wants it: three digits, no more; a dash where there is none."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f") if abs(value) >= 10000 else str(value)
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if -4 < int(exponent) < 5:
        return f"{float(f'{value:.{digits - 1}e}'):.10g}"
    return f"{float(mantissa):g}e{int(exponent)}"
