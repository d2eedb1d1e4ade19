#!/usr/bin/env python3
"""Draws the charts of solvers.json or hertz.json: draw.py FILE FOLDER writes an SVG and a PNG of each."""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

plt.rcParams.update({
    "font.size": 10, "axes.grid": True, "grid.color": "#e4e4e4", "axes.spines.top": False, "axes.spines.right": False,
    "axes.edgecolor": "#555555", "lines.linewidth": 1.8, "legend.frameon": False, "svg.fonttype": "none",
    "axes.titlesize": 11, "figure.titlesize": 12, "axes.axisbelow": True,
})

# One colour a method in all charts: ours are saturated, peers grey and dashed.
STYLE = {
    "gauss_seidel": dict(color="#c0392b"), "sweeps": dict(color="#e67e22"),
    "newton": dict(color="#2563a8"), "newton_alone": dict(color="#2563a8"),
    "active_set": dict(color="#c0392b"), "lemke": dict(color="#2563a8"), "exact_cone": dict(color="#3a8f5c"),
    "siconos_nsgs": dict(color="#555555", ls="--"), "siconos_nsn": dict(color="#999999", ls="--"),
    "siconos_lexicolemke": dict(color="#555555", ls="--"), "bullet_pgs": dict(color="#555555", ls=":"),
    "bullet_lemke": dict(color="#999999", ls="--"), "ode_dantzig": dict(color="#999999", ls=":"),
    "boussinesq": dict(color="#c0392b", marker="o", ms=4), "gaussian": dict(color="#2563a8", marker="s", ms=4),
}
LABEL = {
    "gauss_seidel": "Gauss-Seidel, accelerated", "sweeps": "plain sweeps",
    "newton": "Gauss-Seidel, then Newton", "newton_alone": "springs and Newton", "active_set": "pyramid, active set",
    "lemke": "pyramid, Lemke", "exact_cone": "exact cone", "siconos_nsgs": "Siconos NSGS",
    "siconos_nsn": "Siconos Newton (Alart-Curnier)", "siconos_lexicolemke": "Siconos lexicolemke",
    "bullet_pgs": "Bullet PGS (square friction)", "bullet_lemke": "Bullet Lemke",
    "ode_dantzig": "ODE Dantzig (square friction)",
    "boussinesq": "boussinesq: elastic half space", "gaussian": "gaussian: the published model, calibrated at 1 mm",
}
# In problems without a square of friction.
PLAIN = {"ode_dantzig": "ODE Dantzig"}


def style(method):
    return dict(STYLE.get(method, {}), label=LABEL.get(method, method))


def legend_below(figure, axes, columns):
    entries = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="lower center", ncol=columns)


def save(figure, folder, name, note):
    figure.text(0.995, 0.995, note, ha="right", va="top", fontsize=7, color="#777777")
    for ending in ("svg", "png"):
        figure.savefig(folder / f"{name}.{ending}", dpi=110)
    plt.close(figure)


def contact_residual(data, folder, note):
    problems = list(dict.fromkeys((c["problem"], c["start"]) for c in data["contact_residual"]))
    figure, axes = plt.subplots(2, len(problems), figsize=(4.2 * len(problems), 7.4), sharey=True, squeeze=False)
    for column, (problem, start) in enumerate(problems):
        for row, (key, label) in enumerate((("us", "time [µs]"), ("sweeps", "sweeps or Newton steps"))):
            axis = axes[row][column]
            for curve in data["contact_residual"]:
                if (curve["problem"], curve["start"]) != (problem, start):
                    continue
                points = [(x, r) for x, r in zip(curve[key], curve["residual"]) if x > 0]
                single = len(points) == 1
                axis.loglog(*zip(*points), marker="o" if single else None, **style(curve["method"]))
            axis.set_ylim(1e-13, 2)
            axis.axhline(1e-6, color="#888888", lw=0.8)
            axis.set_xlabel(label)
            if row == 0:
                axis.set_title(f"{problem}, {start}")
        axes[0][0].set_ylabel("residual (natural map)")
        axes[1][0].set_ylabel("residual (natural map)")
    figure.tight_layout(rect=(0, 0.09, 1, 0.97))
    legend_below(figure, axes.flat, 4)
    save(figure, folder, "contact_residual", note)


def growth(data, folder, note):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 5.2))
    for curve in data["grasp_growth"]:
        line = style(curve["method"])
        if "wrong_verdicts_percent" in curve:
            line["label"] = PLAIN.get(curve["method"], line["label"])
            line["label"] += f", LCP given: up to {max(curve['wrong_verdicts_percent']):.0f} % wrong"
        left.semilogy(curve["contacts"], curve["us"], marker="o", ms=3, **line)
    left.axhline(40, color="#888888", lw=0.8)
    left.text(2, 42, "published, 3 contacts, 2006", ha="left", va="bottom", fontsize=8, color="#666666")
    left.set(title="Grasp forces, cold, from geometry and wrench", xlabel="contacts", ylabel="median time [µs]")
    left.set_ylim(0.1, 1500)
    left.legend(fontsize=8, loc="upper left", bbox_to_anchor=(0, 1.0), ncol=1)
    for curve in data["contact_growth"]:
        line = style(curve["method"])
        line["label"] += f": n^{curve['exponent']:.2f}"
        right.loglog(curve["contacts"], curve["us"], marker="o", ms=3, **line)
    right.set(title="Contact forces, all points pressed, cold, to 1e-6", xlabel="contacts", ylabel="median time [µs]")
    right.legend(fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    save(figure, folder, "growth", note)


def pyramid(data, folder, note):
    figure, axis = plt.subplots(figsize=(7.5, 5))
    floor = 1e-15
    for point in data["pyramid"]:
        error, high = max(point["error_median"], floor), max(point["error_p90"], floor)
        exact = point["name"].startswith("exact")
        color = "#3a8f5c" if exact else "#c0392b"
        axis.errorbar(point["us"], error, yerr=[[0], [high - error]], fmt="o", color=color, capsize=3)
        axis.annotate(point["name"], (point["us"], error), textcoords="offset points", xytext=(8, 4), fontsize=9)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set(title="What a friction pyramid costs in accuracy: 3 contacts, the cone active",
             xlabel="median time [µs]", ylabel="force error against the exact cone (its own: KKT), median and 90 %")
    axis.margins(x=0.2)
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    save(figure, folder, "pyramid", note)


def profile(data, folder, note):
    families = list(dict.fromkeys(c["family"] for c in data["profile"]))
    columns = 3
    rows = -(-len(families) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4 * columns, 2.9 * rows + 0.8), sharex=True, sharey=True,
                                squeeze=False)
    for axis in list(axes.flat)[len(families):]:
        axis.axis("off")
    for axis, family in zip(axes.flat, families):
        for curve in (c for c in data["profile"] if c["family"] == family):
            times = sorted(curve["us"])
            shares = [100 * (k + 1) / curve["problems"] for k in range(len(times))]
            if times:
                axis.step(times + [1e7], shares + shares[-1:], where="post", **style(curve["method"]))
            else:
                axis.plot([1, 1e7], [0, 0], **style(curve["method"]))
        axis.set_title(family)
        axis.set_xscale("log")
        axis.set_xlim(1, 1e6)
        axis.set_ylim(-2, 103)
    for axis in axes[-1]:
        axis.set_xlabel("time [µs]")
    for row in axes:
        row[0].set_ylabel("solved to 1e-6 [%]")
    figure.tight_layout(rect=(0, 0.07, 1, 0.98))
    legend_below(figure, axes.flat, 3)
    save(figure, folder, "profile", note)


def hertz(data, folder, note):
    rows = (("contacts", "control points within reach at 1 mm"), ("us", "time of the contact solve, cold, to 1e-6 [µs]"))
    columns = (("force_error", "force, 0.5 to 2 mm deep"), ("force_error_1mm", "force, 1 mm deep"),
               ("radius_error", "contact radius, 1 mm"), ("pressure_error", "pressure, 1 mm"))
    figure, axes = plt.subplots(len(rows), len(columns), figsize=(15, 7.6), sharey=True)
    for row, (x, x_label) in enumerate(rows):
        for column, (y, title) in enumerate(columns):
            axis = axes[row][column]
            for curve in data["hertz"]:
                axis.loglog(curve[x], [100 * e for e in curve[y]], **style(curve["kernel"]))
            axis.set_xlabel(x_label)
            axis.set_yticks([0.1, 0.3, 1, 3, 10, 30], ["0.1", "0.3", "1", "3", "10", "30"])
            axis.set_ylim(0.08, 60)
            axis.minorticks_off()
            ticks = [5, 10, 30, 60, 120, 240] if x == "contacts" else [1, 3, 10, 30, 100, 300, 1000]
            axis.set_xticks(ticks, [str(t) for t in ticks])
            if row == 0:
                axis.set_title(title)
    for axis in axes[:, 0]:
        axis.set_ylabel("error against Hertz, rms [%]")
    figure.tight_layout(rect=(0, 0.06, 1, 0.97))
    legend_below(figure, axes.flat, 2)
    save(figure, folder, "hertz", note)


def print_verdicts(data):
    print(f"{'contact family':18}{'solved':>8}{'none':>8}{'no answer':>11}{'worst residual':>16}{'p50 us':>10}{'p99 us':>10}")
    for r in data["contact_verdicts"]:
        print(f"{r['family']:18}{r['solved']:8}{r['no_solution']:8}{r['unanswered']:11}{r['worst_residual']:16.1e}"
              f"{r['p50_us']:10.1f}{r['p99_us']:10.1f}")
    print(f"\n{'grasp family':18}{'method':12}{'optimal':>8}{'none':>8}{'no answer':>11}{'worst error':>16}"
          f"{'p50 us':>10}{'p99 us':>10}")
    for r in data["grasp_verdicts"]:
        print(f"{r['family']:18}{r['method']:12}{r['optimal']:8}{r['infeasible']:8}{r['unanswered']:11}"
              f"{r['worst_kkt_error']:16.1e}{r['p50_us']:10.2f}{r['p99_us']:10.2f}")


def main():
    data = json.loads(Path(sys.argv[1]).read_text())
    folder = Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    note = data["note"]
    for chart in (contact_residual, pyramid, profile, hertz):
        if data.get(chart.__name__):
            chart(data, folder, note)
    if "contact_growth" in data:
        growth(data, folder, note)
    if "contact_verdicts" in data:
        print_verdicts(data)


if __name__ == "__main__":
    main()
