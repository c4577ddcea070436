"""nerfstudio's transforms.json. The scale is free.

transform_matrix is world from camera, with OpenGL's axes: y up, z backwards. Pixels count
from the corner of the image, so the centre of the first one is (0.5, 0.5). Intrinsics stand
at the top or in each frame. Each frame is a camera, and the rig is the world of the file:
an `applied_transform` is kept in `extra` and not undone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..camera import Camera
from ..errors import Error
from ._common import (
    Document,
    Files,
    Options,
    each,
    make,
    need_pose,
    need_size,
    refuse,
    rigid,
)
from ._node import Node
from ._text import dump_json

MODELS = {
    "OPENCV": "brown",
    "PINHOLE": "brown",
    "SIMPLE_PINHOLE": "brown",
    "PERSPECTIVE": "brown",
    "OPENCV_FISHEYE": "fisheye",
}
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
CORNER = 0.5  # px: the first pixel's centre
KEPT = ("file_path", "applied_transform", "applied_scale")
COEFFICIENTS = {
    "brown": ("k1", "k2", "p1", "p2", "k3"),
    "fisheye": ("k1", "k2", "k3", "k4"),
}


def claims(node: Node) -> bool:
    frames = node.value.get("frames") if isinstance(node.value, dict) else None
    return isinstance(frames, list) and any(
        isinstance(part, dict) and "transform_matrix" in part for part in frames
    )


def _read(document: Document, options: Options) -> list[Camera]:
    top = document.node
    frames = top["frames"].list()
    paths = [frame["file_path"].text() for frame in frames]
    stems = [_stem(path) for path in paths]
    names = stems if len(set(stems)) == len(stems) else paths
    names = [f["name"].text() if "name" in f else n for f, n in zip(frames, names)]
    return [_camera(top, f, name, options) for f, name in zip(frames, names)]


read = each(_read)


def _stem(path: str) -> str:
    return os.path.splitext(os.path.basename(path.replace("\\", "/")))[0]


def _camera(top: Node, frame: Node, name: str, options: Options) -> Camera:
    def find(key: str) -> Node:
        return frame[key] if key in frame or key not in top else top[key]

    def coefficient(key: str) -> float:
        return find(key).number() if key in frame or key in top else 0.0

    model = (
        find("camera_model") if "camera_model" in frame or "camera_model" in top else None
    )
    if model is not None and model.text() not in MODELS:
        raise refuse(model, model.text(), MODELS)
    lens = "brown" if model is None else MODELS[model.text()]
    for key in ("k4", "k5", "k6") if lens == "brown" else ("p1", "p2"):
        if coefficient(key) != 0:
            raise find(key).fail(f"this model has no {key}, so it must be 0")
    dist = [coefficient(key) for key in COEFFICIENTS[lens]]
    fx, fy, cx, cy = (find(key).number() for key in ("fl_x", "fl_y", "cx", "cy"))
    world_from_gl = rigid(frame["transform_matrix"], "rig", name, options.scale)
    M = world_from_gl.matrix @ FLIP
    return make(
        frame,
        np.array([fx, fy, cx - CORNER, cy - CORNER]),
        dist=dist if any(dist) or lens == "fisheye" else (),
        size=(find("w").number(), find("h").number()),
        lens=lens,
        name=name,
        cam_from_rig=type(world_from_gl).from_matrix(M, "rig", name).inv(),
        extra={**top.plain(KEPT), **frame.plain(KEPT)},
    )


def write(cameras: Sequence[Camera], options: Options) -> Files:
    """A frame a camera, with its intrinsics. Its file_path is images/NAME.png, if none is
    known."""
    lenses = {camera.lens for camera in cameras}
    if len(lenses) > 1:
        raise Error("this format has one lens model for all cameras")
    lens = lenses.pop()
    values: dict[str, Any] = {
        "camera_model": "OPENCV_FISHEYE" if lens == "fisheye" else "OPENCV",
    }
    for key in KEPT[1:]:
        if key in cameras[0].extra:
            values[key] = cameras[0].extra[key]
    values["frames"] = []
    for camera in cameras:
        width, height = need_size(camera)
        if any(camera.dist[5:]):
            raise Error(f"{camera.name}: this format has no k4 to k6, and they are not 0")
        M = need_pose(camera).inv().matrix @ FLIP
        M[:3, 3] /= options.scale
        path = camera.extra.get("file_path", f"images/{camera.name}.png")
        values["frames"].append(
            {
                "file_path": path,
                **({} if _stem(path) == camera.name else {"name": camera.name}),
                "fl_x": camera.fx,
                "fl_y": camera.fy,
                "cx": camera.cx + CORNER,
                "cy": camera.cy + CORNER,
                "w": width,
                "h": height,
                **dict(zip(COEFFICIENTS[lens], camera.dist)),
                "transform_matrix": M.tolist(),
            }
        )
    return {"": dump_json(values)}
