# SPDX-License-Identifier: Apache-2.0
"""What thenar raises."""
from __future__ import annotations

from typing import NamedTuple, Optional


class Diagnostic(NamedTuple):
    """One thing wrong with a scene."""

    location: str  #: ``file:line:column``, or ``--set key`` for a value that set() gave.
    key: str  #: Full path, such as "object.mass".
    message: str  #: What is wrong, and what would be right.

    @property
    def file(self) -> Optional[str]:
        return self.location.rsplit(":", 2)[0] if self._has_place() else None

    @property
    def line(self) -> Optional[int]:
        return int(self.location.rsplit(":", 2)[1]) if self._has_place() else None

    @property
    def column(self) -> Optional[int]:
        return int(self.location.rsplit(":", 2)[2]) if self._has_place() else None

    def _has_place(self) -> bool:
        parts = self.location.rsplit(":", 2)
        return len(parts) == 3 and parts[1].isdigit() and parts[2].isdigit()

    def __str__(self) -> str:
        return f"{self.location}: {self.key}: {self.message}" if self.key else f"{self.location}: {self.message}"


class Error(Exception):
    """Of all that thenar raises by itself."""


class SceneError(Error, ValueError):
    """A file, or what set() made of it, is no scene. `diagnostics` has every fault; file, line, column and key are the
    first one's."""

    def __init__(self, diagnostics: list[tuple[str, str, str]]) -> None:
        self.diagnostics = [Diagnostic(*one) for one in diagnostics]
        super().__init__("\n".join(str(one) for one in self.diagnostics))
        first = self.diagnostics[0] if self.diagnostics else Diagnostic("", "", "")
        self.file, self.line, self.column, self.key = first.file, first.line, first.column, first.key

    def __reduce__(self) -> tuple[type, tuple[list[tuple[str, str, str]]]]:
        return type(self), ([(one.location, one.key, one.message) for one in self.diagnostics],)


class FileError(Error, OSError):
    """A file that cannot be read or written, or does not hold what it should: `filename`. It has no errno."""

    def __init__(self, message: str, filename: Optional[str] = None) -> None:
        super().__init__(message)
        self.filename = filename

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[type, tuple[str, Optional[str]], dict[str, object]]:
        return type(self), (str(self), self.filename), self.__dict__


class NoGrasp(Error):
    """There is no grasp of this hand on this object; the text says why, and what would help."""
