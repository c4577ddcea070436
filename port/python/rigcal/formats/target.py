"""Calibration targets of Kalibr. Metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import Error, path_of
from ..transform import Array
from ._common import PathLike, blame, read_file, write_file
from ._node import Node
from ._text import decode, dump_yaml, parse_yaml

# Keys of each kind: columns, rows, size, spacing.
KEYS = {
    "aprilgrid": ("tagCols", "tagRows", "tagSize", "tagSpacing"),
    "checkerboard": ("targetCols", "targetRows", "colSpacingMeters", "rowSpacingMeters"),
    "circlegrid": ("targetCols", "targetRows", "spacingMeters", ""),
}
COUNT_MAX = 1000  # tags, corners or circles along one side


@dataclass(frozen=True)
class Target:
    """A calibration target, z = 0, as Kalibr lays it out.

    kind           "aprilgrid", "checkerboard" or "circlegrid"
    cols, rows     how many tags, inner corners or circles
    size           edge of a tag; distance of two columns of corners; of circles
    spacing        gap between tags over `size` (a ratio); distance of two rows of
                   corners; 0 for circles
    is_asymmetric  of circles: every second row is shifted
    """

    kind: str
    cols: int
    rows: int
    size: float
    spacing: float = 0.0
    is_asymmetric: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KEYS:
            raise Error(f"kind: one of {', '.join(KEYS)} is expected, not {self.kind!r}")
        for side in (self.cols, self.rows):
            if not (isinstance(side, int) and 1 <= side <= COUNT_MAX):
                raise Error(f"cols, rows: 1 to {COUNT_MAX} are expected, not {side!r}")
        needs = self.kind != "circlegrid"
        if not 0 < self.size < np.inf or not (0 < self.spacing < np.inf or not needs):
            raise Error("size, spacing: lengths above 0 are expected")

    @property
    def points(self) -> Array:
        """(N, 3) in Kalibr's order, row by row: 2 x 2 corners of each tag; corners;
        circles. Of corners and of a symmetric grid x is along the rows, as in Kalibr."""
        corners = 2 if self.kind == "aprilgrid" else 1
        r, c = np.mgrid[: corners * self.rows, : corners * self.cols].reshape(2, -1)
        if self.kind == "aprilgrid":
            x, y = ((i // 2) * (1 + self.spacing) + i % 2 for i in (c, r))
            xy = self.size * np.column_stack([x, y])
        elif self.kind == "checkerboard":
            xy = np.column_stack([self.spacing * r, self.size * c])
        elif self.is_asymmetric:
            xy = self.size * np.column_stack([2 * c + r % 2, r])
        else:
            xy = self.size * np.column_stack([r, c])
        return np.column_stack([xy, np.zeros(len(xy))])

    def corners(self, tag: int) -> Array:
        """(4, 3) of a tag of an aprilgrid: top left, top right, bottom right, bottom left,
        the order of rigcal_tag_solve. Tag 0 is at the bottom left; x right, y up."""
        if self.kind != "aprilgrid" or not 0 <= tag < self.rows * self.cols:
            raise Error(f"tag {tag} is not on this target")
        row, col = divmod(tag, self.cols)
        first = 2 * row * 2 * self.cols + 2 * col  # bottom left, of `points`
        above = first + 2 * self.cols
        corners: Array = self.points[[above, above + 1, first + 1, first]]
        return corners


def load_target(path: PathLike) -> Target:
    """An aprilgrid, checkerboard or circlegrid, from Kalibr's YAML."""
    path = path_of(path)
    with blame(path):
        node = Node(parse_yaml(decode(read_file(path))))
        kind = node["target_type"].text()
        if kind not in KEYS:
            raise node["target_type"].fail(f"one of {', '.join(KEYS)} is expected")
        cols, rows, size, spacing = KEYS[kind]
        asymmetric = node.get("asymmetricGrid")
        return Target(
            kind,
            node[cols].whole(),
            node[rows].whole(),
            node[size].number(),
            node[spacing].number() if spacing else 0.0,
            asymmetric is not None and asymmetric.flag(),
        )


def save_target(path: PathLike, target: Target) -> None:
    """Writes Kalibr's YAML of a target."""
    if not isinstance(target, Target):
        raise Error(f"target: a Target is expected, not {type(target).__name__}")
    values = (target.cols, target.rows, target.size, target.spacing)
    content: dict[str, Any] = {"target_type": target.kind}
    content.update({k: v for k, v in zip(KEYS[target.kind], values) if k})
    if target.kind == "circlegrid":
        content["asymmetricGrid"] = target.is_asymmetric
    write_file(path_of(path), dump_yaml(content))
