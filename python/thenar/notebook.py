# SPDX-License-Identifier: Apache-2.0
"""What a notebook shows of a simulation and of a recording: the window's page."""
from __future__ import annotations

import html
import tempfile
from pathlib import Path

from . import _core
from .errors import FileError

HEIGHT = 640  #: Of the page in a notebook [pixels].
LARGEST = 32 << 20  #: Recording in a page [bytes]: the notebook keeps the whole page.


def _text(text: str) -> str:
    return f"<pre>{html.escape(text)}</pre>"


def of_recording(file: Path, same: bool = True) -> str:
    """The page with the recording in it, as a frame, or the reason why there is none.

    same: the file is still the one that was read.
    """
    if not same:
        return _text(f"{file} is gone, or another one, since it was read: there is no picture of it")
    if file.stat().st_size > LARGEST:
        return _text(f"{file} is too large for a notebook: thenar export {file} --html makes a page of it")
    try:
        page = _core._page(file)
    except FileError as error:
        return _text(str(error))
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'


def of_simulation(simulation: _core.Simulation) -> str:
    """The page with this instant of the simulation in it, which a step later does not change."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "now.mcap")
        try:
            simulation._record_now(file)
        except (ValueError, RuntimeError) as error:  # closed, or being stepped
            return _text(f"{simulation!r}: {error}")
        return of_recording(file)
