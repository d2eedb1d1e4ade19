"""What a notebook shows of a simulation and of a recording: the window's page."""
from __future__ import annotations

import html
import os
import tempfile
from typing import Optional

from . import _core
from .errors import FileError

HEIGHT = 640  #: Of the page in a notebook [pixels].


def of_recording(file: str) -> Optional[str]:
    """The page with the recording in it, as a frame. None where it has no picture: its text is shown instead."""
    try:
        page = _core._page(file)
    except FileError:
        return None
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'


def of_simulation(simulation: _core.Simulation) -> Optional[str]:
    """The page with this instant of the simulation in it, which a step later does not change."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "now.mcap")
        simulation._record_now(file)
        return of_recording(file)
