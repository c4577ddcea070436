"""mrcal's .cameramodel: one camera a file, a Python dictionary with comments. Metres.

`extrinsics` (rt_cam_ref in newer files) is the rotation vector first, then the translation,
camera from reference. The intrinsics are fx fy cx cy and OpenCV's coefficients in one
list. Older files call the model DISTORTION_OPENCV8 instead of LENSMODEL_OPENCV8. Splined
models and CAHVOR are refused."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..camera import Camera
from ..transform import Transform
from ._common import (
    Document,
    Files,
    Options,
    dist_of,
    each,
    make,
    need_size,
    only_one,
    place,
    refuse,
)
from ._node import Node

MODELS = {
    "LENSMODEL_PINHOLE": 0,
    "LENSMODEL_OPENCV4": 4,
    "LENSMODEL_OPENCV5": 5,
    "LENSMODEL_OPENCV8": 8,
    "LENSMODEL_OPENCV12": 12,
}
MODEL_KEYS = ("lens_model", "lensmodel", "distortion_model")
POSE_KEYS = ("extrinsics", "rt_cam_ref")


def claims(node: Node) -> bool:
    value = node.value
    return isinstance(value, dict) and any(
        re.match("(LENSMODEL|DISTORTION)_", str(value.get(key))) for key in MODEL_KEYS
    )


def _read(document: Document, options: Options) -> list[Camera]:
    node = document.node
    model_node = node[MODEL_KEYS]
    model = re.sub("^DISTORTION", "LENSMODEL", model_node.text())
    model = {"LENSMODEL_NONE": "LENSMODEL_PINHOLE"}.get(model, model)
    if model not in MODELS:
        raise refuse(model_node, model, MODELS)
    values = node["intrinsics"].array((4 + MODELS[model],))
    rt = node.get(*POSE_KEYS)
    T = None
    if rt is not None:
        r, t = rt.array((2, 3))
        with place(rt):
            T = Transform.from_rvec(r, t * options.scale, document.stem, "rig")
    return [
        make(
            node,
            values[:4],
            dist=values[4:],
            size=node["imagersize"].array((2,)),
            name=document.stem,
            cam_from_rig=T,
        )
    ]


read = each(_read)


def write(cameras: Sequence[Camera], options: Options) -> Files:
    camera = only_one(cameras)
    if camera.lens != "brown":
        raise refuse(Node(None, camera.name), "fisheye", MODELS)
    dist = dist_of(camera, 0)
    model = f"LENSMODEL_OPENCV{len(dist)}" if dist else "LENSMODEL_PINHOLE"
    intrinsics = [camera.fx, camera.fy, camera.cx, camera.cy, *dist]
    T = camera.cam_from_rig or Transform.identity()
    rt = [*T.rvec.tolist(), *(T.t / options.scale).tolist()]
    return {
        "": f"{{\n    'lens_model': '{model}',\n\n"
        "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
        f"    'intrinsics': {intrinsics},\n\n"
        f"    # extrinsics are rt_fromref\n    'extrinsics': {rt},\n\n"
        f"    'imagersize': {list(need_size(camera))},\n}}\n"
    }
