# SPDX-License-Identifier: Apache-2.0
"""Draws the figures of the report with gnuplot: every panel is an SVG of its own, so that a page can set them side by
side or one below the other. Readable in black and white: markers beside colours, hatches in maps."""

import itertools
import json
import math
import re
import subprocess
from html import escape
from pathlib import Path
from textwrap import wrap

import analysis

FONT, BOLD = "DejaVu Sans", "Bold"  # gnuplot writes no weights: the second name becomes one.
WIDTH, HEIGHT = 305, 260  # Of a panel [px].
LINE = 13  # Of text.

# The colours of the live window and of the program's figures: what stands between the outer braces is JSON.
PALETTE = json.loads("{" + (Path(__file__).parents[2] / "app/page/src/palette.js").read_text().partition("{")[2].rpartition("}")[0] + "}")
OURS = (*PALETTE["fingers"], *PALETTE["others"])
OURS_MARKERS = "os^Dvpx+*"
PEERS = ("#6a6a6a", "#9a9a9a", "#444444", "#b0b0b0", "#7d7d7d")
PEERS_MARKERS = "s^Dvo"
# gnuplot's point types, filled and as an outline.
MARKERS = {"o": (7, 6), "s": (5, 4), "^": (9, 8), "v": (11, 10), "D": (13, 12), "p": (15, 14), "+": (1, 1),
           "x": (2, 2), "*": (3, 3)}
DASHED = "(7,4)"
FRONT = dict(color="#f0d060", width=4.5)
RING = dict(color="#000000", marker="o", size=1.5, hollow=True, line=False)
LIMIT_DASHES = (DASHED, "(10,4,2,4)", "(2,3)", "(14,4)")
LIMIT = dict(color="#000000", width=2.0)
LAW = dict(color="#000000", width=1.5)  # Among curves.
STAR = dict(color="#000000", marker="D", size=1.4, hollow=True, line=False)

# gnuplot's hatch of an outcome's face, and its colour: from light to dark also without colours.
HATCHES = {
    "over limits": (2, "#5a3d78"),
    "slipping": (4, "#8a6100"),
    "resting": (3, "#5e5830"),
    "task failed": (8, "#6b2b12"),
    "outside": (2, "#707070"),
    "jammed": (4, "#7a1f3d"),
    "wedged": (5, "#f0c8d4"),
    "unstable": (1, "#5c1a0a"),
    "lost": (6, "#3a1206"),
    "off target": (5, "#1f3f66"),
    "refused": (7, "#8a8a8a"),
}


def outcome_look(outcome):
    """An outcome's face, hatch and colour of the hatch."""
    if outcome not in PALETTE["outcomes"]:
        return "#ffffff", 6, "#000000"
    return PALETTE["outcomes"][outcome], *HATCHES.get(outcome, (None, None))


def _quoted(text):
    """A string of gnuplot's, in which nothing has a meaning."""
    return "'" + str(text).replace("'", "''") + "'"


class Picture:
    """What gnuplot is to draw: its commands, and the curves, each with its data."""

    def __init__(self, width, height):
        self._commands = [f"set terminal svg size {width},{height} noenhanced font '{FONT},10'", "unset key"]
        self._data, self._plots = [], []

    def add(self, *commands):
        self._commands += commands

    def plot(self, points, style):
        """Points [(x, y)] in a style of gnuplot's; later ones lie over earlier ones."""
        name = f"$d{len(self._data)}"
        self._data.append("\n".join([f"{name} << END", *(f"{x!r} {y!r}" for x, y in points), "END"]))
        self._plots.append(f"{name} {style}")

    def curve(self, points, color, width=1.3, dash=None, marker=None, size=0.8, hollow=False, line=True, every=1):
        """A line, markers, or both. A hollow marker is white within."""
        if line and len(points) > 1:
            self.plot(points, f"with lines lw {width} lc rgb '{color}'" + (f" dt {dash}" if dash else ""))
        if marker:
            filled, outline = MARKERS[marker]
            at = points[::every]
            self.plot(at, f"with points pt {filled} ps {size} lc rgb '{'#ffffff' if hollow else color}'")
            if hollow:
                self.plot(at, f"with points pt {outline} ps {size} lw 1.6 lc rgb '{color}'")

    def svg(self):
        # Something to plot, also where there is nothing to show.
        plots = self._plots or ["NaN notitle"]
        script = "\n".join([*self._data, *self._commands, "plot " + ", ".join(plots)])
        return subprocess.run(["gnuplot"], input=script, check=True, capture_output=True, text=True,
                              encoding="utf-8").stdout


class Page:
    """What the pictures of a page share: their identifiers must not meet, and a name looks the same in all figures."""

    def __init__(self):
        self._count = 0
        self._looks = {}

    def looks(self, entries):
        """{name: how its curve is drawn} of [(name, peer)]: one colour and marker each, others' grey and dashed."""
        for name, peer in entries:
            if (name, peer) not in self._looks:
                self._looks[name, peer] = self._new_look(peer, [self._looks[e] for e in entries if e in self._looks])
        return {name: self._looks[name, peer] for name, peer in entries}

    def _new_look(self, peer, beside):
        """A pair of colour and marker that no name has; a colour that none beside it has, as far as there is one."""
        colors, markers = (PEERS, PEERS_MARKERS) if peer else (OURS, OURS_MARKERS)
        # After all colours the markers are shifted.
        pairs = [(colors[i % len(colors)], markers[(i + i // len(colors)) % len(markers)])
                 for i in range(len(colors) * len(markers))]
        taken = [(look["color"], look["marker"]) for look in self._looks.values()]
        color, marker = min(pairs, key=lambda pair: (pair in taken, *(
            sum(look[key] == value for look in beside) for key, value in zip(("color", "marker"), pair))))
        return dict(color=color, marker=marker, dash=DASHED if peer else None)

    def svg(self, picture, label):
        """The picture as an <svg> for a page: without prolog, titles, unused symbols and identifiers, and the others by
        number."""
        svg = picture.svg()
        svg = re.sub(r"<!--.*?-->|<title>.*?</title>|<desc>.*?</desc>", "", svg[svg.index("<svg"):], flags=re.DOTALL)
        svg = svg.replace("xlink:href", "href").replace("'", '"')
        # Verdana has the widths of DejaVu Sans, which few machines have.
        family = f"font-family=\"'{FONT}', Verdana, sans-serif\""
        svg = svg.replace(f'font-family="{FONT}"', family).replace(f'font-family="{BOLD}"', f'{family} font-weight="bold"')
        used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', svg))
        svg = re.sub(r'<(path|circle)[^>]*\bid="([^"]+)"[^>]*?(/>|>.*?</\1>)',
                     lambda shape: shape.group() if shape.group(2) in used else "", svg, flags=re.DOTALL)
        for name in dict.fromkeys(re.findall(r'\bid="([^"]+)"', svg)):
            self._count += 1 if name in used else 0
            svg = re.sub(rf'\s*\bid="{re.escape(name)}"', f' id="s{self._count}"' if name in used else "", svg)
            svg = svg.replace(f"url(#{name})", f"url(#s{self._count})").replace(f'"#{name}"', f'"#s{self._count}"')
        view = re.search(r'viewBox="[^"]*"', svg).group()
        head = f'<svg {view} role="img" aria-label="{escape(label)}">'
        return re.sub(r"\s*\n\s*", "\n", re.sub(r"<svg[^>]*>", lambda _: head, svg, count=1)).strip()

    def swatch(self, **style):
        """A line or marker as a legend has it."""
        picture = _swatch()
        marker = {key: style.pop(key) for key in ("marker", "size", "hollow") if key in style}
        if style.pop("line", True):
            picture.curve([(0.08, 0.5), (0.92, 0.5)], **style)
        if marker:
            picture.curve([(0.5, 0.5)], style["color"], line=False, **marker)
        return self.svg(picture, "")

    def patch(self, look):
        picture = _swatch()
        _rectangle(picture, (0.06, 0.06, 0.94, 0.94), look)
        picture.add("set object rectangle from 0.06,0.06 to 0.94,0.94 fs empty border lc rgb '#555555'")
        return self.svg(picture, "")


def _swatch():
    picture = Picture(36, 17)
    picture.add("unset border", "unset tics", "set margins 0,0,0,0", "set xrange [0:1]", "set yrange [0:1]")
    return picture


def _rectangle(picture, corners, look):
    face, hatch, line = look
    place = "set object rectangle from {},{} to {},{} behind ".format(*corners)
    picture.add(place + f"fc rgb '{face}' fs solid noborder")
    if hatch:
        picture.add(place + f"fc rgb '{line}' fs transparent pattern {hatch} noborder")


def _panel(title, x_label, y_label):
    picture = Picture(WIDTH, HEIGHT)
    titles, below, beside = wrap(title, 40), wrap(x_label, 42), wrap(y_label, 36)
    picture.add("set border 3 lc rgb '#555555' lw 0.7", "set tics nomirror out scale 0.4 textcolor rgb '#222222'",
                "set grid xtics ytics back lt 1 lc rgb '#e6e6e6' lw 0.6",
                f"set lmargin at screen {(41 + LINE * len(beside)) / WIDTH}", f"set rmargin at screen {1 - 8 / WIDTH}",
                f"set bmargin at screen {(26 + LINE * len(below)) / HEIGHT}",
                f"set tmargin at screen {1 - (8 + LINE * len(titles)) / HEIGHT}")
    for i, line in enumerate(titles):
        picture.add(f"set label {_quoted(line)} at graph 0, screen {1 - LINE * (i + 0.7) / HEIGHT} left "
                    f"font '{BOLD},10'")
    for i, line in enumerate(below):
        picture.add(f"set label {_quoted(line)} at graph 0.5, screen {(LINE * (len(below) - i) - 8) / HEIGHT} center")
    for i, line in enumerate(beside):
        picture.add(f"set label {_quoted(line)} at screen {(10 + LINE * i) / WIDTH}, graph 0.5 center rotate by 90")
    return picture


def _ticks(picture, axis, ticks):
    """Ticks [(label, place)]."""
    offset = "offset 0,0.35 " if axis == "x" else ""
    picture.add(f"set {axis}tics {offset}({', '.join(f'{_quoted(label)} {place!r}' for label, place in ticks)})")


def _short(value):
    if 1e-3 < value < 1e4:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    return f"{value / 10.0**exponent:.0f}e{exponent}"


def _log_axis(picture, axis, low, high):
    """At most five labels in plain digits: decades, or 1-2-5 or all digits where there are less than three of them."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for digits in ((1,), (1, 2, 5), range(1, 10)):
        ticks = [s * 10.0**d for d in decades for s in digits if low <= s * 10.0**d <= high]
        if len(ticks) > 2:
            break
    step = -(-len(ticks) // 5)
    # Counted from 1 where there are decades, so that axes agree.
    first = round(math.log10(ticks[0])) if digits == (1,) else 0
    picture.add(f"set logscale {axis}")
    _ticks(picture, axis, [(_short(tick) if (first + i) % step == 0 else "", tick) for i, tick in enumerate(ticks)])


def _log_range(values, margin=0.12):
    low, high = math.log10(min(values)), math.log10(max(values))
    pad = max(margin * (high - low), 0.5 * (0.8 - (high - low)), 0.1)
    return 10 ** (low - pad), 10 ** (high + pad)


def _numbers(values):
    return [v for v in values if v is not None and v > 0]


def work_precision(page, figure):
    """[SVG a case], {method: look}: all cases share their axes, so that they can be compared."""
    cases = [case for case in figure["cases"] if case["points"]]
    points = [p for case in cases for p in case["points"]]
    # The default's method has the first colour.
    order = sorted(points, key=lambda p: not p.get("default"))
    look = page.looks([(p["method"], bool(p.get("peer"))) for p in order])
    errors, times = _numbers(p["error"] for p in points) or [1.0], _numbers(p["us"] for p in points) or [1.0]
    x_range, (bottom, top) = _log_range(times), _log_range(errors)
    # What errs by nothing lies on a line below all others, what has no error to tell on one above.
    floor = bottom if any(p["error"] == 0 for p in points) else None
    ceiling = top if any(p["error"] is None for p in points) else None
    span = (top / bottom) ** 0.12
    y_range = (bottom / span if floor else bottom, top * span if ceiling else top)

    def height(point):
        return ceiling if point["error"] is None else max(point["error"], floor or 0)

    svgs = []
    for case in cases:
        drawn = [p for p in case["points"] if p["us"]]
        picture = _panel(case["name"], figure["time"], figure["error"])
        picture.add("set xrange [{!r}:{!r}]".format(*x_range), "set yrange [{!r}:{!r}]".format(*y_range))
        _log_axis(picture, "x", *x_range)
        _log_axis(picture, "y", bottom, top)
        for level, words in ((floor, "no error at all"), (ceiling, "no answer")):
            if level:
                picture.plot([(x_range[0], level), (x_range[1], level)], "with lines lw 0.7 dt (1,3) lc rgb '#777777'")
                picture.add(f"set label {_quoted(words)} at {x_range[1]!r},{level!r} right offset 0,0.4 "
                            f"font '{FONT},8.5' textcolor rgb '#555555'")
        if best := analysis.front(drawn):
            corners = [(best[0]["us"], y_range[1])]
            for p, after in zip(best, [*(q["us"] for q in best[1:]), x_range[1]]):
                corners += [(p["us"], height(p)), (after, height(p))]
            picture.curve(corners, **FRONT)
        for method, style in sorted(look.items(), key=lambda item: not item[1]["dash"]):
            mine = [p for p in drawn if p["method"] == method]
            # A line in between is paler than its markers.
            picture.curve([(p["us"], height(p)) for p in mine], "#59" + style["color"][1:], 1.0, style["dash"])
            for p in mine:
                picture.curve([(p["us"], height(p))], style["color"], marker=style["marker"],
                              hollow=bool(p.get("published")))
                if p.get("default"):
                    ring = MARKERS["o"][1]
                    picture.plot([(p["us"], height(p))], f"with points pt {ring} ps 1.7 lw 1.4 lc rgb '#000000'")
        svgs.append(page.svg(picture, f"{figure['title']}: {case['name']}"))
    return svgs, look


def _index_of(value, values, log):
    """Where a value lies among cells, in cells; beyond them as far as the outermost two go on."""
    at = [math.log(v) for v in values] if log else values
    value = math.log(value) if log else value
    if len(at) < 2:
        return 0.0
    i = min(max(sum(value > a for a in at) - 1, 0), len(at) - 2)
    return i + (value - at[i]) / (at[i + 1] - at[i])


def _cell_axis(picture, axis, values, log, most):
    digits = 2 if log else 3
    step = -(-len(values) // most)
    _ticks(picture, axis, [(analysis.number(float(values[i]), digits), i) for i in range(0, len(values), step)])
    picture.add(f"set {axis}range [-0.5:{len(values) - 0.5}]")


def outcome_map(page, figure):
    """[SVG a panel], {limit: dash}."""
    x, y = figure["x"], figure["y"]
    columns, rows = len(x["values"]), len(y["values"])
    names = dict.fromkeys(limit["label"] for panel in figure["panels"] for limit in panel.get("limits") or [])
    dashes = {name: LIMIT_DASHES[i % len(LIMIT_DASHES)] for i, name in enumerate(names)}

    def place(px, py):
        return _index_of(px, x["values"], x.get("log")), _index_of(py, y["values"], y.get("log"))

    svgs = []
    for panel in figure["panels"]:
        picture = _panel(panel["name"], x["label"], y["label"])
        picture.add("unset grid", "unset border")
        for j, row in enumerate(panel["cells"]):
            i = 0
            while i < columns:  # One rectangle a run of equal cells, so that hatches are not cut.
                end = i
                while end < columns and row[end]["outcome"] == row[i]["outcome"]:
                    end += 1
                _rectangle(picture, (i - 0.5, j - 0.5, end - 0.5, j + 0.5), outcome_look(row[i]["outcome"]))
                i = end
        between = [[(i - 0.5, -0.5), (i - 0.5, rows - 0.5)] for i in range(1, columns)]
        between += [[(-0.5, j - 0.5), (columns - 0.5, j - 0.5)] for j in range(1, rows)]
        for line in between:
            picture.curve(line, "#ffffff", 0.8)
        for limit in panel.get("limits") or []:
            line = [place(px, py) for px, py in zip(limit["x"], limit["y"]) if px is not None and py is not None]
            picture.curve(line, "#ffffff", 4.0)
            picture.curve(line, dash=dashes[limit["label"]], **LIMIT)
        if figure.get("reference"):
            picture.curve([place(*figure["reference"])], **STAR)
        _cell_axis(picture, "x", x["values"], x.get("log"), 6)
        _cell_axis(picture, "y", y["values"], y.get("log"), 11)
        svgs.append(page.svg(picture, f"{figure['title']}: {panel['name']}"))
    return svgs, dashes


def curves(page, figure):
    """[SVG a panel], {curve: look}."""
    all_curves = [curve for panel in figure["panels"] for curve in panel["curves"]]
    look = page.looks([(curve["name"], bool(curve.get("peer"))) for curve in all_curves if not curve.get("theory")])
    laws = dict.fromkeys(curve["name"] for curve in all_curves if curve.get("theory"))
    look |= {name: dict(dash=dash, **LAW) for name, dash in zip(laws, itertools.cycle(LIMIT_DASHES))}
    svgs = []
    for panel in figure["panels"]:
        picture = _panel(panel["name"], figure["x"]["label"], figure["y"]["label"])
        seen = {"x": [], "y": []}
        # Others' lie below ours.
        for curve in panel["curves"]:
            if curve.get("low"):
                around = [*zip(curve["x"], curve["low"]), *reversed([*zip(curve["x"], curve["high"])])]
                color = look[curve["name"]]["color"]
                picture.plot(around, f"with filledcurves closed fs transparent solid 0.2 noborder lc rgb '{color}'")
        for curve in sorted(panel["curves"], key=lambda c: not c.get("peer")):
            pairs = [(a, b) for a, b in zip(curve["x"], curve["y"])
                     if all(v is not None and (v > 0 or not figure[k].get("log")) for k, v in (("x", a), ("y", b)))]
            if pairs:
                picture.curve(pairs, **look[curve["name"]], every=-(-len(pairs) // 12))
                for key, values in zip("xy", zip(*pairs)):
                    seen[key] += values
        for axis in "xy":
            if figure[axis].get("log") and seen[axis]:
                low, high = _log_range(seen[axis], margin=0.06)
                picture.add(f"set {axis}range [{low!r}:{high!r}]")
                _log_axis(picture, axis, low, high)
            elif axis == "x":
                picture.add(f"set rmargin at screen {1 - 14 / WIDTH}")  # Half of the last number stands there.
            elif seen[axis] and min(seen[axis]) >= 0:
                picture.add("set yrange [0:*]")
        svgs.append(page.svg(picture, f"{figure['title']}: {panel['name']}"))
    return svgs, look
