"""Tables: columns by name from whatever holds them, and the program's own CSV."""

from __future__ import annotations

import contextlib
import csv
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .camera import Camera
from .errors import Error, FileError
from .formats import load_cameras

Path = os.PathLike[str]

OBSERVATIONS = ("frame", "camera", "point", "X", "Y", "Z", "u", "v")
TIMES = ("frame", "camera", "time_s")
IDS = ("frame", "camera", "point", "turned")
TRANSFORM = (*(f"R{i}{j}" for i in "123" for j in "123"), "tx", "ty", "tz")
COVARIANCE = tuple(f"S{i}{j}" for i in range(1, 7) for j in range(1, i + 1))

# Characters that a name in a file of the program must not have.
REFUSED = set(",\"' \t\r\n\v\f")

Column = npt.NDArray[Any]
Table = dict[str, Column]


# ---- what a caller has --------------------------------------------------------


def _shape(value: Any) -> str:
    """What it is, for messages."""
    shape = getattr(value, "shape", None)
    if shape is not None:
        return f"an array of shape {tuple(shape)} and dtype {value.dtype}"
    if isinstance(value, (Sequence, Mapping)) and not isinstance(value, (str, bytes)):
        return f"a {type(value).__name__} of {len(value)}"
    return f"a {type(value).__name__}"


def _pick(table: Any, names: Iterable[str], wanted: Sequence[str], what: str) -> Table:
    """The wanted columns of a table that has columns of these names."""
    there = [str(name) for name in names]
    missing = [name for name in wanted if name not in there]
    if missing:
        raise Error(
            f"{what}: no column {', '.join(missing)}; "
            f"{','.join(wanted)} are expected, and there are {','.join(there) or 'none'}"
        )
    return {name: _column(table[name], f"{what}[{name!r}]") for name in wanted}


def _column(values: Any, what: str) -> Column:
    """A column as an array of one dimension."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise Error(f"{what}: a row is masked. Leave out the rows of what was not seen")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        array = np.empty((0, 0))
    if array.ndim != 1:
        raise Error(f"{what}: a column is expected, not {_shape(values)}")
    return array


def _rows(rows: Sequence[Any], wanted: Sequence[str], what: str) -> Table:
    """Rows may be mappings, objects with fields of these names, or in the wanted order."""
    columns: list[list[Any]] = [[] for _ in wanted]
    for k, row in enumerate(rows):
        fields: Any = row if isinstance(row, Mapping) else getattr(row, "_fields", None)
        values: Any = row
        if fields is not None:
            missing = [name for name in wanted if name not in fields]
            if missing:
                raise Error(f"{what}[{k}]: no field {', '.join(missing)}")
            values = [
                row[name] if isinstance(row, Mapping) else getattr(row, name)
                for name in wanted
            ]
        if isinstance(values, (str, bytes)) or not isinstance(
            values, (Sequence, np.ndarray)
        ):
            raise Error(f"{what}[{k}]: a row is expected, not {_shape(row)}")
        if len(values) != len(wanted):
            raise Error(
                f"{what}[{k}]: {len(wanted)} values, {','.join(wanted)}, are expected, "
                f"not {len(values)}"
            )
        for column, value in zip(columns, values):
            column.append(value)
    table: Table = {}
    for name, column in zip(wanted, columns):
        table[name] = np.empty(len(column), dtype=object)
        table[name][:] = column
    return table


def names_of(table: Any) -> Iterable[str] | None:
    """Names of the columns of a table that has names; None of one that has none."""
    names: Any = getattr(getattr(table, "dtype", None), "names", None)
    if names is None and not isinstance(table, np.ndarray):
        names = getattr(table, "column_names", getattr(table, "columns", None))
    if names is None and isinstance(table, Mapping):
        names = table.keys()
    found: Iterable[str] | None = names
    return found


def columns(table: Any, wanted: Sequence[str], what: str) -> Table:
    """The wanted columns of a table: ids as text, numbers as float64, all of one length.

    table: a mapping of columns, a data frame (pandas, polars, Arrow), a structured array,
    an array (n, len(wanted)), or a sequence of rows.
    """
    names = names_of(table)
    if names is not None:
        found = _pick(table, names, wanted, what)
    elif isinstance(table, np.ndarray):
        if table.ndim != 2 or table.shape[1] != len(wanted):
            raise Error(
                f"{what}: shape (n, {len(wanted)}), {','.join(wanted)}, is expected, "
                f"not {_shape(table)}"
            )
        found = {name: table[:, k] for k, name in enumerate(wanted)}
    elif isinstance(table, Iterable) and not isinstance(table, (str, bytes)):
        found = _rows(list(table), wanted, what)
    else:
        raise Error(
            f"{what}: a data frame, a dict of columns, a structured array, rows, or the "
            f"path of a CSV file is expected, not {_shape(table)}"
        )
    lengths = {name: len(column) for name, column in found.items()}
    if len(set(lengths.values())) > 1:
        raise Error(f"{what}: columns of one length are expected, not {lengths}")
    if not lengths[wanted[0]]:
        raise Error(f"{what}: there is no row in it")
    return {
        name: (ids if name in IDS else reals)(column, f"{what}[{name!r}]")
        for name, column in found.items()
    }


def _id(value: Any) -> str | None:
    """The text of an id; None: it is no id. 3.0 is "3", because a column with a gap is
    real."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "surrogateescape")
    if isinstance(value, (float, np.floating)):
        return str(int(value)) if np.isfinite(value) and value == int(value) else None
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (str, int, np.integer)):
        return None
    return str(value)


def ids(values: Column, what: str) -> Column:
    """Names as text. Whole numbers may be names."""
    different: list[str] = []
    place: list[int] = []
    number: dict[Any, int] = {}
    for row, value in enumerate(values.tolist()):
        try:
            known = number.get(value)
        except TypeError:
            raise Error(
                f"{what}, row {row}: a name is expected, not {_shape(value)}"
            ) from None
        if known is None:
            text = _id(value)
            if text is None:
                raise Error(f"{what}, row {row}: a name is expected, not {value!r}")
            check_name(text, f"{what}, row {row}")
            known = number[value] = len(different)
            different.append(text)
        place.append(known)
    named: Column = np.array(different, dtype=str)[place]
    return named


def check_name(name: str, what: str) -> None:
    """Error unless the program can write the name into its files."""
    if not name or REFUSED & set(name):
        raise Error(
            f"{what}: a name without commas, blanks and quotes is expected, not {name!r}"
        )
    if name.isprintable():
        return
    if any(ord(c) < ord(" ") or c == "\x7f" for c in name):
        raise Error(f"{what}: a name without control characters is expected, not {name!r}")


def reals(values: Column, what: str) -> Column:
    """Finite numbers as float64."""
    if values.dtype.kind not in "fiuO":
        raise Error(f"{what}: numbers are expected, not {_shape(values)}")
    try:
        numbers = values.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise Error(f"{what}: numbers are expected, not {_shape(values)}") from None
    bad = np.flatnonzero(~np.isfinite(numbers))
    if bad.size:
        raise Error(
            f"{what}, row {bad[0]}: {numbers[bad[0]]} is no number. Leave out the rows of "
            "what was not seen"
        )
    return numbers


# ---- the program's files ------------------------------------------------------


def write(path: Path, table: Mapping[str, Sequence[Any]]) -> None:
    """A CSV file of the program, all digits of a number."""
    texts = [
        column
        if isinstance(column, list)
        else [str(x) for x in np.asarray(column).tolist()]
        for column in table.values()
    ]
    with open(path, "w", encoding="utf-8", errors="surrogateescape", newline="\n") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*texts))


def read(path: Path) -> dict[str, list[str]]:
    """A CSV file that the program wrote: its columns."""
    try:
        with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
            head, *rows = list(csv.reader(file))
    except OSError as problem:
        raise FileError(path, str(problem.strerror)) from None
    except (ValueError, csv.Error):
        raise FileError(path, "this is no table") from None
    for k, row in enumerate(rows):
        if len(row) != len(head):
            raise FileError(path, f"row {k} has {len(row)} values, not {len(head)}")
    return {name: [row[k] for row in rows] for k, name in enumerate(head)}


def numbers_of(texts: Sequence[str]) -> Column:
    """float64 of a column, NaN where it is empty: not known."""
    return np.array([float(text) if text else np.nan for text in texts], dtype=np.float64)


def transforms(table: Mapping[str, Sequence[str]]) -> list[tuple[Column, Column]]:
    """R (3, 3) and t (3,) of each row."""
    both = np.array([numbers_of(table[name]) for name in TRANSFORM]).T
    return [(row[:9].reshape(3, 3), row[9:]) for row in both]


def is_own(path: Any) -> bool:
    """Whether it is a CSV file with a column camera: one of the program."""
    with contextlib.suppress(OSError), open(path, "rb") as file:
        words = file.read(4096).decode("utf-8-sig", "replace").split()
        return bool(words) and "camera" in words[0].split(",")
    return False


def named_cameras(cameras: Any, what: str = "cameras") -> dict[str, Camera]:
    """Cameras by name: of a mapping, of a sequence of cameras with names, of a file."""
    if isinstance(cameras, (str, os.PathLike)):
        return load_cameras(cameras)
    if isinstance(cameras, Camera):
        cameras = [cameras]
    if isinstance(cameras, Mapping):
        found = dict(cameras)
    elif isinstance(cameras, Iterable) and not isinstance(cameras, bytes):
        given = list(cameras)
        found = {getattr(c, "name", None) or f"cam{k}": c for k, c in enumerate(given)}
        if len(found) < len(given):
            raise Error(f"{what}: two cameras have the same name")
    else:
        raise Error(f"{what}: cameras by name are expected, not {_shape(cameras)}")
    for name, camera in found.items():
        if not isinstance(name, str) or not isinstance(camera, Camera):
            raise Error(f"{what}[{name!r}]: a Camera is expected, not {_shape(camera)}")
    if not found:
        raise Error(f"{what}: there is no camera")
    return found


def must_exist(path: Any) -> str:
    """The path as text; FileError if there is no such file."""
    text = os.fspath(path)
    if not os.path.isfile(text):
        raise FileError(text, "there is no such file")
    return str(text)
