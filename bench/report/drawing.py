"""Draws the figures of the report: every panel is an SVG of its own, so that a page can set them side by side or one
below the other. Readable in black and white: markers beside colours, hatches in maps."""

import io
import math
import re
from html import escape
from textwrap import fill

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

import analysis

plt.rcParams.update({
    "font.size": 7.5, "axes.titlesize": 8,
    "axes.titleweight": "bold", "axes.titlelocation": "left", "axes.grid": True, "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6, "axes.axisbelow": True, "axes.spines.top": False, "axes.spines.right": False,
    "axes.edgecolor": "#555555", "axes.linewidth": 0.7, "xtick.major.width": 0.7, "ytick.major.width": 0.7,
    "lines.linewidth": 1.3, "lines.markersize": 4.5, "hatch.linewidth": 0.6, "svg.fonttype": "none",
    "axes.unicode_minus": False,
})

PANEL_IN = (3.05, 2.6)

OURS = ("#c0392b", "#2563a8", "#2e8b57", "#d98200", "#7b3fa0", "#0b8c8c", "#8c6d31", "#c2478d", "#4d4d00", "#00457a")
OURS_MARKERS = "os^DvPX*<>"
PEERS = ("#6a6a6a", "#9a9a9a", "#444444", "#b0b0b0", "#7d7d7d")
PEERS_MARKERS = "s^Dvo"
FRONT = dict(color="#f0d060", lw=3.6, solid_capstyle="butt", solid_joinstyle="round", zorder=1.5)
RING = dict(marker="o", ms=10, mfc="none", mec="black", mew=1.2, ls="none", zorder=5)
LIMIT_STYLES = ("--", "-.", ":", (0, (6, 1.5)))
LIMIT = dict(color="black", lw=1.6, zorder=4)
STAR = dict(marker="*", ms=11, mfc="white", mec="black", mew=1.0, ls="none", zorder=6)

# Face, hatch, and the hatch's colour: from light to dark also without colours.
OUTCOME_LOOKS = {
    "held": ("#dcefe0", None, "#dcefe0"),
    "over limits": ("#cdb6e0", "....", "#5a3d78"),
    "slipping": ("#f5d27a", "////", "#8a6100"),
    "unstable": ("#de6b4e", "xxxx", "#5c1a0a"),
    "lost": ("#a34a28", "++++", "#3a1206"),
    "off target": ("#9db8d9", "\\\\\\\\", "#1f3f66"),
    "solver failed": ("#3d2b56", None, "#3d2b56"),
    "refused": ("#f4f4f4", "---", "#8a8a8a"),
}


def outcome_look(outcome):
    face, hatch, line = OUTCOME_LOOKS.get(outcome, ("#ffffff", "++++", "#000000"))
    return dict(facecolor=face, hatch=hatch, edgecolor=line, linewidth=0)


class Page:
    """What the pictures of a page share: their identifiers must not meet, and a name looks the same in all figures."""

    def __init__(self):
        self._count = 0
        self._looks = {}

    def looks(self, entries):
        """{name: how its line is drawn} of [(name, peer)]: one colour and marker each, others' grey and dashed."""
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
        return dict(color=color, marker=marker, ls="--" if peer else "-", mew=1.0)

    def svg(self, figure, label):
        """The figure as an <svg> for a page: without prolog, date, size and unused identifiers, and the others, which
        are random, by number."""
        text = io.StringIO()
        figure.savefig(text, format="svg")
        plt.close(figure)
        svg = text.getvalue()
        svg = re.sub(r"<metadata>.*?</metadata>\s*", "", svg[svg.index("<svg"):], flags=re.DOTALL)
        svg = re.sub(r"<!--.*?-->\s*", "", svg, flags=re.DOTALL).replace("xlink:href", "href")
        # Verdana has the widths of DejaVu Sans, which few machines have.
        svg = re.sub(r"'DejaVu Sans'[^;\"]*", "'DejaVu Sans', Verdana, sans-serif", svg)
        svg = re.sub(r"<style.*?</style>", "", svg, flags=re.DOTALL)
        svg = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d\.\d\d)\d+", r"\1", tag.group()), svg)
        for name in dict.fromkeys(re.findall(r'\bid="([^"]+)"', svg)):
            used = re.search(rf'(url\(#|href="#){re.escape(name)}\b', svg)
            self._count += 1 if used else 0
            svg = svg.replace(f' id="{name}"', f' id="s{self._count}"' if used else "")
            svg = svg.replace(f"url(#{name})", f"url(#s{self._count})").replace(f'"#{name}"', f'"#s{self._count}"')
        view = re.search(r'viewBox="[^"]*"', svg).group()
        head = f'<svg {view} role="img" aria-label="{escape(label)}">'
        return re.sub(r"\s*\n\s*", "\n", re.sub(r"<svg[^>]*>", lambda _: head, svg, count=1)).strip()

    def swatch(self, **style):
        """A line or marker as a legend has it."""
        figure = plt.figure(figsize=(0.36, 0.17))
        figure.add_artist(Line2D([0.1, 0.5, 0.9], [0.5] * 3, markevery=[1], **style))
        return self.svg(figure, "")

    def patch(self, **style):
        figure = plt.figure(figsize=(0.36, 0.17))
        for look in (style, dict(fill=False, ec="#555555", lw=0.6)):
            figure.add_artist(Rectangle((0.08, 0.05), 0.84, 0.9, transform=figure.transFigure, **look))
        return self.svg(figure, "")


def _panel(title):
    figure, axes = plt.subplots(figsize=PANEL_IN)
    if title:
        axes.set_title(fill(title, 40))
    return figure, axes


def _short(value):
    if 1e-3 < value < 1e4:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    return f"{value / 10.0**exponent:.0f}e{exponent}"


def _log_axis(axis, low, high):
    """At most five labels in plain digits: decades, or 1-2-5 or all digits where there are less than three of them."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for digits in ((1,), (1, 2, 5), range(1, 10)):
        ticks = [s * 10.0**d for d in decades for s in digits if low <= s * 10.0**d <= high]
        if len(ticks) > 2:
            break
    step = -(-len(ticks) // 5)
    # Counted from 1 where there are decades, so that axes agree.
    first = round(math.log10(ticks[0])) if digits == (1,) else 0
    axis.set_major_locator(FixedLocator(ticks))
    labels = [_short(tick) if (first + i) % step == 0 else "" for i, tick in enumerate(ticks)]
    axis.set_major_formatter(FixedFormatter(labels))
    axis.set_minor_locator(NullLocator())


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
        fig, axes = _panel(case["name"])
        axes.set(xscale="log", yscale="log", xlim=x_range, ylim=y_range, xlabel=fill(figure["time"], 42),
                 ylabel=fill(figure["error"], 36))
        _log_axis(axes.xaxis, *x_range)
        _log_axis(axes.yaxis, bottom, top)
        for level, text in ((floor, "no error at all"), (ceiling, "no answer")):
            if level:
                axes.axhline(level, color="#777777", lw=0.7, ls=(0, (1, 2)))
                axes.text(0.995, level, text, transform=axes.get_yaxis_transform(), ha="right", va="bottom",
                          fontsize=6.5, color="#555555")
        best = analysis.front(drawn)
        if best:
            axes.step([p["us"] for p in best[:1] + best] + [x_range[1]],
                      [y_range[1]] + [height(p) for p in best + best[-1:]], where="post", **FRONT)
        for method, style in look.items():
            mine = [p for p in drawn if p["method"] == method]
            axes.plot([p["us"] for p in mine], [height(p) for p in mine], zorder=2 if style["ls"] == "--" else 3,
                      **{**style, "marker": "", "lw": 1.0, "alpha": 0.65})
            for p in mine:
                axes.plot(p["us"], height(p), zorder=3, **{**style, "ls": "none"},
                          mfc="white" if p.get("published") else style["color"])
                if p.get("default"):
                    axes.plot(p["us"], height(p), **RING)
        fig.tight_layout(pad=0.4)
        svgs.append(page.svg(fig, f"{figure['title']}: {case['name']}"))
    return svgs, look


def _index_of(value, values, log):
    """Where a value lies among cells, in cells; beyond them as far as the outermost two go on."""
    at = [math.log(v) for v in values] if log else values
    value = math.log(value) if log else value
    if len(at) < 2:
        return 0.0
    i = min(max(sum(value > a for a in at) - 1, 0), len(at) - 2)
    return i + (value - at[i]) / (at[i + 1] - at[i])


def _cell_axis(axis, values, log, most):
    digits = 2 if log else 3
    step = -(-len(values) // most)
    ticks = list(range(0, len(values), step))
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(FixedFormatter([analysis.number(float(values[i]), digits) for i in ticks]))


def outcome_map(page, figure):
    """[SVG a panel], {limit: line style}."""
    x, y = figure["x"], figure["y"]
    columns, rows = len(x["values"]), len(y["values"])
    names = dict.fromkeys(limit["label"] for panel in figure["panels"] for limit in panel.get("limits") or [])
    styles = {name: LIMIT_STYLES[i % len(LIMIT_STYLES)] for i, name in enumerate(names)}

    def place(px, py):
        return _index_of(px, x["values"], x.get("log")), _index_of(py, y["values"], y.get("log"))

    svgs = []
    for panel in figure["panels"]:
        fig, axes = _panel(panel["name"])
        axes.grid(False)
        for j, row in enumerate(panel["cells"]):
            i = 0
            while i < columns:  # One rectangle a run of equal cells, so that hatches are not cut.
                end = i
                while end < columns and row[end]["outcome"] == row[i]["outcome"]:
                    end += 1
                axes.add_patch(Rectangle((i - 0.5, j - 0.5), end - i, 1, **outcome_look(row[i]["outcome"])))
                i = end
        axes.vlines([i - 0.5 for i in range(1, columns)], -0.5, rows - 0.5, color="white", lw=0.8, zorder=2)
        axes.hlines([j - 0.5 for j in range(1, rows)], -0.5, columns - 0.5, color="white", lw=0.8, zorder=2)
        for limit in panel.get("limits") or []:
            line = [place(px, py) for px, py in zip(limit["x"], limit["y"]) if px is not None and py is not None]
            axes.plot(*zip(*line), color="white", lw=3.2, zorder=3.5)
            axes.plot(*zip(*line), ls=styles[limit["label"]], **LIMIT)
        if figure.get("reference"):
            axes.plot(*place(*figure["reference"]), clip_on=False, **STAR)
        axes.set(xlim=(-0.5, columns - 0.5), ylim=(-0.5, rows - 0.5), xlabel=fill(x["label"], 42),
                 ylabel=fill(y["label"], 36))
        _cell_axis(axes.xaxis, x["values"], x.get("log"), 6)
        _cell_axis(axes.yaxis, y["values"], y.get("log"), 11)
        fig.tight_layout(pad=0.4)
        svgs.append(page.svg(fig, f"{figure['title']}: {panel['name']}"))
    return svgs, styles


def curves(page, figure):
    """[SVG a panel], {curve: look}."""
    all_curves = [curve for panel in figure["panels"] for curve in panel["curves"]]
    look = page.looks([(curve["name"], bool(curve.get("peer"))) for curve in all_curves])
    svgs = []
    for panel in figure["panels"]:
        fig, axes = _panel(panel["name"])
        seen = {"x": [], "y": []}
        for curve in panel["curves"]:
            pairs = [(a, b) for a, b in zip(curve["x"], curve["y"])
                     if all(v is not None and (v > 0 or not figure[k].get("log")) for k, v in (("x", a), ("y", b)))]
            if pairs:
                style = look[curve["name"]]
                axes.plot(*zip(*pairs), markevery=-(-len(pairs) // 12), zorder=2 if style["ls"] == "--" else 3, **style)
                for key, values in zip("xy", zip(*pairs)):
                    seen[key] += values
        axes.set(xlabel=fill(figure["x"]["label"], 42), ylabel=fill(figure["y"]["label"], 36))
        for key, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            if figure[key].get("log") and seen[key]:
                getattr(axes, f"set_{key}scale")("log")
                limits = _log_range(seen[key], margin=0.06)
                getattr(axes, f"set_{key}lim")(limits)
                _log_axis(axis, *limits)
        fig.tight_layout(pad=0.4)
        svgs.append(page.svg(fig, f"{figure['title']}: {panel['name']}"))
    return svgs, look
