"""Camchains of Kalibr. Metres.

T_cn_cnm1 takes the camera before to this one: the transforms are multiplied along the
chain. The rig is the first camera, unless it has a T_cn_cnm1 of its own, as programs other
than Kalibr write it. In a chain without T_cn_cnm1 the rig is the IMU, by T_cam_imu."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..camera import Camera
from ..transform import Transform
from ._common import (
    Document,
    Files,
    Options,
    each,
    four_of,
    make,
    need_pose,
    need_size,
    refuse,
    rigid,
)
from ._node import Node
from ._text import dump_yaml

LENSES = {"radtan": ("brown", 4), "equidistant": ("fisheye", 4), "none": ("brown", 0)}
KEPT = ("T_cam_imu", "timeshift_cam_imu", "cam_overlaps", "rostopic")


def claims(node: Node) -> bool:
    return isinstance(node.value, dict) and any(
        isinstance(part, dict) and "camera_model" in part for part in node.value.values()
    )


def _number(item: tuple[str, Node]) -> int:
    number = re.fullmatch(r"cam(\d+)", item[0])
    if number is None:
        raise item[1].fail("the cameras of a camchain are cam0, cam1, ...")
    return int(number[1])


def _read(document: Document, options: Options) -> list[Camera]:
    cams = sorted(document.node.mapping().items(), key=_number)
    names = [part["name"].text() if "name" in part else key for key, part in cams]
    poses = _poses([part for _, part in cams], names, options.scale)
    return [_camera(part, name, T) for (_, part), name, T in zip(cams, names, poses)]


read = each(_read)


def _poses(
    parts: Sequence[Node], names: Sequence[str], scale: float
) -> list[Transform | None]:
    is_chain = any("T_cn_cnm1" in part for part in parts)
    has_imu = [part.get("T_cam_imu") for part in parts]
    if not is_chain and len(parts) > 1 and any(has_imu):
        return [
            rigid(part["T_cam_imu"], name, "rig", scale) for part, name in zip(parts, names)
        ]
    if not is_chain and len(parts) > 1:
        raise parts[1].fail("T_cn_cnm1 is missing")
    poses: list[Transform | None] = []
    before = Transform.identity("rig", "rig")
    for i, (part, name) in enumerate(zip(parts, names)):
        if i == 0 and "T_cn_cnm1" not in part:
            T = Transform.identity(name, "rig")
        else:
            T = rigid(part["T_cn_cnm1"], name, before.to, scale) @ before
        poses.append(T)
        before = T
    return poses


def _camera(part: Node, name: str, T: Transform | None) -> Camera:
    model, distortion = part["camera_model"], part["distortion_model"]
    if model.text() != "pinhole":
        raise refuse(model, model.text(), ["pinhole"])
    if distortion.text() not in LENSES:
        raise refuse(distortion, distortion.text(), LENSES)
    lens, count = LENSES[distortion.text()]
    return make(
        part,
        part["intrinsics"].array((4,)),
        dist=part["distortion_coeffs"].array((count,)) if count else (),
        size=part["resolution"].array((2,)),
        lens=lens,
        name=name,
        cam_from_rig=T,
        extra=part.plain(KEPT),
    )


def write(cameras: Sequence[Camera], options: Options) -> Files:
    """A camchain. Only lenses with 4 coefficients at most fit in. The camera's own name
    goes into `name`, which Kalibr does not read."""
    chain: dict[str, Any] = {}
    before: Transform | None = None
    for i, camera in enumerate(cameras):
        kept = {k: camera.extra[k] for k in KEPT if k in camera.extra}
        values: dict[str, Any] = {
            "cam_overlaps": [k for k in range(len(cameras)) if k != i],
            "camera_model": "pinhole",
            "distortion_coeffs": four_of(camera),
            "distortion_model": "equidistant" if camera.lens == "fisheye" else "radtan",
            "intrinsics": [camera.fx, camera.fy, camera.cx, camera.cy],
            "resolution": list(need_size(camera)),
            "rostopic": f"/{camera.name}/image_raw",
            **kept,
        }
        if len(cameras) > 1 or camera.cam_from_rig is not None:
            T = need_pose(camera)
            step = T if before is None else T @ before.inv()
            if before is not None or not np.array_equal(T.matrix, np.eye(4)):
                M = step.matrix
                M[:3, 3] /= options.scale
                values["T_cn_cnm1"] = M.tolist()
            before = T
        if camera.name != f"cam{i}":
            values["name"] = camera.name
        chain[f"cam{i}"] = values
    return {"": dump_yaml(chain)}
