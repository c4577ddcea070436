"""What this package raises and warns of."""

from __future__ import annotations

import os
from typing import Any

__all__ = ["Caveat", "Error", "FileError"]


class Error(ValueError):
    """An input cannot be used, or there is no answer.

    text  what is wrong, and what to do
    name  of the C library's status, as "RIGCAL_ERR_BEHIND"; "" when Python found it
    bad   index of the observation at fault; None when no single one is
    """

    def __init__(self, text: str, name: str = "", bad: int | None = None) -> None:
        super().__init__(text)
        self.text = text
        self.name = name
        self.bad = bad

    def __str__(self) -> str:
        return f"{self.name}: {self.text}" if self.name else self.text


class FileError(Error):
    """A file cannot be read or written: `str` gives "file: what"."""

    def __init__(self, path: str | os.PathLike[str], what: str) -> None:
        self.path = os.fspath(path)
        self.what = what
        super().__init__(f"{self.path}: {what}")

    def __reduce__(self) -> tuple[type[FileError], tuple[str, str]]:
        return type(self), (self.path, self.what)


def path_of(path: Any, what: str = "path") -> str:
    """The path as text; Error if it is none."""
    try:
        return os.fsdecode(path)
    except TypeError:
        raise Error(f"{what}: a path is expected, not {type(path).__name__}") from None


class Caveat(UserWarning):
    """There is an answer that can be used, with a reservation that the text names."""
