"""ROS camera_info, one camera a file: as the calibrator stores it, or a message as text.

K is of the raw image and taken; P is of the rectified one and not. A rectified pair has
its geometry in R (rectified from camera) and in P, of which the last column is fx' tx.
The rig is then the rectified frame of the first camera, in metres:
X_cam = R^T (X_rig + (tx, ty, 0)). Where R is the identity and P has no tx, ty, the file
says nothing of the pose. Frames are optical ones: x right, y down, z forward."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..camera import Camera
from ..transform import Array, Transform
from ._common import (
    Document,
    Files,
    Options,
    dist_of,
    each,
    left_out,
    make,
    nearest,
    need_size,
    only_one,
    place,
    refuse,
    warn,
)
from ._node import Node
from ._text import dump_yaml

LENSES = {
    "plumb_bob": "brown",
    "rational_polynomial": "brown",
    "equidistant": "fisheye",
    "fisheye": "fisheye",
    "none": "brown",
}
K_NAMES = ("camera_matrix", "K", "k")
D_NAMES = ("distortion_coefficients", "D", "d")
R_NAMES = ("rectification_matrix", "R", "r")
P_NAMES = ("projection_matrix", "P", "p")


def claims(node: Node) -> bool:
    value = node.value
    return (
        isinstance(value, dict)
        and "distortion_model" in value
        and any(name in value for name in K_NAMES)
    )


def _read(document: Document, options: Options) -> list[Camera]:
    node = document.node
    model_node = node["distortion_model"]
    model = model_node.text()
    if model not in LENSES:
        raise refuse(model_node, model, LENSES)
    D, R, P = node[D_NAMES], node.get(*R_NAMES), node.get(*P_NAMES)
    header = node.get("header")
    frame = header.get("frame_id") if header is not None else None
    name_node = node.get("camera_name") or frame
    name = name_node.text() if name_node and name_node.value else document.stem
    extra: dict[str, Any] = {} if header is None else header.plain(["frame_id"])
    if P is not None and any(P.array((3, 4)).ravel()):
        extra["P"] = P.array((3, 4)).tolist()
    if _is_cut(node):
        warn(f"{document.path}: binning or a region of interest: K is of the full image")
    size = [node[("image_width", "width")], node[("image_height", "height")]]
    return [
        make(
            node,
            node[K_NAMES].array((3, 3)),
            dist=D.array(),
            size=tuple(side.number() for side in size),
            lens=LENSES[model],
            name=name,
            cam_from_rig=_pose(R, P, name, options.scale),
            extra=extra,
        )
    ]


read = each(_read)


def _is_cut(node: Node) -> bool:
    roi = node.get("roi")
    cut = [roi.get(k) for k in ("x_offset", "y_offset", "width", "height")] if roi else []
    return any(v is not None and v.number() > 0 for v in cut) or any(
        v is not None and v.number() > 1
        for v in (node.get("binning_x"), node.get("binning_y"))
    )


def _pose(R: Node | None, P: Node | None, name: str, scale: float) -> Transform | None:
    rect = np.eye(3) if R is None else R.array((3, 3))
    if not rect.any():  # an uncalibrated driver leaves zeros
        rect = np.eye(3)
    shift = np.zeros(3)
    if P is not None:
        M = P.array((3, 4))
        if M[:2, 3].any():
            if M[0, 0] == 0 or M[1, 1] == 0 or M[2, 3] != 0:
                raise P.fail("a projection of a rectified pair is expected")
            shift[:2] = M[:2, 3] / (M[0, 0], M[1, 1])
    if not shift.any() and np.array_equal(rect, np.eye(3)):
        return None
    rect = nearest(rect, R or Node(None, "R"))
    with place(P or Node(None, "P")):
        return Transform(rect.T, rect.T @ shift * scale, name, "rig")


def write(cameras: Sequence[Camera], options: Options) -> Files:
    """One camera, as the calibrator stores it. A pose that is no rectified one has no place
    in this format: it is left out with a Caveat."""
    camera = only_one(cameras)
    width, height = need_size(camera)
    R, shift = np.eye(3), np.zeros(3)
    T = camera.cam_from_rig
    if T is not None:
        if abs(T.center[2]) > 1e-12 * max(1.0, float(np.abs(T.t).max())):
            left_out(camera)
        else:
            R, shift = T.R.T, -T.center / options.scale
    new_K = np.array(camera.extra.get("P", camera.matrix))[:, :3]
    P = np.column_stack([new_K, [new_K[0, 0] * shift[0], new_K[1, 1] * shift[1], 0.0]])
    dist = dist_of(camera, 4 if camera.lens == "fisheye" else 5)
    model = "equidistant" if camera.lens == "fisheye" else "plumb_bob"
    values = {
        "image_width": width,
        "image_height": height,
        "camera_name": camera.name,
        "camera_matrix": _rows(camera.matrix),
        "distortion_model": "rational_polynomial" if len(dist) > 5 else model,
        "distortion_coefficients": _rows(np.array([dist])),
        "rectification_matrix": _rows(R),
        "projection_matrix": _rows(P),
    }
    return {"": dump_yaml(values)}


def _rows(matrix: Array) -> dict[str, Any]:
    rows, cols = matrix.shape
    return {"rows": rows, "cols": cols, "data": matrix.ravel().tolist()}
