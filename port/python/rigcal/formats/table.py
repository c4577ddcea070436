"""cameras.csv and rig.csv, as the program `rigcal` reads and writes them.

cameras.csv has intrinsics alone. Poses are in rig.csv: a folder with both, or a list of
both paths, is read and written together. Lengths are in the caller's unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..camera import BROWN, Camera
from ..errors import Error
from ..transform import Transform
from ._common import (
    Document,
    Files,
    Options,
    blame,
    make,
    nearest,
    need_size,
    place,
    shortest,
)
from ._node import Node
from ._text import decode

INTRINSICS = ("camera", "width", "height", "fx", "fy", "cx", "cy")
POSE = (*[f"R{i}{j}" for i in "123" for j in "123"], "tx", "ty", "tz")
CAMERAS, RIG = "cameras.csv", "rig.csv"


def header(text: str) -> list[str]:
    """The names of the columns, in the first line."""
    return [name.strip() for name in text.lstrip().split("\n")[0].split(",")]


def is_cameras(columns: Sequence[str]) -> bool:
    return {"camera", "fx", "fy"} <= set(columns)


def is_rig(columns: Sequence[str]) -> bool:
    return {"camera", "R11", "tx"} <= set(columns)


def _rows(text: str) -> list[Node]:
    """A node a line: values by the names of columns."""
    columns: list[str] | None = None
    rows = []
    for number, line in enumerate(text.split("\n"), 1):
        if not line.strip():
            continue
        fields = [field.strip() for field in line.split(",")]
        place_of = Node(None, f"line {number}")
        if columns is None:
            columns = fields
            if len(set(columns)) < len(columns):
                raise place_of.fail("a column is there twice")
        elif len(fields) != len(columns):
            raise place_of.fail(f"{len(fields)} fields where the header has {len(columns)}")
        else:
            rows.append(Node(dict(zip(columns, fields)), place_of.where))
    if not rows:
        raise Error("there are no data lines")
    return rows


def _by_name(rows: Sequence[Node]) -> dict[str, Node]:
    named: dict[str, Node] = {}
    for row in rows:
        name = row["camera"].text()
        if name in named:
            raise row.fail(f"camera {name} is there twice")
        if not re.fullmatch(r"[^\s,\"']+", name):
            raise row.fail(f"camera {name!r}: an id has no blanks, commas and quotes")
        named[name] = row
    return named


def read(documents: Sequence[Document], options: Options) -> list[Camera]:
    """Of cameras.csv and, where it is given, rig.csv."""
    cameras: dict[str, Camera] | None = None
    poses: dict[str, Transform] = {}
    for document in documents:
        with blame(document.path):
            rows = _by_name(_rows(decode(document.data)))
            if is_rig(header(decode(document.data))):
                poses.update({n: _pose(row, n, options) for n, row in rows.items()})
            else:
                cameras = {**(cameras or {}), **{n: _camera(r, n) for n, r in rows.items()}}
    if cameras is None:
        with blame(documents[0].path):
            raise Error("poses alone are no cameras: give cameras.csv too, [cameras, rig]")
    return [replace(c, cam_from_rig=poses.get(name)) for name, c in cameras.items()]


def _camera(row: Node, name: str) -> Camera:
    lens = row["lens"].text() if "lens" in row else "brown"
    values = {k: row[k].number() if k in row else 0.0 for k in BROWN}
    if lens == "fisheye":
        if any(values[key] for key in ("p1", "p2", "k5", "k6")):
            raise row.fail("a fisheye has k1 to k4 alone: p1, p2, k5 and k6 must be 0")
        dist = [values[key] for key in ("k1", "k2", "k3", "k4")]
    else:
        dist = shortest(list(values.values()))
    fields = {"dist": dist, "lens": lens, "name": name}
    size = np.array([row["width"].number(), row["height"].number()])
    K = np.array([row[key].number() for key in ("fx", "fy", "cx", "cy")])
    return make(row, K, size=size, **fields)


def _pose(row: Node, name: str, options: Options) -> Transform:
    values = np.array([row[key].number() for key in POSE])
    with place(row):
        R = nearest(values[:9].reshape(3, 3), row)
        return Transform(R, values[9:] * options.scale, name, "rig")


def write(cameras: Sequence[Camera], options: Options, kind: str = "csv") -> Files:
    """cameras.csv; and rig.csv when `kind` is "folder" and poses are known."""
    lines = [",".join([*INTRINSICS, *BROWN, "lens"])]
    poses = [",".join(["camera", *POSE])]
    for camera in cameras:
        if not re.fullmatch(r"[^\s,\"']+", camera.name):
            raise Error(f"{camera.name!r}: an id has no blanks, commas and quotes")
        values = [camera.fx, camera.fy, camera.cx, camera.cy, *camera.coefficients.values()]
        words = [camera.name, *map(str, need_size(camera)), *map(repr, values)]
        lines.append(",".join([*words, camera.lens]))
        T = camera.cam_from_rig
        if T is not None:
            numbers = [*T.R.ravel().tolist(), *(T.t / options.scale).tolist()]
            poses.append(",".join([camera.name, *map(repr, numbers)]))
    text = "\n".join(lines) + "\n"
    if kind != "folder":
        return {"": text}
    return {CAMERAS: text, **({RIG: "\n".join(poses) + "\n"} if len(poses) > 1 else {})}
