# SPDX-License-Identifier: Apache-2.0
"""The report as one page of HTML: nothing in it comes from elsewhere, and it needs no script."""

import re
from html import escape

import analysis
import drawing
import headlines

STYLE = """
:root { --ink: #1c1c1c; --soft: #5a5a5a; --line: #d8d8d8; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.2rem; max-width: 76rem; color: var(--ink); background: white;
       font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; overflow-wrap: break-word; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0.5rem 0; }
h2 { font-size: 1.5rem; border-bottom: 2px solid var(--ink); margin: 3rem 0 1rem; }
h3 { font-size: 1.2rem; margin: 2.2rem 0 0.3rem; }
h4 { font-size: 1rem; margin: 0 0 0.5rem; }
p, ul { max-width: 52rem; margin: 0.5rem 0; }
a { color: #1f4f8a; }
nav ol { columns: 2; padding-left: 1.3rem; margin: 0.5rem 0; font-size: 0.9rem; }
nav .figure { break-inside: avoid; }
nav ol ol { columns: 1; }
nav .figure { list-style: none; }
figure { margin: 1.8rem 0 2.6rem; }
.panels { display: grid; grid-template-columns: repeat(auto-fill, minmax(19rem, 1fr)); gap: 0.6rem 1rem; }
.panel { break-inside: avoid; }
.panel svg { width: 100%; max-width: 30rem; height: auto; display: block; }
svg * { stroke-linejoin: round; stroke-linecap: butt; }
.legend { display: flex; flex-wrap: wrap; gap: 0.15rem 1.1rem; margin: 0.5rem 0; max-width: none; font-size: 0.85rem; }
.legend > span { display: inline-flex; align-items: center; gap: 0.35rem; }
.legend svg { width: 2.1rem; height: 1rem; flex: none; }
figcaption { max-width: 52rem; margin-top: 0.5rem; }
.runs, .soft { color: var(--soft); font-size: 0.88rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.88rem; margin: 0.5rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: 0.2rem 0.7rem 0.2rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
th { border-bottom-color: var(--ink); vertical-align: bottom; }
td.n, th.n { text-align: right; }
td.n, .nobr { white-space: nowrap; }
td.long { min-width: 15rem; }
code { font-size: 0.92em; background: #f3f3f3; padding: 0 0.15em; }
details { margin: 0.5rem 0; } sup { line-height: 0; }
summary { cursor: pointer; color: var(--soft); font-size: 0.88rem; }
.missing { border-left: 4px solid #c0392b; padding-left: 0.7rem; }
.good, td code { white-space: nowrap; }
.good::before { content: "\\2713\\00a0"; } .bad { font-weight: bold; } .bad::before { content: "\\2717\\00a0"; }
@media (max-width: 40rem) { body { padding: 0.8rem; } nav ol { columns: 1; } .panels { grid-template-columns: 1fr; }
  .scroll table { width: max-content; max-width: 46rem; } }
@page { size: A4; margin: 13mm; }
@media print {
  body { font-size: 8.6pt; line-height: 1.4; padding: 0; max-width: none; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h1 { font-size: 20pt; } h2 { font-size: 15pt; margin-top: 1.6rem; } h3 { font-size: 12pt; }
  h2, h3, h4, p:has(+ ul) { break-after: avoid; }
  p, figcaption, ul { max-width: none; orphans: 3; widows: 3; }
  a { color: inherit; text-decoration: none; }
  figure { margin: 0.8rem 0 1rem; break-inside: avoid; } figure.long { break-inside: auto; }
  .intro { break-inside: avoid; break-after: avoid; }
  .legend, .runs { font-size: 7.8pt; } p, .legend { margin: 1.2mm 0; }
  .panels, .panels.one { grid-template-columns: 38% 38%; gap: 2mm 4mm; }
  .panels.many { grid-template-columns: 1fr 1fr 1fr; gap: 1mm 3mm; }
  table { font-size: 7.6pt; } td.long { min-width: 38mm; } tr { break-inside: avoid; } th, td { padding-right: 0.4rem; }
  .scroll { overflow: visible; }
  figcaption { break-before: avoid; } details { display: none; }
}
"""


def text(value):
    """Plain text of a part, for a page: `so` is code, n^2 a power; an exponent or per cent stays with its number."""
    marked = re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(str(value)))
    marked = re.sub(r"\b([a-zA-Z]|10|2)\^(-?\d*\.?\w+)", r"\1<sup>\2</sup>", marked)
    return re.sub(r"\d[\d.]*(e-\d+| %)", r'<span class="nobr">\g<0></span>', marked)


def named(point):
    return text(" ".join(filter(None, (point["method"], point["setting"]))))


def table(columns, rows, html=False):
    """A table; a column of numbers is set to the right. With `html`, texts are taken as they are."""
    show = (lambda v: v) if html else text

    def is_number(value):
        return isinstance(value, (int, float)) or value is None

    def looks_like_one(value):
        return is_number(value) or re.fullmatch(r"-?[\d.]+(e-?\d+)?|[-–]?", value)

    right = [any(v != "" for v in column) and all(looks_like_one(v) for v in column)
             for column in ([row[i] for row in rows] for i in range(len(columns)))]
    def cells(tag, row):
        kinds = [' class="n"' if right[i] else ' class="long"' if len(re.sub("<[^>]*>", "", str(v))) > 40 else ""
                 for i, v in enumerate(row)]
        shown = [analysis.number(v) if is_number(v) else show(v) for v in row]
        return "".join(f"<{tag}{kind}>{v}</{tag}>" for kind, v in zip(kinds, shown))

    body = "\n".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return (f'<div class="scroll"><table>\n<thead><tr>{cells("th", columns)}</tr></thead>\n'
            f"<tbody>\n{body}\n</tbody></table></div>")


def details(title, content):
    return f"<details><summary>{text(title)}</summary>\n{content}\n</details>"


def panels(svgs, below=None):
    size = " one" if len(svgs) == 1 else " many" if len(svgs) > 2 else ""
    below = below or [""] * len(svgs)
    cells = "\n".join(f'<div class="panel">{svg}{note}</div>' for svg, note in zip(svgs, below))
    return f'<div class="panels{size}">\n{cells}\n</div>'


def legend(entries):
    items = "\n".join(f"<span>{svg}<span>{text(name)}</span></span>" for svg, name in entries)
    return f'<p class="legend">{items}</p>'


def peers_entry(page):
    return page.swatch(color="#777777", dash=drawing.DASHED), "grey and dashed: not part of Thenar"


def work_precision(page, figure):
    svgs, look = drawing.work_precision(page, figure)
    points = [p for case in figure["cases"] for p in case["points"]]
    filled = {p["method"] for p in points if not p.get("published")}
    entries = [(page.swatch(**style, hollow=name not in filled), name)
               for name, style in look.items()]
    if any(p.get("peer") for p in points):
        entries.append(peers_entry(page))
    if any(p.get("published") for p in points):
        hollow = dict(color="#555555", marker="o", hollow=True, line=False)
        entries.append((page.swatch(**hollow), "hollow: as published"))
    if any(p.get("default") for p in points):
        entries.append((page.swatch(**drawing.RING), "the default"))
    entries.append((page.swatch(**drawing.FRONT), "the front: nothing is both faster and more accurate"))
    rows = []
    for case in figure["cases"]:
        ours = [p for p in case["points"] if not p.get("peer") and not p.get("published")]
        for p in case["points"]:
            words = {"default": "default", "peer": "not part of Thenar", "published": "published"}
            marks = [word for key, word in words.items() if p.get(key)]
            ratio = analysis.ratio_to_front(p, ours)[0] if not p.get("peer") and analysis.solved([p]) else None
            rows.append([case["name"], p["method"], p["setting"], p["error"], p["us"], p.get("us_p99"), ratio,
                         ", ".join(marks)])
    numbers = table(["case", "method", "setting", figure["error"], figure["time"], "99 % of the times are below",
                     "time over the least of ours that is as accurate", ""], rows)
    return panels(svgs) + legend(entries), "", details("All numbers", numbers)


def outcome_map(page, figure):
    svgs, limits = drawing.outcome_map(page, figure)
    counts = [analysis.outcome_counts(panel) for panel in figure["panels"]]
    known = dict.fromkeys([*analysis.OUTCOMES, *(outcome for count in counts for outcome in count)])
    seen = [outcome for outcome in known if any(outcome in count for count in counts)]
    entries = [(page.patch(drawing.outcome_look(outcome)), outcome) for outcome in seen]
    entries += [(page.swatch(dash=dash, **drawing.LIMIT), name) for name, dash in limits.items()]
    if figure.get("reference"):
        entries.append((page.swatch(**drawing.STAR), "the scene itself"))
    reasons = ""
    for panel in figure["panels"]:
        if panel.get("ours") and analysis.failures(panel):
            items = "".join(f"<li>{count} {text(outcome)}: {text(reason) or 'no reason given, which is a defect'}</li>"
                            for outcome, count, reason in analysis.failures(panel))
            reasons += f"<p>Where <i>{text(panel['name'])}</i> fails, and a typical reason:</p>\n<ul>{items}</ul>\n"
    others = "".join(f"<li>{text(panel['name'])}: {count} {text(outcome)}: {text(reason) or '–'}</li>"
                     for panel in figure["panels"] if not panel.get("ours")
                     for outcome, count, reason in analysis.failures(panel))
    rows = [[panel["name"], *(count.get(o, 0) for o in seen)] for panel, count in zip(figure["panels"], counts)]
    numbers = table(["", *seen], rows)
    if others:
        numbers += f"<p>Where the others fail, and a typical reason:</p>\n<ul>{others}</ul>"
    return panels(svgs) + legend(entries), reasons, details("Cells by what became of them", numbers)


def curves(page, figure):
    svgs, look = drawing.curves(page, figure)
    swatches = {name: page.swatch(**style) for name, style in look.items()}
    all_curves = [(panel["name"], curve) for panel in figure["panels"] for curve in panel["curves"]]
    peers = [peers_entry(page)] if any(curve.get("peer") for _, curve in all_curves) else []
    if any(curve.get("exponent") is not None for _, curve in all_curves):
        def name_of(curve):
            exponent = curve.get("exponent")
            return curve["name"] + (f": n^{exponent:.2f}" if exponent is not None else "")
        below = [legend([(swatches[c["name"]], name_of(c)) for c in panel["curves"]]) for panel in figure["panels"]]
        drawn = panels(svgs, below) + (legend(peers) if peers else "")
    else:
        drawn = panels(svgs) + legend([(swatches[name], name) for name in look] + peers)
    rows = [[panel, curve["name"], x, y] for panel, curve in all_curves for x, y in zip(curve["x"], curve["y"])]
    return drawn, "", details("All numbers", table(["", "", figure["x"]["label"], figure["y"]["label"]], rows))


def plain_table(_page, figure):
    return table(figure["columns"], figure["rows"]), "", ""


KINDS = {"work_precision": work_precision, "map": outcome_map, "curves": curves, "table": plain_table}


def figure_html(page, figure, number):
    drawn, conclusions, numbers = KINDS[figure["kind"]](page, figure)
    runs = f'<p class="runs">Runs: {text(figure["runs"])}</p>' if figure["runs"] else ""
    caption = f'<figcaption>{text(figure["caption"])}{runs}</figcaption>'
    # A table's caption stands above it, where a table that goes on over pages begins.
    content = (caption, drawn) if figure["kind"] == "table" else (drawn, caption)
    long = ' class="long"' if len(figure.get("rows", ())) > 20 else ""
    return (f'<figure id="f{number}"{long}>\n<h4>Figure {number}. {text(figure["title"])}</h4>\n{content[0]}\n'
            f"{content[1]}\n{conclusions}{numbers}\n</figure>")


def link(number):
    return f'<a class="nobr" href="#f{number}">Figure {number}</a>'


def measured_on(parts):
    """What the numbers were measured on: a line for all parts that share it."""
    groups = {}
    for part in parts:
        m = part["measured"]
        key = (m.get("machine"), m.get("threads"), m.get("compiler"), f"`{m.get('flags')}`",
               " ".join(filter(None, (m.get("version"), m.get("source")))),
               "quick" if m.get("quick") else "full", str(m.get("peers") or "none").strip(", "))
        groups.setdefault(key, []).append(part["part"])
    rows = [[", ".join(names) if len(groups) > 1 else "all", *key] for key, names in groups.items()]
    return table(["parts", "machine", "hardware threads", "compiler", "flags", "version", "measurement",
                  "measured beside ours"], rows)


def defaults(parts, numbers):
    """A row a choice: on how many scenes its default is on the front, and where it is not."""
    rows = []
    for choice, figures in analysis.choices(parts).items():
        for figure in figures:
            ratios = analysis.default_ratios(figure)
            marked = dict.fromkeys(named(p) for _, p, _, _ in ratios)
            worse = "; ".join(f"{text(case)}: {r:.2f} times the time of {named(best)}"
                              for case, _, r, best in ratios if r > analysis.NEAR)
            unmarked = len(figure["cases"]) - len({case for case, *_ in ratios})
            if unmarked:
                worse = "; ".join(filter(None, (worse, f"without a default that has a number: {unmarked}")))
            kind, verdict = analysis.verdict(ratios) if ratios else ("bad", "no default is marked")
            once = " (one run)" if re.search(r"\b(1|one|single) (run|round)", figure["runs"]) else ""
            rows.append([text(choice), f'<span class="{kind}">{verdict}{once}</span>', "<br>".join(marked), worse,
                         link(numbers[id(figure)])])
    return table(["choice", "on the front or within 10 %", "default", "where not", ""], rows, html=True)


def deletion_candidates(parts):
    items = "".join(f"<li>{text(choice)}: {text(', '.join(names))}</li>"
                    for choice, figures in analysis.choices(parts).items() if (names := analysis.not_needed(figures)))
    if not items:
        return ("<p>Every method of ours is needed: it is within 10 % of the front of ours on three scenes, or some "
                "scene has nothing else within 10 % of it, in time and in error.</p>")
    return ("<p>Within 10 % of the front of ours on fewer than three scenes, and on each of them something else is as "
            "good within 10 %; no part of the published model. Nothing would be lost without:</p>\n"
            f"<ul>{items}</ul>")


def failing(parts, numbers):
    rows = []
    for figure in analysis.maps(parts):
        named = link(numbers[id(figure)]), text(figure["title"])
        for panel in figure["panels"]:
            cells = sum(len(row) for row in panel["cells"])
            reasons = analysis.failures(panel)
            why = "<br>".join(f"{count} {text(outcome)}: "
                              f"{text(analysis.first_clause(reason)) or '<b>no reason given, which is a defect</b>'}"
                              for outcome, count, reason in reasons[:3]) if panel.get("ours") else ""
            rows.append([*named, f"<b>{text(panel['name'])}</b>" if panel.get("ours") else text(panel["name"]),
                         f"{cells - sum(count for _, count, _ in reasons)} of {cells}", why])
            named = "", ""
    columns = ["", "map", "method (ours in bold)", "held", "where ours fails: the most frequent reasons"]
    return table(columns, rows, html=True)


def listed(lines, title=""):
    items = "".join(f"<li>{text(line)}</li>" for line in lines)
    return (f"<p>{title}</p>\n" if title else "") + f"<ul>{items}</ul>" if lines else ""


def summary(parts, numbers):
    blocks = ["<p>Time stands beside the error that it was had at. Down and to the left is better. A point that no "
              "other beats in both is on the <i>front</i>; a default should lie on it. Errors below 1e-12 are "
              "rounding, and all alike.</p>", listed(headlines.published(parts), "Beside the published times:")]
    if analysis.choices(parts):
        blocks.append("<h3>The defaults</h3>\n<p>A default is held against our own other methods and settings that are "
                      "as accurate or more; the drawn front includes what is not part of Thenar. "
                      f"{analysis.ENOUGH_SCENES} scenes on the front are asked for.</p>\n"
                      + defaults(parts, numbers) + deletion_candidates(parts))
    if analysis.maps(parts):
        blocks.append("<h3>Where methods fail</h3>\n" + failing(parts, numbers))
    blocks.append(listed(headlines.unanswered(parts), "Contact problems made at random that a solver had no answer to, "
                         "and the families with most:"))
    blocks.append("<h3>What the numbers were measured on</h3>\n" + measured_on(parts))
    return "\n".join(filter(None, blocks))


def trials_table(trials):
    """What endurance and faults came to: one row each."""
    rows = []
    if faults := trials.get("faults"):
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(faults["trials"].items()))
        rows.append(["faults", f"{faults['seconds'] / 60:.0f} min, seeds from {faults['first_seed']} on",
                     f"{sum(faults['trials'].values())} trials of every command: {kinds}", faults["findings"]])
    if soak := trials.get("soak"):
        rows.append(["soak at 4 kHz", f"{soak['seconds'] / 60:.0f} min, seed {soak['seed']}",
                     f"{soak['messages']} inputs, {soak['connections']} connections, {soak['pages']} pages, "
                     f"{soak['recording_MB']:.0f} MB recorded; memory {soak['memory_first_MB']:.1f} MB at first, "
                     f"{soak['memory_last_MB']:.1f} MB at last; {soak['unaccounted']} frames unaccounted, "
                     f"{soak['lost_records']} records lost", soak["findings"]])
    return table(["", "how long", "what it came to", "findings"],
                 [[*row, "; ".join(findings) or "none"] for *row, findings in rows])


def render(parts, scenes=(), trials=None):
    """The page, as text: the same parts give the same bytes."""
    page = drawing.Page()
    layout = analysis.sections(parts)
    order = [figure for _, groups, _ in layout for _, figures in groups for figure in figures]
    numbers = {id(figure): i + 1 for i, figure in enumerate(order)}
    contents, body = [], []
    for i, (title, groups, missing) in enumerate(layout, 1):
        if i == 2 and scenes:
            rows = [[f"`{name}`", line] for name, line in scenes]
            body.append("<h2>The scenes</h2>\n" + table(["configs/", "what happens"], rows))
        body.append(f'<h2 id="s-{i}">{i}. {text(title)}</h2>')
        lines = []
        if missing:
            names = ", ".join(f"<code>{text(name)}</code>" for name in missing)
            body.append(f'<p class="missing">Not measured: {names}. <code>./dev bench</code> measures all parts.</p>')
        for part, figures in groups:
            body.append(f"<div class=\"intro\"><h3>{text(part['title'])}</h3>\n<p>{text(part['text'])}</p></div>")
            for figure in figures:
                number = numbers[id(figure)]
                body.append(figure_html(page, figure, number))
                lines.append(f'<li class="figure"><a href="#f{number}">{number}. {text(figure["title"])}</a></li>')
        inner = f"\n<ol>{''.join(lines)}</ol>" if lines else ""
        contents.append(f'<li><a href="#s-{i}">{text(title)}</a>{inner}</li>')
    if trials:
        body.append("<h2>Faults and endurance</h2>\n" + trials_table(trials))
    quick = " A quick measurement: scatter is larger than in a full one." if any(
        part["measured"].get("quick") for part in parts) else ""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Thenar: speed against accuracy</title>
<style>{STYLE}</style>
</head>
<body>
<h1>Thenar: speed against accuracy, stability where methods fail, and no more than a scene needs</h1>
<p class="soft">A real-time engine of the human grasp.{quick}</p>
{listed(headlines.headlines(parts))}
<h2 id="summary">Summary</h2>
{summary(parts, numbers)}
<nav>
<h2>Contents</h2>
<ol>{"".join(contents)}</ol>
</nav>
{chr(10).join(body)}
</body>
</html>
"""
