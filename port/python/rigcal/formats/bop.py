"""BOP's scene_camera.json: images by number, cam_K, and cam_from_world in millimetres.

The images are taken to be without distortion, and the file has no image size. Lengths are
turned into metres."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ..camera import Camera
from ..errors import Error
from ._common import LAYOUTS, Document, Files, Options, each, read_layout, write_layout
from ._node import Node
from ._text import dump_json

LAYOUT = LAYOUTS["bop"]
MILLIMETRE = 0.001  # scale, where none is given
KEPT = ("depth_scale",)


def claims(node: Node) -> bool:
    return isinstance(node.value, dict) and any(
        isinstance(part, dict) and LAYOUT.matrix in part for part in node.value.values()
    )


def _read(document: Document, options: Options) -> list[Camera]:
    cameras = []
    for number, part in document.node.mapping().items():
        name = part["name"].text() if "name" in part else number
        extra = part.plain(KEPT)
        cameras.append(read_layout(part, LAYOUT, name, "brown", options.scale, extra))
    return cameras


read = each(_read)


def write(cameras: Sequence[Camera], options: Options) -> Files:
    """Only cameras without distortion. A name that is no number goes into `name`."""
    values: dict[str, Any] = {}
    are_numbers = all(re.fullmatch(r"0|[1-9]\d{0,8}", c.name) for c in cameras)
    for i, camera in enumerate(cameras):
        if any(camera.dist) or camera.lens != "brown":
            raise Error(f"{camera.name}: this format has no distortion, and it has one")
        parts = write_layout(camera, LAYOUT, options.scale, vector=False)
        for key in (LAYOUT.matrix, LAYOUT.rotation):
            if key in parts:
                parts[key] = [value for row in parts[key] for value in row]
        if not are_numbers:
            parts["name"] = camera.name
        parts["depth_scale"] = camera.extra.get("depth_scale", 1.0)
        values[camera.name if are_numbers else str(i)] = parts
    return {"": dump_json(values)}
