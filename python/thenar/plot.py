"""Figures of a run, as PNG files for a page or a talk: python -m thenar.plot out/

It draws what `thenar run SCENE --out out/` has written, or a thenar.Run. It needs matplotlib.
"""
from __future__ import annotations

import argparse
import csv
import json
import os
import sys
from itertools import takewhile
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np

from .errors import FileError
from .result import Array, Run

Signals = Mapping[str, Array]

_FINGERS = ("#c0392b", "#2563a8", "#3a8f5c", "#b7791f", "#7d4e9e")  # As in all figures of Thenar.
_INK, _FAINT = "#222222", "#9aa0a6"
_GRIP_S = 0.3  # Until then the grip builds up: summary.json counts it by itself.
_MUSCLES = 8  # So many have a colour and a name, the strongest.
_STYLE = {
    "figure.facecolor": "white", "figure.dpi": 150, "font.size": 11, "font.family": "sans-serif",
    "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#666666", "axes.labelcolor": _INK,
    "axes.titlesize": 12, "axes.titleweight": "bold", "axes.titlelocation": "left", "axes.grid": True,
    "grid.color": "#e6e6e6", "grid.linewidth": 0.8, "axes.axisbelow": True, "xtick.color": "#444444",
    "ytick.color": "#444444", "lines.linewidth": 1.8, "lines.solid_capstyle": "round", "legend.frameon": False,
}


def figures(run: Run) -> dict[str, Any]:
    """Draws a run: matplotlib figures by name, "path", "forces", "grip", "solver" and, with muscles, "muscles".

    Raises ImportError without matplotlib, ValueError for a run without a tick. figure.savefig(file) writes one.
    """
    return _draw(run.signals, run.summary)


def save(drawn: Mapping[str, Any], folder: Union[str, "os.PathLike[str]"]) -> list[Path]:
    """Writes each figure as <name>.png into a folder, which is made where it is missing. Raises FileError."""
    files = []
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        for name, figure in drawn.items():
            files.append(Path(folder) / f"{name}.png")
            figure.savefig(files[-1])
    except OSError as error:
        raise FileError(f"{error.filename or folder}: {error.strerror or error}") from None
    return files


def _draw(signals: Signals, summary: Mapping[str, Any]) -> dict[str, Any]:
    import matplotlib

    if len(signals["time_s"]) == 0:
        raise ValueError("the run has no tick: there is nothing to draw")
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, "backend": matplotlib.get_backend(), **_STYLE}):
        drawn = {name: draw(signals, summary) for name, draw in _DRAWN.items()}
    return {name: figure for name, figure in drawn.items() if figure is not None}


def _fingers(signals: Signals) -> list[str]:
    end = "_desired_normal_N"
    return [name[: -len(end)] for name in signals if name.endswith(end)]


def _stack(summary: Mapping[str, Any], signals: Signals, titles: Sequence[str], units: Sequence[str]) -> Any:
    """A figure of panels, one above the other, and its panels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 1.2 + 2.0 * len(titles)), layout="constrained")
    panels = figure.subplots(len(titles), 1, sharex=True, squeeze=False)[:, 0]
    lost_s = summary["grasp"]["lost_at_s"]
    outcome = summary["grasp"]["outcome"] + (f" at {lost_s:.2f} s" if lost_s is not None else "")
    figure.suptitle(f"{summary['scene']}: {outcome}", x=0.01, ha="left", fontsize=13, color="#555555")
    end_s = float(signals["time_s"][-1])
    shaded = end_s > 2.0 * _GRIP_S
    if shaded:
        figure.text(0.985, 0.985, "shaded: the grip builds up", ha="right", va="top", fontsize=9, color=_FAINT)
    for panel, title, unit in zip(panels, titles, units):
        panel.set_title(title)
        panel.set_ylabel(unit)
        panel.set_xlim(0.0, end_s)
        panel.margins(y=0.08)
        if shaded:
            panel.axvspan(0.0, _GRIP_S, color="#f4f4f4", zorder=0, linewidth=0)
        if lost_s is not None:
            panel.axvline(lost_s, color=_INK, linewidth=1.0, linestyle=":")
    panels[-1].set_xlabel("time [s]")
    return figure, panels


def _key(panel: Any) -> None:
    """The legend, above the panel at its right, where no curve is."""
    _, names = panel.get_legend_handles_labels()
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncol=max(1, len(names)), borderaxespad=0.1,
                 handlelength=1.6, columnspacing=1.4)


def _path(signals: Signals, summary: Mapping[str, Any]) -> Any:
    figure, (way, off, turn) = _stack(
        summary, signals, ["Displacement", "Off the target", "Angle to the target"], ["mm", "mm", "deg"]
    )
    t = signals["time_s"]
    for axis, colour in zip("xyz", _FINGERS):
        position, target = signals[f"position_{axis}_mm"], signals[f"target_{axis}_mm"]
        way.plot(t, position, color=colour, label=axis)
        way.plot(t, target, color=_INK, linewidth=1.1, linestyle="--", label="target" if axis == "z" else None)
        off.plot(t, position - target, color=colour)
    turn.plot(t, signals["rotation_error_deg"], color=_INK)
    _key(way)
    return figure


def _forces(signals: Signals, summary: Mapping[str, Any]) -> Any:
    fingers = _fingers(signals)
    figure, panels = _stack(summary, signals, [name.capitalize() for name in fingers], ["N"] * len(fingers))
    t = signals["time_s"]
    for panel, finger in zip(panels, fingers):
        for what, colour in (("normal", _FINGERS[0]), ("tangential", _FINGERS[1])):
            panel.plot(t, signals[f"{finger}_{what}_N"], color=colour, label=what)
            desired = signals[f"{finger}_desired_{what}_N"]
            if np.nan_to_num(desired).any():  # Without a controller nothing is desired.
                panel.plot(t, desired, color=_INK, linewidth=1.1, linestyle="--",
                           label="desired" if what == "tangential" else None)
        panel.set_ylim(bottom=0.0)
    _key(panels[0])
    return figure


def _grip(signals: Signals, summary: Mapping[str, Any]) -> Any:
    figure, (margin, slip, spin) = _stack(
        summary, signals, ["Margin to sliding", "Slip since first contact", "Spin since first contact"],
        ["1: free, 0: slides", "µm", "deg"],
    )
    t = signals["time_s"]
    for finger, colour in zip(_fingers(signals), _FINGERS):
        margin.plot(t, signals[f"{finger}_margin"], color=colour, label=finger)
        slip.plot(t, signals[f"{finger}_slip_um"], color=colour)
        spin.plot(t, signals[f"{finger}_spin_deg"], color=colour)
    margin.set_ylim(0.0, 1.0)
    slip.set_ylim(bottom=0.0)
    spin.set_ylim(bottom=0.0)
    _key(margin)
    return figure


def _muscles(signals: Signals, summary: Mapping[str, Any]) -> Any:
    # The columns of muscles come behind those of the solve.
    columns = list(signals)
    behind = columns[columns.index("penetration_um") + 1:] if "penetration_um" in columns else []
    names = list(takewhile(lambda name: name.endswith("_N") and not name.startswith("environment_"), behind))
    if not names:
        return None
    figure, (panel,) = _stack(summary, signals, ["Muscle forces"], ["N"])
    figure.set_size_inches(9.0, 5.0)
    # The fingers' way to the object, in the first ticks, is no part of what is to be seen.
    t = signals["time_s"]
    seen = t > 0.05 if t[-1] > 0.1 else t > 0.0
    names.sort(key=lambda name: -float(np.max(signals[name][seen])))
    colours = (*_FINGERS, "#17a2b8", "#222222", "#d4699e")
    for name in reversed(names[_MUSCLES:]):
        panel.plot(t, signals[name], color="#c9cdd2", linewidth=1.0)
    for name, colour in zip(names[:_MUSCLES], colours):
        panel.plot(t, signals[name], color=colour)
    peak = max(float(np.max(signals[names[0]][seen])), 1e-3)
    panel.set_ylim(0.0, 1.08 * peak)
    _name_ends(panel, float(t[-1]), {n[:-2]: float(signals[n][-1]) for n in names[:_MUSCLES]}, colours, peak / 20.0)
    if len(names) > _MUSCLES:
        panel.set_title(f"Muscle forces, the {_MUSCLES} strongest of {len(names)} by name")
    return figure


def _name_ends(panel: Any, x: float, ends: Mapping[str, float], colours: Sequence[str], apart: float) -> None:
    """Names curves at their right ends, so far apart that they can be read."""
    order = sorted(zip(ends.values(), ends, colours))
    places = [order[0][0]]
    for value, _, _ in order[1:]:
        places.append(max(value, places[-1] + apart))
    for (_, name, colour), place in zip(order, places):
        panel.annotate(name, (x, place), xytext=(6, 0), textcoords="offset points", color=colour, va="center",
                       fontsize=10, fontweight="bold", annotation_clip=False)


def _solver(signals: Signals, summary: Mapping[str, Any]) -> Any:
    figure, (residual, sweeps, contacts) = _stack(
        summary, signals, ["Residual of the contact solve", "Sweeps", "Contacts"], ["no unit", "a tick", "points"]
    )
    t = signals["time_s"]
    tolerance, most = summary["settings"]["tolerance"], summary["settings"]["max_sweeps"]
    values = signals["residual"]
    residual.semilogy(t, np.where(values > 0.0, values, np.nan), color=_FINGERS[1], linewidth=0.9)
    seen = np.append(values[np.isfinite(values) & (values > 0.0)], tolerance)
    residual.set_ylim(10.0 ** np.floor(np.log10(seen.min())), 10.0 ** (np.ceil(np.log10(seen.max()) - 1e-9) + 0.2))
    residual.minorticks_off()
    residual.axhline(tolerance, color=_INK, linewidth=1.1, linestyle="--", label=f"tolerance {tolerance:.0e}")
    _key(residual)
    sweeps.plot(t, signals["sweeps"], color=_FINGERS[1], linewidth=0.9, label=f"of {most} at most")
    sweeps.set_ylim(bottom=0.0)
    _key(sweeps)
    contacts.plot(t, signals["contacts"], color=_FAINT, label="found")
    contacts.plot(t, signals["active"], color=_FINGERS[2], label="carry force")
    contacts.set_ylim(bottom=0.0)
    _key(contacts)
    return figure


_DRAWN = {"path": _path, "forces": _forces, "grip": _grip, "muscles": _muscles, "solver": _solver}


def _read_signals(file: Path) -> dict[str, Array]:
    """signals.csv: names of columns to arrays. Raises FileError with the file and line."""
    with file.open(newline="", encoding="utf-8") as lines:
        rows = csv.reader(lines)
        names: list[str] = next(rows, [])
        if "time_s" not in names or not any(name.endswith("_desired_normal_N") for name in names):
            raise FileError(f"{file}:1: no header of a signals.csv")
        table = []
        for row in rows:
            if len(row) != len(names):
                raise FileError(f"{file}:{rows.line_num}: {len(row)} values, of {len(names)} columns")
            try:
                table.append([float(value) for value in row])
            except ValueError as error:
                raise FileError(f"{file}:{rows.line_num}: {error}") from None
    columns = np.array(table, dtype=np.float64).reshape(-1, len(names)).T
    return dict(zip(names, columns))


def _read_summary(file: Path) -> dict[str, Any]:
    with file.open(encoding="utf-8") as text:
        try:
            summary = json.load(text)
        except ValueError as error:
            raise FileError(f"{file}: {error}") from None
    try:
        summary["scene"], summary["grasp"]["outcome"], summary["grasp"]["lost_at_s"]
        summary["settings"]["tolerance"], summary["settings"]["max_sweeps"]
    except (KeyError, TypeError) as error:
        raise FileError(f"{file}: no summary of a run: {error} is missing") from None
    return dict(summary)


def _read(folder: Path) -> dict[str, Any]:
    """The figures of a folder. Raises FileError."""
    try:
        return _draw(_read_signals(folder / "signals.csv"), _read_summary(folder / "summary.json"))
    except UnicodeDecodeError:
        raise FileError(f"{folder}: its files are not text") from None
    except KeyError as error:
        raise FileError(f"{folder / 'signals.csv'}:1: there is no column {error}") from None
    except ValueError as error:
        raise FileError(f"{folder / 'signals.csv'}: {error}") from None
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{error.filename}: {error.strerror}") from None


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """The program: what it ends with, 0, or 2 for a wrong command, or 3 for a file that it cannot read or write."""
    parser = argparse.ArgumentParser(prog="python -m thenar.plot",
                                     description="Draws the figures of a run as PNG files.")
    parser.add_argument("folder", type=Path, help="what `thenar run SCENE --out FOLDER` has written")
    parser.add_argument("--to", type=Path, metavar="DIR", help="where the figures go; by default into the folder")
    options = parser.parse_args(arguments)
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        print("thenar.plot: needs matplotlib (Debian: python3-matplotlib)", file=sys.stderr)
        return 2
    try:
        for file in save(_read(options.folder), options.to or options.folder):
            print(file)
    except FileError as error:
        print(f"thenar.plot: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
