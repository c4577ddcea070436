"""COLMAP's sparse model as text: a folder with cameras.txt, images.txt, rigs.txt. The scale
is free.

The centre of the first pixel is (0.5, 0.5). Quaternions are QW QX QY QZ, and poses are
camera from world. Where rigs.txt has one rig of several cameras, they are read with
sensor_from_rig, and named by their CAMERA_ID. Otherwise each image is a camera, named as
the image, and the world is the rig. Without images.txt there are no poses."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Callable, Optional

import numpy as np

from ..camera import BROWN, FISHEYE, Camera
from ..errors import Error
from ..transform import Transform
from ._common import (
    Document,
    Files,
    Options,
    blame,
    dist_of,
    make,
    need_pose,
    need_size,
    place,
    read_file,
    refuse,
    shortest,
)
from ._node import Node
from ._text import decode

# Each model: the lens, and its parameters in the file's order. f is fx and fy.
MODELS = {
    "SIMPLE_PINHOLE": ("brown", "f cx cy"),
    "PINHOLE": ("brown", "fx fy cx cy"),
    "SIMPLE_RADIAL": ("brown", "f cx cy k1"),
    "RADIAL": ("brown", "f cx cy k1 k2"),
    "OPENCV": ("brown", "fx fy cx cy k1 k2 p1 p2"),
    "FULL_OPENCV": ("brown", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
    "SIMPLE_FISHEYE": ("fisheye", "f cx cy"),
    "FISHEYE": ("fisheye", "fx fy cx cy"),
    "SIMPLE_RADIAL_FISHEYE": ("fisheye", "f cx cy k1"),
    "RADIAL_FISHEYE": ("fisheye", "f cx cy k1 k2"),
    "OPENCV_FISHEYE": ("fisheye", "fx fy cx cy k1 k2 k3 k4"),
}
CORNER = 0.5  # px: the first pixel's centre
CAMERAS, IMAGES, RIGS = "cameras.txt", "images.txt", "rigs.txt"
Pose = Optional[Transform]


def is_line(words: Sequence[str]) -> bool:
    """Whether a line begins as one of cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT."""
    return (
        len(words) >= 4
        and all(words[i].isdigit() for i in (0, 2, 3))
        and (words[1].replace("_", "").isalnum() and words[1].isupper())
    )


def _lines(text: str) -> Iterator[tuple[Node, list[str]]]:
    """The lines that are no comments, cut at blanks, with their place."""
    for number, line in enumerate(text.split("\n"), 1):
        if not line.lstrip().startswith("#"):
            yield Node(None, f"line {number}"), line.split()


def read(documents: Sequence[Document], options: Options) -> list[Camera]:
    """Of cameras.txt, with its neighbours images.txt and rigs.txt."""
    if len(documents) != 1:
        raise Error("give one folder, or the cameras.txt in it")
    document = documents[0]
    folder = os.path.dirname(document.path)
    with blame(document.path):
        cameras = _cameras(decode(document.data))
    rig = _beside(folder, RIGS, lambda text: _rig(text, cameras, options))
    if rig:
        return list(rig)
    images = _beside(folder, IMAGES, lambda text: _images(text, cameras, options))
    return list(cameras.values() if images is None else images)


def _beside(
    folder: str, name: str, parse: Callable[[str], list[Camera] | None]
) -> list[Camera] | None:
    """What `parse` makes of a file in the folder; None without the file."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return None
    with blame(path):
        return parse(decode(read_file(path)))


def _cameras(text: str) -> dict[str, Camera]:
    cameras: dict[str, Camera] = {}
    for line, words in _lines(text):
        if not words:
            continue
        if not is_line(words):
            raise line.fail("CAMERA_ID MODEL WIDTH HEIGHT and parameters are expected")
        number, model, *numbers = words
        if number in cameras:
            raise line.fail(f"camera {number} is there twice")
        if model not in MODELS:
            raise refuse(line, model, MODELS)
        lens, names = MODELS[model]
        values = Node(numbers, line.where).array((2 + len(names.split()),))
        got = dict(zip(names.split(), values[2:].tolist()))
        f = got.get("f", 0.0)
        dist = [got.get(key, 0.0) for key in (FISHEYE if lens == "fisheye" else BROWN)]
        if lens == "brown":
            dist = shortest(dist)
        K = [got.get("fx", f), got.get("fy", f), got["cx"] - CORNER, got["cy"] - CORNER]
        cameras[number] = make(
            line,
            np.array(K),
            dist=dist,
            size=values[:2],
            lens=lens,
            name=number,
        )
    return cameras


def _pose(words: Sequence[str], line: Node, name: str, options: Options) -> Transform:
    values = Node(list(words), line.where).array((7,))
    with place(line):
        return Transform.from_quat_wxyz(values[:4], values[4:] * options.scale, name, "rig")


def _images(text: str, cameras: dict[str, Camera], options: Options) -> list[Camera] | None:
    """An image a camera; None when there is none. Every second line has points."""
    images: dict[str, Camera] = {}
    is_points = False
    for line, words in _lines(text):
        if is_points or not words:
            is_points = False
            continue
        is_points = True
        if len(words) < 10:
            raise line.fail("IMAGE_ID, a pose, CAMERA_ID and NAME are expected")
        number, name = words[8], " ".join(words[9:])
        if number not in cameras:
            raise line.fail(f"camera {number} is not in {CAMERAS}")
        if name in images:
            raise line.fail(f"image {name} is there twice")
        T = _pose(words[1:8], line, name, options)
        images[name] = replace(cameras[number], name=name, cam_from_rig=T)
    return list(images.values()) or None


def _rig(text: str, cameras: dict[str, Camera], options: Options) -> list[Camera]:
    """The cameras of the one rig that has several; none when no rig has."""
    rigs = [rig for rig in _rigs(text, options) if len(rig) > 1]
    if len(rigs) > 1:
        raise Error(f"{len(rigs)} rigs have several cameras: leave one in the file")
    posed = []
    for line, number, T in rigs[0] if rigs else []:
        if number not in cameras:
            raise line.fail(f"camera {number} is not in {CAMERAS}")
        posed.append(replace(cameras[number], cam_from_rig=T))
    return posed


def _rigs(text: str, options: Options) -> Iterable[list[tuple[Node, str, Pose]]]:
    for line, words in _lines(text):
        if not words:
            continue
        if len(words) < 4:
            raise line.fail("RIG_ID NUM_SENSORS and sensors are expected")
        kind, number, *rest = words[2:]
        rig: list[tuple[Node, str, Pose]] = []
        if kind == "CAMERA":
            rig.append((line, number, Transform.identity(number, "rig")))
        while rest:
            if len(rest) < 3 or rest[2] not in ("0", "1"):
                raise line.fail("SENSOR_TYPE SENSOR_ID HAS_POSE are expected")
            kind, number, has_pose = rest[:3]
            rest = rest[3:]
            T: Pose = None
            if has_pose == "1":
                T = _pose(rest[:7], line, number, options)
                rest = rest[7:]
            if kind == "CAMERA":
                rig.append((line, number, T))
        yield rig


def write(cameras: Sequence[Camera], options: Options) -> Files:
    """cameras.txt, images.txt and an empty points3D.txt, into a folder. CAMERA_ID and
    IMAGE_ID count from 1; the NAME of an image is that of the camera."""
    heads = ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"]
    poses = ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "# (points)"]
    for i, camera in enumerate(cameras, 1):
        if camera.name != " ".join(camera.name.split()):
            raise Error(f"{camera.name!r}: this format cuts a name at its blanks")
        width, height = need_size(camera)
        model = "OPENCV_FISHEYE" if camera.lens == "fisheye" else "FULL_OPENCV"
        dist = dist_of(camera, 8 if camera.lens == "brown" else 4)
        if camera.lens == "brown" and not any(dist[4:]):
            model, dist = ("OPENCV", dist[:4]) if any(dist) else ("PINHOLE", [])
        values = [camera.fx, camera.fy, camera.cx + CORNER, camera.cy + CORNER, *dist]
        words = " ".join(map(repr, values))
        heads.append(f"{i} {model} {width} {height} {words}")
        T = need_pose(camera)
        numbers = [*T.quat_wxyz.tolist(), *(T.t / options.scale).tolist()]
        poses += [f"{i} {' '.join(map(repr, numbers))} {i} {camera.name}", ""]
    return {
        CAMERAS: "\n".join(heads) + "\n",
        IMAGES: "\n".join(poses) + "\n",
        "points3D.txt": "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n",
    }
