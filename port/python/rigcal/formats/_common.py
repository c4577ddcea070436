"""What the formats share: documents, options, and one camera from its parts."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Callable, Union

import numpy as np

from ..camera import BROWN_LENGTHS, Camera
from ..errors import Caveat, Error, FileError
from ..transform import Array, Transform, rotation_from_rvec
from ._node import Node, PlacedError

PathLike = Union[str, "os.PathLike[str]"]

# The error of a rotation written with six digits. The nearest rotation replaces it.
ROUNDING = 1e-5
EXACT = 1e-9  # nearer than this it is kept to the last bit


@dataclass(frozen=True)
class Options:
    """scale: metres (or any unit) per unit of the file; lens: where the file is silent."""

    scale: float = 1.0
    lens: str | None = None


@dataclass
class Document:
    """One file, read: of `kind` "yaml", "json", "toml", "python", "xml", "csv", "colmap",
    "mat" or "bytes". `node` has what a parser gave, `data` the bytes."""

    path: str
    kind: str
    data: bytes
    node: Node = field(default_factory=lambda: Node(None))

    @property
    def stem(self) -> str:
        """The file's name without its folder and ending: a camera's, if it has no other."""
        return os.path.basename(self.path).split(".")[0] or "cam0"


@contextmanager
def blame(path: PathLike) -> Iterator[None]:
    """Turns any Error into a FileError of this file."""
    try:
        yield
    except FileError:
        raise
    except Error as e:
        raise FileError(path, e.text) from None


@contextmanager
def place(node: Node) -> Iterator[None]:
    """Puts the place in a file before the text of an Error."""
    try:
        yield
    except PlacedError:
        raise
    except Error as e:
        raise node.fail(e.text) from None


FILE_MAX = 256 << 20  # bytes


def read_file(path: PathLike) -> bytes:
    """All bytes of a file of at most 256 MB."""
    try:
        with open(path, "rb") as file:
            data = file.read(FILE_MAX + 1)
    except (OSError, ValueError) as e:  # ValueError: a zero byte in the path
        raise FileError(path, getattr(e, "strerror", None) or str(e)) from None
    if len(data) > FILE_MAX:
        raise FileError(path, f"more than {FILE_MAX >> 20} MB: that is no camera file")
    return data


def write_file(path: PathLike, content: str | bytes) -> None:
    """Text as UTF-8 with LF. The folder is made."""
    try:
        data = content.encode("utf-8") if isinstance(content, str) else content
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "wb") as file:
            file.write(data)
    except (OSError, ValueError) as e:
        raise FileError(path, getattr(e, "strerror", None) or str(e)) from None


Reader = Callable[[Sequence[Document], Options], Iterable[Camera]]
# The files to write: their contents by name; "" is the path that the user gave.
Files = dict[str, Union[str, bytes]]
Writer = Callable[[Sequence[Camera], Options], Files]


def each(read: Callable[[Document, Options], Iterable[Camera]]) -> Reader:
    """Makes a reader of several files from the reader of one."""

    def reader(documents: Sequence[Document], options: Options) -> list[Camera]:
        cameras: list[Camera] = []
        for document in documents:
            with blame(document.path):
                cameras += read(document, options)
        return cameras

    return reader


# ==== reading =================================================================


def rotation(node: Node) -> Array:
    """A rotation matrix from a matrix or a rotation vector."""
    values = node.array()
    if values.size == 3:
        with place(node):
            return rotation_from_rvec(values)
    return nearest(node.array((3, 3)), node)


def nearest(R: Array, node: Node) -> Array:
    """R, or the rotation nearest to it where digits were rounded off."""
    with np.errstate(over="ignore", invalid="ignore"):
        skew = np.abs(R @ R.T - np.eye(3)).max()
    if not (skew <= ROUNDING and np.linalg.det(R) > 0):
        raise node.fail("the matrix is not a rotation")
    if skew <= EXACT:
        return R
    U, _, Vt = np.linalg.svd(R)
    nearest_R: Array = U @ Vt
    return nearest_R


def pose(R: Node, t: Node, name: str, scale: float) -> Transform:
    """cam_from_rig from its two parts."""
    matrix = rotation(R)
    with place(t):
        return Transform(matrix, t.array((3,)) * scale, to=name, frm="rig")


def rigid(node: Node, to: str, frm: str, scale: float = 1.0) -> Transform:
    """From a 4x4 matrix, or a 3x4 one without its last row 0 0 0 1."""
    values = node.array()
    T = node.array((3, 4) if values.size == 12 else (4, 4))
    if T.shape == (4, 4) and np.abs(T[3] - [0, 0, 0, 1]).max() > ROUNDING:
        raise node.fail("the last row is not 0 0 0 1")
    with place(node):
        return Transform(nearest(T[:3, :3], node), T[:3, 3] * scale, to, frm)


def make(node: Node, K: Array, **fields: Any) -> Camera:
    """A camera of K (3, 3) or (fx, fy, cx, cy); errors name the place."""
    with place(node):
        if K.shape == (4,):
            return Camera(*K.tolist(), **fields)
        return Camera.from_matrix(K, **fields)


def unmarked_lens(dist: Array, node: Node, options: Options) -> str:
    """The lens, if the file does not say which: 4 coefficients fit either."""
    if options.lens is None and dist.size == 4:
        raise node.fail(
            "these 4 coefficients may be k1 k2 p1 p2 or those of a fisheye: "
            'pass lens="brown" or lens="fisheye"'
        )
    return options.lens or "brown"


def shortest(dist: Sequence[float]) -> list[float]:
    """The coefficients of a brown lens without zeros at the end: 0, 4, 5 or 8 of them."""
    return list(dist[: min(n for n in BROWN_LENGTHS if not any(dist[n:]))])


def refuse(node: Node, model: str, known: Iterable[str]) -> PlacedError:
    """The error for a lens model that the library does not have."""
    return node.fail(
        f'the camera model "{model}" is not supported (supported: {", ".join(known)}): '
        "undistort the images with their own program"
    )


@dataclass(frozen=True)
class Layout:
    """The keys under which formats of one shape keep the parts of a camera."""

    matrix: str
    dist: str | None
    size: str | None
    rotation: str
    translation: str


LAYOUTS = {
    "toml": Layout("matrix", "distortions", "size", "rotation", "translation"),
    "multical": Layout("K", "dist", "image_size", "R", "T"),
    "bop": Layout("cam_K", None, None, "cam_R_w2c", "cam_t_w2c"),
}


def read_layout(
    node: Node, layout: Layout, name: str, lens: str, scale: float, extra: Any = None
) -> Camera:
    """A camera of a layout. Without rotation and translation it has no pose."""
    K = node[layout.matrix].array((3, 3))
    dist = node[layout.dist] if layout.dist else None
    size = node.get(layout.size) if layout.size else None
    R, t = node.get(layout.rotation), node.get(layout.translation)
    if (R is None) != (t is None):
        raise node.fail(f"one of {layout.rotation} and {layout.translation} is missing")
    return make(
        node,
        K,
        dist=() if dist is None else dist.array(),
        size=None if size is None else size.array((2,)),
        lens=lens,
        name=name,
        cam_from_rig=None if R is None or t is None else pose(R, t, name, scale),
        extra=extra or {},
    )


# ==== writing =================================================================


def write_layout(
    camera: Camera, layout: Layout, scale: float, vector: bool = True
) -> dict[str, Any]:
    """The parts of a camera as lists; the rotation as a vector or a matrix."""
    values: dict[str, Any] = {}
    if layout.size:
        values[layout.size] = list(need_size(camera))
    values[layout.matrix] = camera.matrix.tolist()
    if layout.dist:
        values[layout.dist] = dist_of(camera)
    T = camera.cam_from_rig
    if T is not None:
        values[layout.rotation] = (T.rvec if vector else T.R).tolist()
        values[layout.translation] = (T.t / scale).tolist()
    return values


def need_size(camera: Camera) -> tuple[int, int]:
    if camera.size is None:
        raise Error(f"{camera.name}: this format needs the image size, which is not known")
    return camera.size


def need_pose(camera: Camera) -> Transform:
    if camera.cam_from_rig is None:
        raise Error(f"{camera.name}: this format needs cam_from_rig, which is not known")
    return camera.cam_from_rig


def dist_of(camera: Camera, least: int = 4) -> list[float]:
    """The coefficients, with zeros up to at least `least`."""
    return list(camera.dist) + [0.0] * (least - len(camera.dist))


def four_of(camera: Camera) -> list[float]:
    """k1 k2 p1 p2 or k1 k2 k3 k4, of a lens that has no more."""
    dist = dist_of(camera)
    if any(dist[4:]):
        raise Error(f"{camera.name}: this format has no k3 to k6, and they are not 0")
    return dist[:4]


def only_one(cameras: Sequence[Camera]) -> Camera:
    if len(cameras) != 1:
        raise Error('a file of this format holds one camera: put "{name}" into the path')
    return cameras[0]


def left_out(camera: Camera) -> None:
    """Warns that the file has no place for a pose."""
    warn(f"{camera.name}: this format has no place for cam_from_rig: left out")


def warn(text: str) -> None:
    """A Caveat, of the line that called load_cameras or save_cameras."""
    depth, frame = 1, sys._getframe()
    while frame.f_back is not None and __package__ in frame.f_globals.get("__name__", ""):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(Caveat(text), stacklevel=depth)


def second_from_first(cameras: Sequence[Camera], scale: float) -> tuple[Array, Array]:
    """R and t of a stereo pair; t in the file's unit. Warns where a frame is lost."""
    first, second = need_pose(cameras[0]), need_pose(cameras[1])
    if not np.array_equal(first.matrix, np.eye(4)):
        warn(f"the rig of this format is its first camera, {cameras[0].name}")
    R = second.R @ first.R.T
    return R, (second.t - R @ first.t) / scale
