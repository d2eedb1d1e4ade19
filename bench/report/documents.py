# SPDX-License-Identifier: Apache-2.0
"""The report's tables as Markdown: docs/measured.md, and the table of the README between its markers."""

import datetime
import re

import analysis
import headlines

BEGIN, END = "<!-- measured:begin -->", "<!-- measured:end -->"


def write(root, parts, dates):
    """Writes docs/measured.md, and the README's table anew; `dates` are the first and the last of the measurements."""
    readme = root / "README.md"
    new = with_table(readme.read_text(encoding="utf-8"), readme_table(parts, dates), readme)
    (root / "docs" / "measured.md").write_text(measured(parts, dates), encoding="utf-8")
    readme.write_text(new, encoding="utf-8")


def with_table(text, table, file="README.md"):
    """The text with another table between the markers, which stand alone in their lines, once and in order."""
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise analysis.ReportError(f"{file}: needs the lines '{BEGIN}' and '{END}', once each")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n{table}\n{END}{rest.split(END)[1]}"


def dates_of(folder, parts):
    """When the first and the last of the parts was measured: the dates of their files."""
    days = sorted(datetime.date.fromtimestamp((folder / f"{part['part']}.json").stat().st_mtime) for part in parts)
    return days[0], days[-1]


def readme_table(parts, dates):
    """The published times beside ours, and what they were measured on."""
    rows = [row for row in headlines.published_table(parts)
            if "cones active" not in row["name"] and "active set, pyramids" not in row["name"]]
    if not rows:
        raise analysis.ReportError("no table of published times: the README keeps its table; `./dev bench published` measures it")
    lines = [[row["name"], *(_time(row[key]) for key in ("published", "here", "p99")), row["accuracy"]] for row in rows]
    machine = {**next(part for part in parts if part["part"] == "published")["measured"], "peers": ""}
    return (table(["computation", "published", "here, median", "here, p99", "accuracy here"], lines)
            + f"\n\nMeasured on {_measured_on(machine)}, {_days(dates)}. [All tables](docs/measured.md).")


def measured(parts, dates):
    """All headlines and tables of the report: the same parts and dates give the same text."""
    blocks = ["# Measured", "`./dev bench --docs` writes this page from the results in `out/bench`: do not edit it. "
              "[The guide](guide/measure.md) says how to measure, and how to read the report, which has the pictures."]
    if lines := headlines.headlines(parts) + headlines.unanswered(parts):
        blocks.append("\n".join(f"- {text(line)}" for line in lines))
    blocks += ["## The machine", _machines(parts, dates)]
    if rows := _default_rows(parts):
        blocks += ["## The defaults", "A default is on the front if no other method or setting of ours is as accurate "
                   "and more than 10 % faster.", table(["choice", "scenes", "where not"], rows)]
    for title, groups, missing in analysis.sections(parts):
        figures = [block for _, figures in groups for figure in figures for block in _figure(figure)]
        if missing:
            figures.insert(0, f"Not measured: {', '.join(f'`{name}`' for name in missing)}.")
        if figures:
            blocks += [f"## {title}", *figures]
    return "\n\n".join(blocks) + "\n"


def _figure(figure):
    make = {"table": _plain, "work_precision": _work_precision, "map": _map, "curves": _growth}[figure["kind"]]
    made = make(figure)
    runs = f" Runs: {figure['runs']}." if figure["runs"] else ""
    return [f"### {text(figure['title'])}", made, text(figure["caption"] + runs)] if made else []


def _plain(figure):
    return table(figure["columns"], figure["rows"])


def _work_precision(figure):
    """Of each case the default, and of every other method the fastest setting that is as accurate, or the most accurate."""
    rows = []
    for case in figure["cases"]:
        points = analysis.solved(case["points"])
        default = next((p for p in points if p.get("default")), None)
        chosen = {default["method"]: default} if default else {}
        for method in dict.fromkeys(p["method"] for p in points):
            chosen.setdefault(method, _fastest([p for p in points if p["method"] == method], default))
        for p in chosen.values():
            marks = [word for key, word in (("default", "default"), ("peer", "not part of Thenar"), ("published", "published"))
                     if p.get(key)]
            rows.append([case["name"], " ".join(filter(None, (p["method"], p["setting"]))), p["error"], p["us"],
                         p.get("us_p99"), ", ".join(marks)])
    return table(["case", "method", figure["error"], figure["time"], "p99", ""], rows) if rows else ""


def _fastest(points, default):
    as_accurate = [p for p in points if default and p["error"] <= max(default["error"], analysis.ROUNDING)]
    return min(as_accurate or points, key=lambda p: (p["us"],) if as_accurate else (p["error"], p["us"]))


def _map(figure):
    rows = []
    for panel in figure["panels"]:
        failures = analysis.failures(panel)
        cells = sum(len(row) for row in panel["cells"])
        why = "; ".join(f"{count} {outcome}" for outcome, count, _ in failures)
        rows.append([panel["name"], f"{cells - sum(count for _, count, _ in failures)} of {cells}", why])
    return table(["", "held", "the others"], rows)


def _growth(figure):
    rows = [[panel["name"], curve["name"], f"n^{curve['exponent']:.2f}"] for panel in figure["panels"]
            for curve in panel["curves"] if curve.get("exponent") is not None]
    return table(["", "", "grows with"], rows) if rows else ""


def _default_rows(parts):
    rows = []
    for choice, figures in analysis.choices(parts).items():
        ratios = [ratio for figure in figures for ratio in analysis.default_ratios(figure)]
        worse = "; ".join(f"{case}: {ratio:.2f} times the time of {best['method']}" for case, _, ratio, best in ratios
                          if ratio > analysis.NEAR)
        rows.append([choice, analysis.verdict(ratios)[1], worse])
    return rows


def _machines(parts, dates):
    groups = {}
    for part in parts:
        groups.setdefault(_measured_on(part["measured"]), []).append(part["part"])
    lines = [f"- {', '.join(names) if len(groups) > 1 else 'All parts'}: {machine}, {_days(dates)}."
             for machine, names in groups.items()]
    return "\n".join(lines)


def _measured_on(m):
    peers = str(m.get("peers") or "").strip(", ")
    said = (m.get("machine"), f"{m['threads']} hardware threads" if "threads" in m else "", m.get("compiler"),
            f"`{m['flags']}`" if m.get("flags") else "", " ".join(filter(None, ("Thenar", m.get("version"), m.get("source")))),
            f"measured with {peers}" if peers else "", "a quick measurement" if m.get("quick") else "")
    return ", ".join(filter(None, said))


def _days(dates):
    return " to ".join(dict.fromkeys(day.isoformat() for day in dates))


def _time(us):
    if not isinstance(us, (int, float)):
        return ""
    return f"{analysis.number(us / 1e3)} ms" if us >= 1e3 else f"{analysis.number(us)} µs"


def table(columns, rows):
    """A table; a column of numbers is set to the right."""
    def is_number(value):
        return value is None or isinstance(value, (int, float))

    right = [bool(rows) and all(is_number(row[i]) for row in rows) for i in range(len(columns))]
    lines = [columns, ["---:" if r else "---" for r in right],
             *([analysis.number(v) if is_number(v) else text(v) for v in row] for row in rows)]
    lines[0] = [text(column) for column in columns]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def text(value):
    """Plain text of a part, for Markdown: outside of `code` nothing in it is markup, and nothing ends a table's cell."""
    pieces = re.split(r"(`[^`]+`)", " ".join(str(value).split()))
    return "".join(piece.replace("|", "\\|") if piece.startswith("`") and len(piece) > 1
                   else re.sub(r"([\\*<>|`]|(?<!\w)_|_(?!\w)|(?<=\])\()", r"\\\1", piece) for piece in pieces)
