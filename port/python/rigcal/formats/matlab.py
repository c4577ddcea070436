"""MATLAB's stereoParameters and cameraParameters, as structs in a .mat file or as JSON.

MATLAB multiplies row vectors, [x y z] R + t: RotationOfCamera2 is the transpose of our R.
PoseCamera2 (R2022b and later) is not transposed. The centre of the first pixel is (1, 1).
Radial and tangential coefficients are kept apart; IntrinsicMatrix is K transposed.
Lengths are in `WorldUnits`, millimetres as a rule, and turned into metres. Objects cannot
be read: save `s = toStruct(stereoParams)` by `save('rig.mat', 's')`, not as v7.3."""

from __future__ import annotations

import importlib
import io
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
    dist_of,
    each,
    make,
    nearest,
    need_size,
    place,
    second_from_first,
)
from ._node import Node
from ._text import dump_json

ONE = 1.0  # px: the first pixel's centre
UNITS = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetres"), 0.001),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetres"), 0.01),
    **dict.fromkeys(("m", "meter", "meters", "metres"), 1.0),
    **dict.fromkeys(("in", "inch", "inches"), 0.0254),
}
MILLIMETRE = 0.001
FIRST, SECOND = "CameraParameters1", "CameraParameters2"
NAMES = ("cam1", "cam2")
OBJECT = (
    "an object of MATLAB cannot be read: save s = toStruct(stereoParams) "
    "by save('rig.mat', 's')"
)


def load_mat(data: bytes) -> Any:
    """The variables of a .mat file, structs as dicts."""
    if data[:10] == b"MATLAB 7.3" or data[:4] == b"\x89HDF":
        raise Error("a .mat file of version 7.3 cannot be read: save(..., '-v7') it")
    loadmat = _scipy_io().loadmat
    try:
        return loadmat(io.BytesIO(data), simplify_cells=True)
    except Exception as e:  # SciPy raises what it meets
        raise Error(f"the .mat file is damaged: {type(e).__name__}: {e}") from None


def _scipy_io() -> Any:
    try:
        return importlib.import_module("scipy.io")
    except ImportError:
        raise Error('.mat files need scipy: pip install "rigcal[matlab]"') from None


def _find(node: Node) -> Node | None:
    """The struct of one camera or two: the document itself, or one of its variables."""
    parts = node.mapping()
    if FIRST in parts or "RadialDistortion" in parts:
        return node
    for name, part in parts.items():
        if not name.startswith("__") and (FIRST in part or "RadialDistortion" in part):
            return part
    return None


def claims(node: Node) -> bool:
    """A struct of cameras, or any .mat file: its variables begin with __header__."""
    return isinstance(node.value, dict) and (
        any(str(name).startswith("__") for name in node.value) or _find(node) is not None
    )


def _read(document: Document, options: Options) -> list[Camera]:
    node = _find(document.node)
    if node is None:
        parts = document.node.mapping()
        is_object = "__function_workspace__" in parts or "None" in parts
        raise Error(OBJECT if is_object else "there is no struct of a camera in the file")
    if FIRST not in node:
        return [_camera(node, document.stem)]
    first, second = (_camera(node[key], name) for key, name in zip((FIRST, SECOND), NAMES))
    T = _second(node, _scale(node, options))
    first = replace(first, cam_from_rig=Transform.identity(first.name, "rig"))
    return [first, replace(second, cam_from_rig=T)]


read = each(_read)


def _scale(node: Node, options: Options) -> float:
    """Metres in a unit of the struct."""
    if options.scale:
        return options.scale
    units = node.get("WorldUnits") or node[FIRST].get("WorldUnits")
    if units is None:
        return MILLIMETRE
    if str(units.value).lower() not in UNITS:
        raise units.fail(f"the unit {units.value!r} is not known: pass scale=")
    return UNITS[str(units.value).lower()]


def _second(node: Node, scale: float) -> Transform:
    pose = node.get("PoseCamera2")
    if "RotationOfCamera2" in node:
        R_node, t_node = node["RotationOfCamera2"], node["TranslationOfCamera2"]
        R = R_node.array((3, 3)).T
    elif pose is not None:
        R_node, t_node = pose[("R", "Rotation")], pose["Translation"]
        R = R_node.array((3, 3))
    else:
        raise node.fail("RotationOfCamera2 is missing")
    with place(t_node):
        t = t_node.array((3,)) * scale
        return Transform(nearest(R, R_node), t, NAMES[1], "rig")


def _camera(node: Node, name: str) -> Camera:
    if "K" in node:
        K = node["K"].array((3, 3))
    elif "IntrinsicMatrix" in node:
        K = node["IntrinsicMatrix"].array((3, 3)).T
    else:
        (fx, fy), (cx, cy) = (
            node[key].array((2,)) for key in ("FocalLength", "PrincipalPoint")
        )
        skew = node["Skew"].number() if "Skew" in node else 0.0
        K = np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]])
    shift = np.zeros((3, 3))
    shift[:2, 2] = ONE
    radial = node["RadialDistortion"].array()
    if radial.size not in (2, 3):
        raise node["RadialDistortion"].fail("2 or 3 coefficients are expected")
    tangential = node["TangentialDistortion"].array((2,))
    size = node.get("ImageSize")
    if size is not None and not size.array().size:
        size = None
    return make(
        node,
        K - shift,
        dist=[*radial[:2], *tangential, *radial[2:]],
        size=None if size is None else size.array((2,))[::-1],
        name=name,
    )


def _struct(camera: Camera) -> dict[str, Any]:
    dist = dist_of(camera)
    if camera.lens != "brown" or any(dist[5:]):
        raise Error(f"{camera.name}: this format has k1 k2 p1 p2 k3 alone")
    K = camera.matrix
    K[:2, 2] += ONE
    radial = [*dist[:2], *dist[4:5]]
    return {
        "IntrinsicMatrix": K.T,
        "RadialDistortion": np.array(radial),
        "TangentialDistortion": np.array(dist[2:4]),
        "ImageSize": np.array(need_size(camera)[::-1], dtype=np.float64),
        "WorldUnits": "millimeters",
        "EstimateSkew": False,
        "NumRadialDistortionCoefficients": float(len(radial)),
        "EstimateTangentialDistortion": True,
    }


def write(cameras: Sequence[Camera], options: Options, kind: str = "mat") -> Files:
    """A struct of one camera or two. Lengths are written in millimetres."""
    if len(cameras) > 2:
        raise Error("this format holds one camera or two")
    values = _struct(cameras[0])
    if len(cameras) == 2:
        R, t = second_from_first(cameras, options.scale or MILLIMETRE)
        values = {
            FIRST: values,
            SECOND: _struct(cameras[1]),
            "RotationOfCamera2": R.T,
            "TranslationOfCamera2": t,
        }
    if kind == "json":
        return {"": dump_json(_lists(values))}
    file = io.BytesIO()
    _scipy_io().savemat(file, {"s": values}, oned_as="row")
    return {"": file.getvalue()}


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(part) for key, part in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value
