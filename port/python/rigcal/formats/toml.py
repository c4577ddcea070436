"""TOML of Anipose, Pose2Sim and Caliscope, old and new: one shape, one reader.

cam_from_world, with the world as the rig. No file states its unit: Pose2Sim and Caliscope
write metres, Anipose the unit of its board, which is often millimetre. Lengths stay as they
are unless `scale` is given. The rotation is a vector or, in older files of Caliscope, a
matrix. `fisheye = true` is OpenCV's fisheye. `rotation_count` of Caliscope only turns what
its windows show: intrinsics and poses are those of the image as it was recorded. Cameras
that Caliscope has not calibrated have no matrix; those with `ignore = true` are passed
over then."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ..camera import Camera
from ..errors import Error
from ._common import LAYOUTS, Document, Files, Options, each, read_layout, write_layout
from ._node import Node
from ._text import dump_toml, toml_key

LAYOUT = LAYOUTS["toml"]
KEPT = ("rotation_count", "ignore", "error", "grid_count", "exposure")


def _sections(node: Node) -> dict[str, Node]:
    """The tables of cameras: under [cameras], or at the top."""
    cameras = node.get("cameras")
    tables = (node if cameras is None else cameras).mapping()
    return {
        name: part
        for name, part in tables.items()
        if isinstance(part.value, dict) and (cameras is not None or _is_camera(part))
    }


def _is_camera(part: Node) -> bool:
    keys = ("matrix", "distortions", "rotation", "port", "cam_id")
    return any(key in part for key in keys)


def claims_anipose(node: Node) -> bool:
    return (
        isinstance(node.value, dict)
        and not claims_caliscope(node)
        and any(_is_camera(part) for part in node.mapping().values())
    )


def claims_caliscope(node: Node) -> bool:
    return isinstance(node.value, dict) and any(
        "port" in part or "cam_id" in part for part in _sections_or_none(node).values()
    )


def _sections_or_none(node: Node) -> dict[str, Node]:
    cameras = node.get("cameras")
    return (
        {}
        if cameras is not None and not isinstance(cameras.value, dict)
        else _sections(node)
    )


def _read(document: Document, options: Options) -> list[Camera]:
    cameras = []
    for section, part in _sections(document.node).items():
        ignore = part.get("ignore")
        if "matrix" not in part and ignore is not None and ignore.flag():
            continue
        fisheye = part.get("fisheye")
        lens = "fisheye" if fisheye is not None and fisheye.flag() else "brown"
        name = part["name"].text() if "name" in part else section
        extra = {key: part[key].value for key in KEPT if key in part}
        cameras.append(read_layout(part, LAYOUT, name, lens, options.scale, extra))
    if not cameras:
        raise Error("there is no camera in the file")
    return cameras


read = each(_read)


def write_anipose(cameras: Sequence[Camera], options: Options) -> Files:
    """Sections [cam_0], [cam_1], ... and [metadata], for Anipose and Pose2Sim."""
    tables: dict[str, dict[str, Any]] = {}
    for i, camera in enumerate(cameras):
        layout = write_layout(camera, LAYOUT, options.scale)
        fisheye = camera.lens == "fisheye"
        tables[f"cam_{i}"] = {"name": camera.name, **layout, "fisheye": fisheye}
    tables["metadata"] = {"adjusted": False, "error": 0.0}
    return {"": dump_toml(tables)}


def write_caliscope(cameras: Sequence[Camera], options: Options) -> Files:
    """Sections [cameras.N]. A name that is no number goes into `name`."""
    tables: dict[str, dict[str, Any]] = {}
    are_numbers = all(re.fullmatch(r"0|[1-9]\d{0,8}", c.name) for c in cameras)
    for i, camera in enumerate(cameras):
        number = camera.name if are_numbers else str(i)
        kept = {k: camera.extra[k] for k in KEPT if k in camera.extra}
        tables[f"cameras.{toml_key(number)}"] = {
            "cam_id": int(number),
            **({} if are_numbers else {"name": camera.name}),
            "rotation_count": 0,
            "ignore": False,
            **kept,
            **write_layout(camera, LAYOUT, options.scale),
            "fisheye": camera.lens == "fisheye",
        }
    return {"": dump_toml(tables)}
