#!/usr/bin/env python3
"""Draws the charts of collision.json: draw_collision.py collision.json FOLDER writes an SVG and a PNG of each."""

import json
import sys
import textwrap
from pathlib import Path

from draw import plt, save

OURS = "#c0392b"
FLOOR_UM = 1e-3  # What is smaller is rounding.
METHODS = {
    "thenar": dict(color=OURS, marker="o"), "nanoflann": dict(color="#2563a8", marker="s"),
    "distance grid": dict(color="#3a8f5c", marker="D"), "FCL": dict(color="#555555", marker="^"),
    "Bullet": dict(color="#999999", marker="v"),
}
STAGES = {
    "find": "#c0392b", "compliance": "#e67e22", "assemble": "#2563a8", "solve": "#3a8f5c", "deform": "#8e6bb0",
    "display": "#bbbbbb",
}
STAGE_LABELS = {
    "find": "contact finding", "compliance": "compliance", "assemble": "assembly", "solve": "Gauss-Seidel, 10 sweeps",
    "deform": "control points", "display": "display: all samples",
}
# What hardware alone has gained since the Pentium IV at 2.2 GHz, about.
HARDWARE = 10
OBJECTS = {"box": "cube of 50 mm", "scan": "bumpy ellipsoid, unevenly sampled"}


def style(name):
    return next(look for start, look in METHODS.items() if name.startswith(start))


def thousands(n):
    return f"{round(n / 1000)}k"


def distance_error(data, folder, note):
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.6), sharey=True)
    for axis, name in zip(axes, OBJECTS):
        points = [p for p in data["distance_error"] if p["object"] == name]
        groups = {}
        for p in points:
            groups.setdefault(p["method"].split(",")[0], []).append(p)
        for group, members in groups.items():
            look = style(group)
            x = [p["us"] for p in members]
            mean, worst = ([max(p[key], FLOOR_UM) for p in members] for key in ("mean_error_um", "max_error_um"))
            label = group if all(p["signed"] for p in members) else f"{group} (no sign)"
            axis.plot(x, mean, lw=1.2, ms=7, label=label, **look)
            for i, p in enumerate(members):
                axis.plot([x[i], x[i]], [mean[i], worst[i]], color=look["color"], lw=0.9)
                axis.plot(x[i], worst[i], color=look["color"], marker="_", ms=9)
                what = p["method"].split(", ")[1] if group == "distance grid" else thousands(p["samples"])
                axis.annotate(what, (x[i], worst[i]), textcoords="offset points", xytext=(0, 5), ha="center",
                              fontsize=8, color=look["color"])
        axis.set(xscale="log", yscale="log", title=OBJECTS[name], xlabel="time of one query [µs]")
        axis.set_ylim(0.5 * FLOOR_UM, 2e3)
        axis.margins(x=0.1)
    axes[0].set_ylabel("error of the distance [µm]: mean, and whisker to the largest")
    axes[0].text(0.01, 0.01, "0.001 µm: rounding", transform=axes[0].transAxes, fontsize=8, color="#666666")
    axes[1].legend(fontsize=9, loc="lower right")
    figure.suptitle("Signed distance of points from 2 mm inside to 0.3 mm outside, against the exact one", x=0.01, y=0.99,
                    ha="left")
    figure.tight_layout(rect=(0, 0, 1, 0.96))
    save(figure, folder, "distance_error", note)


def finding_growth(data, folder, note):
    titles = {
        "contacts": ("contacts, three fingers", "Time against contacts"),
        "points": ("samples of the object", "Time against the object's samples (60 contacts)"),
        "controls": ("control points of a pulp", "Time against control points (60 contacts)"),
    }
    figure, axes = plt.subplots(1, 3, figsize=(14.5, 5.2), sharey=True)
    looks = {
        "box": dict(color=OURS), "scan": dict(color="#2563a8"), "whole computation": dict(color="#3a8f5c"),
    }
    for axis, (over, (label, title)) in zip(axes, titles.items()):
        for curve in (c for c in data["growth"] if c["over"] == over):
            look = looks[curve["name"].split(",")[0]]
            dash = "--" if curve["name"].endswith("warm") else "-"
            axis.loglog(curve["n"], curve["us"], marker="o", ms=4, ls=dash,
                        label=f"{curve['name']}: n$^{{{curve['exponent']:.2f}}}$", **look)
            axis.set_xticks(curve["n"])
            axis.set_xticklabels([thousands(n) if n >= 10000 else f"{n:.0f}" for n in curve["n"]])
        axis.minorticks_off()
        axis.set(xlabel=label, title=title)
        axis.legend(fontsize=9, loc="lower right")
        axis.axhline(1000, color="#888888", lw=0.8)
    axes[0].text(15, 950, "a tick of 1 kHz", fontsize=8, color="#666666", va="top")
    axes[0].set_ylabel("median time, three fingers [µs]")
    low, high = axes[0].get_ylim()
    axes[0].set_ylim(0.25 * low, high)
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    save(figure, folder, "finding_growth", note)


def number(value):
    return f"{value:.0f}" if value >= 9.95 else f"{value:.2g}" if value >= 0.005 else "0"


def finding_methods(data, folder, note):
    rows = [row for name in OBJECTS for row in data["finding"] if row["object"] == name]
    figure, (axis, text) = plt.subplots(1, 2, figsize=(15, 0.42 * len(rows) + 1.9), sharey=True,
                                        gridspec_kw=dict(width_ratios=(1, 1.25), wspace=0.02))
    text.axis("off")
    columns = {"µs": 0.0, "found /\nthere": 0.08, "gap error [µm]\nmean / worst": 0.21, "does not compute": 0.39}
    for title, x in columns.items():
        text.text(x, 0.6, title, fontsize=9, fontweight="bold", va="bottom", transform=text.get_yaxis_transform(), clip_on=False)
    for i, row in enumerate(rows):
        axis.barh(-i, row["us"] - 1, left=1, color=style(row["method"])["color"], height=0.62)
        cells = (number(row["us"]), f"{row['found']:.0f} / {row['there']:.0f}",
                 f"{number(row['mean_error_um'])} / {number(row['max_error_um'])}",
                 textwrap.fill(row["lacks"], 70) or "—")
        for x, cell in zip(columns.values(), cells):
            text.text(x, -i, cell, va="center", fontsize=8 if x == columns["does not compute"] else 9,
                      transform=text.get_yaxis_transform())
    axis.set_yticks([-i for i in range(len(rows))], [f"{r['method']} ({r['object']})" for r in rows], fontsize=9)
    axis.set_ylim(0.4 - len(rows), 1.6)
    axis.set_xscale("log")
    axis.set_xlim(1, 2 * max(r["us"] for r in rows))
    axis.grid(False, axis="y")
    axis.set_xlabel("median time for three fingers [µs]")
    figure.suptitle("Contacts of three pulps of 320 control points with a cube and a scan of 36 000 samples, 20 a finger",
                    x=0.01, y=0.985, ha="left")
    figure.subplots_adjust(left=0.185, right=0.995, bottom=0.5 / figure.get_figheight(),
                           top=1 - 0.35 / figure.get_figheight())
    save(figure, folder, "finding_methods", note)


def breakdown(data, folder, note):
    rows = data["breakdown"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 5.2), gridspec_kw=dict(width_ratios=(1.25, 1)))
    for i, row in enumerate(rows):
        start = 0
        for stage, color in STAGES.items():
            left.barh(-i, row[stage], left=start, color=color, height=0.6, label=STAGE_LABELS[stage] if i == 0 else None)
            if row[stage] > 0.045 * rows[-1]["total"]:
                left.text(start + row[stage] / 2, -i, f"{row[stage]:.0f}", ha="center", va="center", fontsize=8,
                          color="white" if stage != "display" else "black")
            start += row[stage]
        left.text(start, -i, f"  {row['total']:.0f} µs\n  residual {row['residual']:.0e}", va="center", fontsize=8.5)
    left.set_yticks([-i for i in range(len(rows))], [f"{r['contacts']} contacts" + ("" if "published" in r else "\n(pulps twice\nas fine)")
                                                     for r in rows])
    left.set_xlim(0, 1.2 * rows[-1]["total"])
    left.grid(False, axis="y")
    left.set(title="One contact computation of the box grasp", xlabel="median time, one core [µs]")
    left.legend(fontsize=8, loc="upper right")

    known = [r for r in rows if "published" in r]
    width = 0.26
    for i, row in enumerate(known):
        bars = ((row["published"], "#999999", "published 2006: 2.2 GHz Pentium IV"),
                (row["published"] / HARDWARE, "#cccccc", f"the same, on hardware {HARDWARE} times as fast"),
                (row["total"], OURS, "this build"))
        for k, (us, color, label) in enumerate(bars):
            at = i + (k - 1) * width
            right.bar(at, us, width=0.92 * width, color=color, label=label if i == 0 else None)
            right.text(at, 1.06 * us, f"{us / 1000:.0f} ms" if us >= 2000 else f"{us:.0f} µs", ha="center", fontsize=8.5)
        ratio = row["published"] / row["total"]
        right.text(i + width, 0.55 * row["total"], f"÷ {ratio:.0f}", ha="center", color="white", fontsize=8.5)
    right.set_yscale("log")
    right.set_ylim(10, 1.5e5)
    right.set_xticks(range(len(known)), [f"{r['contacts']} contacts" for r in known])
    right.grid(False, axis="x")
    right.set(title=f"Against the published totals (about ÷ {HARDWARE} is hardware alone)", ylabel="total [µs]")
    right.legend(fontsize=8.5, loc="upper left")
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    save(figure, folder, "contact_breakdown", note)


def main():
    data = json.loads(Path(sys.argv[1]).read_text())
    folder = Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for chart in (distance_error, finding_growth, finding_methods, breakdown):
        chart(data, folder, data["note"])


if __name__ == "__main__":
    main()
