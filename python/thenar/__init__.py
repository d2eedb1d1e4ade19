# SPDX-License-Identifier: Apache-2.0
"""Thenar: a hand that holds an object, in real time.

    import thenar

    simulation = thenar.Simulation(thenar.Scene("box_grasp"))
    print(simulation.run()["outcome"])

Everything is in SI units; world axes are the hand's. Names of fields are those of recordings and of the live window.
"""
from __future__ import annotations

import os as _os
from pathlib import Path as _Path

from . import _core
from ._core import (
    Grasp,
    Period,
    Realtime,
    Recording,
    Scene,
    Simulation,
    __commit__,
    __version__,
    grasp,
    hands,
    new_scene,
    rollout,
    scenes,
    sweep,
)
from .errors import Diagnostic, Error, FileError, NoGrasp, SceneError
from .result import Run, run
from . import solve

__all__ = [
    "Diagnostic", "Error", "FileError", "Grasp", "NoGrasp", "Period", "Realtime", "Recording", "Run", "Scene",
    "SceneError", "Simulation", "grasp", "hands", "new_scene", "rollout", "run", "scenes", "solve", "sweep",
]

_share = _Path(__file__).parent / "share"
if _share.is_dir():
    _core.use_data(_os.fspath(_share))
