"""A value in a file that knows its place, so that errors can name it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import Any

import numpy as np

from ..errors import Error
from ..transform import Array

NUMBERS_MAX = 10000  # of one array: more is no part of a camera


def flatten(value: Any) -> Iterator[Any]:
    """The leaves of nested lists, in order."""
    if isinstance(value, (list, tuple)):
        for part in value:
            yield from flatten(part)
    else:
        yield value


def _is_plain(value: Any) -> bool:
    return isinstance(value, (str, int)) or (isinstance(value, float) and isfinite(value))


class PlacedError(Error):
    """An Error whose text says already where in the file it is."""


class Node:
    """`value` as a parser gave it: dict, list, str, number, None; `where` "cam0.size"."""

    def __init__(self, value: Any, where: str = "") -> None:
        self.value = value
        self.where = where

    def fail(self, what: str) -> PlacedError:
        """The error: what is wrong at this place."""
        return PlacedError(f"{self.where}: {what}" if self.where else what)

    def _at(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key

    def mapping(self) -> dict[str, Node]:
        """The parts by name. Fails if this has no named parts."""
        if not isinstance(self.value, dict):
            raise self.fail("named values are expected")
        return {str(k): Node(v, self._at(str(k))) for k, v in self.value.items()}

    def list(self) -> list[Node]:
        """The parts in order. Fails if this is not a list."""
        if not isinstance(self.value, list):
            raise self.fail("a list is expected")
        return [Node(v, f"{self.where}[{i}]") for i, v in enumerate(self.value)]

    def get(self, *keys: str) -> Node | None:
        """The first of these names that exists and is not null."""
        parts = self.mapping()
        for key in keys:
            if key in parts and parts[key].value is not None:
                return parts[key]
        return None

    def __getitem__(self, keys: str | tuple[str, ...]) -> Node:
        """The first of these names that exists. Fails if none does."""
        names = (keys,) if isinstance(keys, str) else keys
        part = self.get(*names)
        if part is None:
            raise self.fail(f"{' or '.join(names[:3])} is missing")
        return part

    def __contains__(self, key: str) -> bool:
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def plain(self, keys: Sequence[str]) -> dict[str, Any]:
        """The values of these names that are numbers, texts or lists of them: they are kept
        to be written again, and not used."""
        kept = {}
        for key in keys:
            if key in self and all(map(_is_plain, flatten(self[key].value))):
                kept[key] = self[key].value
        return kept

    def text(self) -> str:
        """A text that is not empty; whole numbers count as text, as in names."""
        if isinstance(self.value, int) and not isinstance(self.value, bool):
            return str(self.value)
        if not isinstance(self.value, str) or not self.value.strip():
            raise self.fail("a text is expected")
        return self.value

    def flag(self) -> bool:
        """True or false; numbers count, 0 as false."""
        if not isinstance(self.value, (bool, int, float)):
            raise self.fail("true or false is expected")
        return bool(self.value)

    def number(self) -> float:
        """One finite number."""
        if isinstance(self.value, (list, dict)):
            raise self.fail("one number is expected")
        return float(self.array(()))

    def whole(self) -> int:
        """One whole number, 0 to 2^28."""
        value = self.number()
        if value != int(value) or not 0 <= value <= 2**28:
            raise self.fail(f"a whole number is expected, not {value:g}")
        return int(value)

    def array(self, shape: tuple[int, ...] | None = None) -> Array:
        """Finite numbers of `shape`, given so, or all in one row or column. None: any count
        of them, as a vector. A matrix of OpenCV (rows, cols, data) is taken too."""
        value, count = self.value, None
        if isinstance(value, dict) and "data" in value:
            count = (self["rows"].whole(), self["cols"].whole())
            value = value["data"]
        if isinstance(value, np.ndarray):
            value = value.tolist()
        self._check_leaves(value)
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise self.fail("numbers in equal rows are expected") from None
        if not np.isfinite(array).all():
            raise self.fail("a number is NaN or infinite")
        if count is not None:
            if array.size != count[0] * count[1]:
                raise self.fail(f"{array.size} numbers, but rows x cols is {count}")
            array = array.reshape(count)
        if shape is None:
            return array.ravel()
        is_list = array.ndim < 2 or 1 in array.shape
        if array.size != int(np.prod(shape)) or not (is_list or array.shape == shape):
            raise self.fail(f"shape {shape} is expected, not {array.shape}")
        return array.reshape(shape)

    def _check_leaves(self, value: Any) -> None:
        try:
            for i, leaf in enumerate(flatten(value)):
                if isinstance(leaf, bool) or not isinstance(leaf, (int, float, str)):
                    raise self.fail("numbers are expected")
                if i >= NUMBERS_MAX:
                    raise self.fail("too many numbers")
        except RecursionError:
            raise self.fail("nested too deeply") from None
