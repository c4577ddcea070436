"""OpenCV's FileStorage: one camera, or a stereo pair, in YAML, XML or JSON.

The cameras of a pair are "left" and "right" where the file has no names. T is in the
caller's unit. Second from first: X_2 = R X_1 + T, and the first camera is the
rig. Names of values differ from program to program (M1, K1, cameraMatrix1, ...): they are
compared without case and underscores. A file of 4 coefficients does not say which lens it
is of, unless it has `fisheye_model`. 12 and 14 coefficients must be 0 from the 9th on."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..camera import Camera
from ..errors import Error
from ..transform import Transform
from ._common import (
    Document,
    Files,
    Options,
    blame,
    dist_of,
    left_out,
    make,
    pose,
    refuse,
    second_from_first,
    unmarked_lens,
)
from ._node import Node
from ._text import Matrix, dump_json, dump_xml, dump_yaml

MATRIX = ("cameramatrix", "m", "k", "intrinsicmatrix", "intrinsics", "cammatrix", "mtx")
DIST = (
    *("distortioncoefficients", "distcoeffs", "d", "distcoeff", "dist", "distortion"),
    *("distortioncoeffs", "distortioncoefs", "distcoef"),
)
SIZE = ("imagesize", "size", "imgsize")
ROTATION = ("r", "rotation", "rotationmatrix", "rmat", "rot")
TRANSLATION = ("t", "translation", "translationvector", "tvec", "trans")
NAME = ("cameraname", "name")
FISHEYE = ("fisheyemodel", "fisheye")
OMNI = ("xi",)  # of OpenCV's omnidir
SIDES = (("1", "left", "l"), ("2", "right", "r"))
NAMES = ("left", "right")


def _plain(name: str) -> str:
    return re.sub(r"[_\s-]", "", name).lower()


def _with(names: Sequence[str], ends: Sequence[str]) -> tuple[str, ...]:
    before = [end + name for name in names if len(name) > 1 for end in ends]
    return (*[name + end for name in names for end in ends], *before)


USED = {
    name
    for names in (MATRIX, DIST, SIZE, NAME, FISHEYE, OMNI, ROTATION, TRANSLATION)
    for name in (*names, *_with(names, SIDES[0]), *_with(names, SIDES[1]))
}


def _by_plain_name(node: Node) -> Node:
    parts: dict[str, Any] = {}
    for name, part in node.mapping().items():
        plain = _plain(name)
        if plain in parts and plain in USED:
            raise node.fail(f"{name} is there twice, spelt in two ways")
        parts[plain] = part.value
    return Node(parts, node.where)


def claims(node: Node) -> bool:
    """Whether a document is of this format: a matrix by its name, or R and T."""
    if not isinstance(node.value, dict) or "distortion_model" in node.value:
        return False
    names = {_plain(str(name)) for name in node.value}
    has_pair = names.intersection(ROTATION) and names.intersection(TRANSLATION)
    return _has_matrix(node) or bool(has_pair)


def _has_matrix(node: Node) -> bool:
    values = {_plain(str(name)): value for name, value in node.value.items()}
    names = (*MATRIX, *_with(MATRIX, SIDES[0]))
    return any(isinstance(values.get(name), (dict, list)) for name in names)


def read(documents: Sequence[Document], options: Options) -> list[Camera]:
    """One camera a file, or a pair, whose R and T may be in a file of their own."""
    with_matrix = [d for d in documents if d.node.mapping() and _has_matrix(d.node)]
    if len(with_matrix) == 1:
        merged: dict[str, Any] = {}
        for document in documents:
            merged.update({} if document is with_matrix[0] else document.node.value)
        merged.update(with_matrix[0].node.value)
        documents = [replace(with_matrix[0], node=Node(merged))]
    cameras: list[Camera] = []
    for document in documents:
        with blame(document.path):
            cameras += _read(document, options)
    return cameras


def _read(document: Document, options: Options) -> list[Camera]:
    node = _by_plain_name(document.node)
    if node.get(*_with(MATRIX, SIDES[0])) is None:
        return [_camera(node, (), document.stem, options)]
    first, second = (_camera(node, ends, name, options) for ends, name in zip(SIDES, NAMES))
    R, t = node.get(*ROTATION), node.get(*TRANSLATION)
    if R is None and t is None:
        return [first, second]
    second_pose = pose(node[ROTATION], node[TRANSLATION], second.name, options.scale)
    first_pose = Transform.identity(first.name, "rig")
    return [
        replace(first, cam_from_rig=first_pose),
        replace(second, cam_from_rig=second_pose),
    ]


def _camera(node: Node, ends: Sequence[str], default: str, options: Options) -> Camera:
    """The camera whose values have one of these endings; without any: the only one."""

    def names(plain: Sequence[str]) -> tuple[str, ...]:
        return _with(plain, ends) if ends else tuple(plain)

    K = node[names(MATRIX)].array((3, 3))
    xi = node.get(*names(OMNI), *OMNI)
    if xi is not None:
        raise refuse(xi, "omni", ("brown", "fisheye"))
    dist_node = node[names(DIST)]
    dist = dist_node.array()
    fisheye = node.get(*names(FISHEYE), *FISHEYE)
    if fisheye is not None:
        lens = "fisheye" if fisheye.number() else "brown"
    else:
        lens = unmarked_lens(dist, dist_node, options)
    name = node.get(*names(NAME))
    size = node.get(*names(SIZE), *SIZE)
    for end in (*ends, ""):
        if size is None and "imagewidth" + end in node:
            pair = [node["image" + side + end].value for side in ("width", "height")]
            size = Node(pair, "image_width" + end)
    return make(
        node,
        K,
        dist=dist,
        size=None if size is None else size.array((2,)),
        lens=lens,
        name=default if name is None else name.text(),
    )


def write(cameras: Sequence[Camera], options: Options, kind: str = "yaml") -> Files:
    """One camera or a pair. Keys are those of OpenCV's samples."""
    if len(cameras) > 2:
        raise Error('this format holds one camera or two: put "{name}" into the path')
    values: dict[str, Any] = {}
    for camera, end in zip(cameras, ("1", "2") if len(cameras) > 1 else ("",)):
        K, D = ("M", "D") if end else ("camera_matrix", "distortion_coefficients")
        if camera.size is not None:
            values["image_width" + end], values["image_height" + end] = camera.size
        values["camera_name" + end] = camera.name
        values["fisheye_model" + end] = int(camera.lens == "fisheye")
        values[K + end] = Matrix(camera.matrix)
        values[D + end] = Matrix(np.array([dist_of(camera)]))
    first = cameras[0]
    if len(cameras) == 2:
        R, t = second_from_first(cameras, options.scale)
        values["R"], values["T"] = Matrix(R), Matrix(t.reshape(3, 1))
    elif first.cam_from_rig is not None:
        left_out(first)
    if kind == "xml":
        return {"": dump_xml(values)}
    if kind == "json":
        marked = {
            k: {"type_id": "opencv-matrix", **v} if isinstance(v, Matrix) else v
            for k, v in values.items()
        }
        return {"": dump_json(marked)}
    return {"": "%YAML:1.0\n---\n" + dump_yaml(values)}
