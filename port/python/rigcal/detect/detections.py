"""What cameras saw of a target: the table that `rigcal.calibrate` takes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from .. import _tables
from ..errors import FileError
from .targets import Target

__all__ = ["Detections"]

# Where a picture is: its path, a video with the number of the picture in it, or itself.
Picture = Union[str, tuple[str, int], npt.NDArray[Any]]
COLUMNS = (*_tables.OBSERVATIONS, "sigma_px")
FLOATS = COLUMNS[3:]


@dataclass(eq=False)
class Detections:
    """Points of a target that cameras saw: columns as arrays, a row a point.

    frame, camera, point  names, arrays of text
    X, Y, Z   the point on the target
    u, v      its pixel; (0, 0) is the centre of the top-left pixel
    sigma_px  noise of one coordinate, of one row to another: 1 is that of a common corner
    target    what was looked for
    sizes     {camera: (width, height)}
    times     {(frame, camera): seconds}, or None: when each picture was taken
    images    {(camera, frame): path, (video, number) or array}: every picture that was
              looked at; `rigcal.detect.read_picture` reads one
    warnings  what is odd about the pictures
    turned    of each row, the point that it is when a target that looks the same from
              several sides is read from its next one; None: `target` tells

    d["u"] is a column too, so that pandas.DataFrame(dict(d)) is a data frame. len(d) is the
    number of rows.
    """

    frame: npt.NDArray[Any]
    camera: npt.NDArray[Any]
    point: npt.NDArray[Any]
    X: npt.NDArray[np.float64]
    Y: npt.NDArray[np.float64]
    Z: npt.NDArray[np.float64]
    u: npt.NDArray[np.float64]
    v: npt.NDArray[np.float64]
    sigma_px: npt.NDArray[np.float64]
    target: Target | None = None
    sizes: dict[str, tuple[int, int]] = field(default_factory=dict)
    times: dict[tuple[str, str], float] | None = None
    images: dict[tuple[str, str], Picture] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    turned: npt.NDArray[Any] | None = None

    columns = COLUMNS

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name not in COLUMNS:
            raise KeyError(name)
        column: npt.NDArray[Any] = getattr(self, name)
        return column

    def keys(self) -> tuple[str, ...]:
        """Names of the columns."""
        return COLUMNS

    def __iter__(self) -> Iterator[str]:
        return iter(COLUMNS)

    def __len__(self) -> int:
        return len(self.u)

    def __repr__(self) -> str:
        return f"Detections({len(self)} points, {len(self.views)} views, {self.cameras})"

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras that saw a point, in the order of the sources."""
        seen = set(self.camera.tolist())
        return [name for name in self.sizes if name in seen] or sorted(seen)

    @property
    def frames(self) -> list[str]:
        """Names of the frames in which a point was seen, in their order."""
        return list(dict.fromkeys(self.frame.tolist()))

    @property
    def views(self) -> dict[tuple[str, str], npt.NDArray[np.int64]]:
        """{(camera, frame): rows}."""
        rows: dict[tuple[str, str], list[int]] = {}
        for k, key in enumerate(zip(self.camera.tolist(), self.frame.tolist())):
            rows.setdefault(key, []).append(k)
        return {key: np.array(which) for key, which in rows.items()}

    def table(self) -> dict[str, Any]:
        """All columns; turned too, of a target that looks the same from several sides."""
        table: dict[str, Any] = {name: self[name] for name in COLUMNS}
        symmetry = self.target.symmetry if self.target is not None else []
        if self.target is not None and symmetry:
            names = list(self.target.points)
            after = {name: names[k] for name, k in zip(names, symmetry[0])}
            table["turned"] = np.array([after[name] for name in self.point.tolist()])
        elif self.target is None and self.turned is not None:
            table["turned"] = self.turned
        return table

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a CSV file that `rigcal calibrate --observations` reads."""
        try:
            _tables.write(path, self.table())  # type: ignore[arg-type]
        except OSError as problem:
            raise FileError(path, problem.strerror or str(problem)) from None

    def save_times(self, path: str | os.PathLike[str]) -> None:
        """Writes a CSV file that `rigcal calibrate --times` reads."""
        rows = [(*key, time) for key, time in (self.times or {}).items()]
        table = {
            name: [str(row[k]) for row in rows] for k, name in enumerate(_tables.TIMES)
        }
        try:
            _tables.write(path, table)  # type: ignore[arg-type]
        except OSError as problem:
            raise FileError(path, problem.strerror or str(problem)) from None

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Detections:
        """Reads a file of `save`, or any with frame, camera, point, X, Y, Z, u, v."""
        table: dict[str, Any] = dict(_tables.read(_tables.must_exist(path)))  # type: ignore[arg-type]
        for name in FLOATS:
            if name in table:
                table[name] = np.array([float(x) for x in table[name]])
        found: dict[str, Any] = _tables.columns(
            table, _tables.OBSERVATIONS, os.fspath(path)
        )
        sigma = table.get("sigma_px", np.ones(len(found["u"])))
        turned = np.array(table["turned"]) if "turned" in table else None
        return cls(**found, sigma_px=sigma, turned=turned)
