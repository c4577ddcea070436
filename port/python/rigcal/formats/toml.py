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
from ._common import LAYOUTS, Document, Files, Options, each, read_layout, write_layout
from ._node import Node
from ._text import dump_toml, toml_key

LAYOUT = LAYOUTS["toml"]
KEPT = ("rotation_count", "ignore", "error", "grid_count", "exposure")


def _sections(node: Node) -> dict[str, Node]:
    """The tables of cameras: all that are under [cameras], or at the top those that look
    like one."""
    if "cameras" in node:
        return node["cameras"].mapping()
    return {name: part for name, part in node.mapping().items() if _is_camera(part)}


def _is_camera(part: Node) -> bool:
    keys = ("matrix", "distortions", "rotation", "port", "cam_id")
    return any(key in part for key in keys)


def claims_anipose(node: Node) -> bool:
    parts = node.mapping()
    return not claims_caliscope(node) and any(map(_is_camera, parts.values()))


def claims_caliscope(node: Node) -> bool:
    held = node.get("cameras") or node
    parts = held.value.values() if isinstance(held.value, dict) else ()
    return any("port" in Node(part) or "cam_id" in Node(part) for part in parts)


def _read(document: Document, options: Options) -> list[Camera]:
    cameras = []
    for section, part in _sections(document.node).items():
        is_ignored, is_fisheye = (
            key in part and part[key].flag() for key in ("ignore", "fisheye")
        )
        if is_ignored and "matrix" not in part:
            continue
        lens = "fisheye" if is_fisheye else "brown"
        name = part["name"].text() if "name" in part else section
        extra = part.plain(KEPT)
        cameras.append(read_layout(part, LAYOUT, name, lens, options.scale, extra))
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
