# SPDX-License-Identifier: Apache-2.0
"""Whole runs."""
from __future__ import annotations

import os
from typing import Any, Callable, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _core

Array = npt.NDArray[np.float64]
Law = Optional[Callable[[_core.Period], npt.ArrayLike]]


class Run:
    """A run that has ended."""

    def __init__(self, scene: _core.Scene, summary: dict[str, Any], signals: dict[str, Array]) -> None:
        self.scene = scene
        self.summary = summary  #: As summary.json has it: measures with units in their names.
        self.signals = signals  #: As signals.csv: name, with unit, to an array of one number a tick.

    @property
    def outcome(self) -> str:
        """"held", "slipping", "lost", ...: see docs/reference/results.md."""
        return str(self.summary["grasp"]["outcome"])

    def __repr__(self) -> str:
        return f"<thenar.Run of '{self.scene.name}': {self.outcome}>"


def run(
    scene: _core.Scene,
    *,
    record: Optional[Union[str, "os.PathLike[str]"]] = None,
    record_rate: Optional[Union[float, str]] = None,
    record_fields: Optional[Sequence[str]] = None,
    record_contacts: bool = False,
    lockstep: Union[bool, dict[str, Any]] = False,
    wrench: Law = None,
    forces: Optional[Callable[[_core.Period], Optional[npt.ArrayLike]]] = None,
    torques: Law = None,
    muscles: Law = None,
) -> Run:
    """Runs a scene to its end, as `thenar run`: the same bits.

    record: an MCAP file of what the run looks like. record_rate: its states of a simulated second, [Hz] or text
    with a unit; 50 unless given. record_fields: names of the fields of a state, all unless given, which a picture needs. record_contacts:
    every contact of every tick, too.
    lockstep and laws as of Simulation.
    """
    if not isinstance(scene, _core.Scene):
        raise TypeError(f"run takes a thenar.Scene, not {type(scene).__name__}: thenar.Scene('box_grasp')")
    if record is None and (record_rate is not None or record_fields is not None or record_contacts):
        raise ValueError("record_rate, record_fields and record_contacts need record, the file to write")
    result = _core._run(
        scene, record, record_rate, record_fields, bool(record_contacts), lockstep, wrench, forces, torques, muscles
    )
    return Run(scene, result["summary"], result["signals"])
