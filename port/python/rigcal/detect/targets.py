"""Calibration targets that a detector finds: where each of their points is.

Every target has its own frame, in which z is 0, and a `front`: the unit vector that points
out of the side that is printed, towards who reads it.

  Charuco, Chessboard   x along the columns, y along the rows, z into the board, as OpenCV
                        has it: the front is (0, 0, -1)
  AprilGrid, Tag, Tags  x to the right and y up as it is read, z towards who reads it, as
                        Kalibr's grid and rigcal_tag_solve have it: the front is (0, 0, 1)
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ..errors import Error
from ..formats.target import Target as KalibrTarget
from ..transform import Array, Transform, numbers

__all__ = ["AprilGrid", "Charuco", "Chessboard", "Tag", "Tags", "Target"]

INTO = (0.0, 0.0, -1.0)  # the front of a board whose z axis goes into it
OUT_OF = (0.0, 0.0, 1.0)  # and of one whose z axis comes out of it
COUNT_MAX = 1000  # squares, corners or tags along one side
CORNERS = ((-1, 1), (1, 1), (1, -1), (-1, -1))  # of a tag: from the top left, clockwise


def _count(value: Any, name: str, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise Error(f"{name}: a whole number is expected, not {value!r}")
    if not least <= value <= COUNT_MAX:
        raise Error(f"{name}: {least} to {COUNT_MAX} are expected, not {value}")


def _length(value: Any, name: str) -> None:
    if not 0 < float(numbers(value, (), name)) < np.inf:
        raise Error(f"{name}: a length above 0 is expected, not {value!r}")


def _grid(columns: int, rows: int, first: float, step: float) -> Array:
    """(rows * columns, 3), row by row."""
    y, x = np.mgrid[:rows, :columns].reshape(2, -1)
    return np.column_stack([first + step * x, first + step * y, np.zeros(x.size)])


def _tag_corners(size: float) -> Array:
    """(4, 3) of a tag about its middle: top left, top right, bottom right, bottom left."""
    return np.column_stack([np.array(CORNERS) * size / 2, np.zeros(4)])


@dataclass(frozen=True)
class Chessboard:
    """A chessboard of `columns` x `rows` inner corners, `square` apart.

    Point k is in column k % columns and row k // columns; x along the columns, y along the
    rows, z into the board. Corner 0 is the one beside a corner of the board whose square is
    dark (light, where inverted), so that both ends of a board of an even and an odd number
    of corners are told apart. A board whose two numbers are both even or both odd looks the
    same from its other end, and one of n x n corners, n even, from all four sides: see
    `symmetry`.
    """

    columns: int
    rows: int
    square: float
    inverted: bool = False

    front = INTO
    kind = "chessboard"

    def __post_init__(self) -> None:
        _count(self.columns, "columns", 3)
        _count(self.rows, "rows", 3)
        _length(self.square, "square")

    @property
    def points(self) -> dict[str, Array]:
        """X, Y, Z by the name of the point."""
        grid = _grid(self.columns, self.rows, 0.0, self.square)
        return {str(k): X for k, X in enumerate(grid)}

    @property
    def symmetry(self) -> list[list[int]]:
        """Permutations, the identity left out: what is read as point k is point p[k]."""
        if (self.columns + self.rows) % 2:
            return []
        number = np.arange(self.columns * self.rows).reshape(self.rows, self.columns)
        if self.columns == self.rows and self.columns % 2 == 0:
            turned = [np.rot90(number, k) for k in (1, 2, 3)]
        else:
            turned = [np.rot90(number, 2)]
        return [t.ravel().tolist() for t in turned]

    def __str__(self) -> str:
        return f"a chessboard of {self.columns} x {self.rows} inner corners"


@dataclass(frozen=True)
class Charuco:
    """A ChArUco board of `columns` x `rows` squares, with a marker in each light one.

    square, marker  their edges, in one unit
    dictionary  of OpenCV, "4X4_1000" or "DICT_4X4_1000"
    legacy      the pattern of OpenCV before 4.6, which begins with a light square where the
                number of rows is even
    inverted    markers and squares are light where they should be dark

    Point k is OpenCV's corner of that number: the inner corners row by row; x along the
    columns, y along the rows, z into the board; the origin is the corner of the board.
    """

    columns: int
    rows: int
    square: float
    marker: float
    dictionary: str = "4X4_1000"
    legacy: bool = False
    inverted: bool = False

    front = INTO
    kind = "charuco"

    def __post_init__(self) -> None:
        _count(self.columns, "columns", 2)
        _count(self.rows, "rows", 2)
        _length(self.square, "square")
        _length(self.marker, "marker")
        if not self.marker < self.square:
            raise Error(
                f"marker: less than the square, {self.square:g}, is expected, not "
                f"{self.marker:g}"
            )

    @property
    def points(self) -> dict[str, Array]:
        """X, Y, Z by the name of the point."""
        grid = _grid(self.columns - 1, self.rows - 1, self.square, self.square)
        return {str(k): X for k, X in enumerate(grid)}

    @property
    def symmetry(self) -> list[list[int]]:
        """There is none: markers tell the corners apart."""
        return []

    def __str__(self) -> str:
        return f"a ChArUco board of {self.columns} x {self.rows} squares"


@dataclass(frozen=True)
class AprilGrid:
    """Kalibr's grid of `columns` x `rows` tags.

    tag      edge of a tag; spacing: the gap between two over `tag`, a ratio, as Kalibr's
             tagSpacing
    family   of AprilTag ("tag36h11"), or a dictionary of OpenCV ("4X4_50")
    first    number of the tag at the bottom left; they rise to the right, and row by row
             upwards

    Points are "tag_corner": corner 0 to 3 from the tag's top left, clockwise. x right, y
    up, z towards who reads it; the origin is the bottom left corner of the first tag.
    """

    columns: int
    rows: int
    tag: float
    spacing: float
    family: str = "tag36h11"
    first: int = 0

    front = OUT_OF
    kind = "aprilgrid"

    def __post_init__(self) -> None:
        _count(self.columns, "columns", 1)
        _count(self.rows, "rows", 1)
        _length(self.tag, "tag")
        _length(self.spacing, "spacing")

    @property
    def tags(self) -> dict[int, Array]:
        """The four corners of each tag by its number."""
        grid = KalibrTarget("aprilgrid", self.columns, self.rows, self.tag, self.spacing)
        return {self.first + k: grid.corners(k) for k in range(self.columns * self.rows)}

    @property
    def points(self) -> dict[str, Array]:
        """X, Y, Z by the name of the point."""
        return _points_of(self.tags)

    @property
    def symmetry(self) -> list[list[int]]:
        """There is none: tags have numbers."""
        return []

    def __str__(self) -> str:
        return f"a grid of {self.columns} x {self.rows} tags of {self.family}"


@dataclass(frozen=True)
class Tag:
    """One square tag of edge `size`.

    id      its number; None: the one that is seen
    family  of AprilTag ("tag36h11"), or a dictionary of OpenCV ("4X4_50")

    Points are "id_corner": corner 0 to 3 from the top left, clockwise, as rigcal_tag_solve
    has them; the origin is the middle, x right, y up, z towards who reads it.
    """

    size: float
    id: int | None = None
    family: str = "tag36h11"

    front = OUT_OF
    kind = "tag"

    def __post_init__(self) -> None:
        _length(self.size, "size")
        if self.id is not None and not (isinstance(self.id, int) and self.id >= 0):
            raise Error(f"id: a number of a tag is expected, not {self.id!r}")

    @property
    def tags(self) -> dict[int, Array]:
        """The four corners of each tag by its number; of none, if it is not known."""
        return {} if self.id is None else {self.id: _tag_corners(self.size)}

    @property
    def points(self) -> dict[str, Array]:
        """X, Y, Z by the name of the point."""
        return _points_of(self.tags)

    @property
    def symmetry(self) -> list[list[int]]:
        """There is none: a tag says which of its corners is which."""
        return []

    def __str__(self) -> str:
        which = "a tag" if self.id is None else f"tag {self.id}"
        return f"{which} of {self.family}"


@dataclass(frozen=True)
class Tags:
    """Tags that are fixed to one body, by number.

    where   {id: (4, 3) corners} from the top left, clockwise as the tag is read; or
            {id: Transform}, body_from_tag of a tag of edge `size`
    size    edge of the tags that are given by a Transform
    family  of AprilTag ("tag36h11"), or a dictionary of OpenCV ("4X4_50")

    Points are "id_corner". There is no front where the tags look to several sides.
    """

    where: Mapping[int, Any]
    size: float | None = None
    family: str = "tag36h11"
    tags: dict[int, Array] = field(init=False, repr=False, compare=False)

    front = None
    kind = "tags"

    def __post_init__(self) -> None:
        tags: dict[int, Array] = {}
        if not isinstance(self.where, Mapping):
            raise Error(f"where: tags by number, not {type(self.where).__name__}")
        for number, given in self.where.items():
            name = f"tag {number}"
            if not isinstance(number, (int, np.integer)) or number < 0:
                raise Error(f"where: a tag's number is expected, not {number!r}")
            if isinstance(given, Transform):
                if self.size is None:
                    raise Error(f"{name}: size, the edge of a tag, is needed with its pose")
                _length(self.size, "size")
                tags[int(number)] = _tag_corners(self.size) @ given.R.T + given.t
            else:
                tags[int(number)] = numbers(given, (4, 3), name)
        if not tags:
            raise Error("where: there is no tag")
        object.__setattr__(self, "tags", tags)

    @property
    def points(self) -> dict[str, Array]:
        """X, Y, Z by the name of the point."""
        return _points_of(self.tags)

    @property
    def symmetry(self) -> list[list[int]]:
        """There is none: tags have numbers."""
        return []

    def __str__(self) -> str:
        return f"{len(self.tags)} tags of {self.family}"


def _points_of(tags: Mapping[int, npt.NDArray[np.float64]]) -> dict[str, Array]:
    corners = itertools.product(tags.items(), range(4))
    return {f"{number}_{k}": tag[k] for (number, tag), k in corners}


Target = Union[AprilGrid, Charuco, Chessboard, Tag, Tags]
