"""Files of cameras: read any of them, write any of them.

    cameras = rigcal.load_cameras("camchain.yaml")        # {"cam0": Camera, ...}
    rigcal.save_cameras("Calib.toml", cameras)

| format     | of                                     | unit of length          |
| ---------- | -------------------------------------- | ----------------------- |
| opencv     | a camera or a pair; YAML, XML, JSON    | not stated              |
| ros        | camera_info, a camera a file           | metre                   |
| kalibr     | camchain                               | metre                   |
| anipose    | calibration.toml; Pose2Sim's Calib.toml | not stated             |
| caliscope  | camera_array.toml, older config.toml   | metre                   |
| mrcal      | .cameramodel, a camera a file          | metre                   |
| colmap     | a folder with cameras.txt, images.txt  | free                    |
| matlab     | stereoParameters as struct; .mat, JSON | WorldUnits; millimetre  |
| nerfstudio | transforms.json                        | free                    |
| multical   | calibration.json                       | not stated              |
| bop        | scene_camera.json                      | millimetre              |
| rigcal     | cameras.csv, with rig.csv in a folder  | the caller's            |
| stored     | rig.bin                                | the caller's            |

Whatever the format: cam_from_rig is X_cam = R X_rig + t with x right, y down, z forward,
pixel (0, 0) is the centre of the top-left one, and coefficients are in OpenCV's order.
Lens models that the library does not have are refused by their name.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from functools import partial
from typing import Callable

import numpy as np

from ..camera import Camera
from ..errors import Error, FileError, path_of
from . import (
    bop,
    colmap,
    kalibr,
    matlab,
    mrcal,
    multical,
    nerfstudio,
    opencv,
    ros,
    stored,
    table,
    toml,
)
from ._common import (
    Document,
    Options,
    PathLike,
    Reader,
    Writer,
    blame,
    read_file,
    write_file,
)
from ._node import Node
from ._text import PARSERS, decode
from .target import Target, load_target, save_target

__all__ = ["Target", "load_cameras", "load_target", "save_cameras", "save_target"]

# A line [name]: a table of TOML. Rows of numbers in YAML are none.
TOML_HEAD = re.compile(
    r"^[ \t]*\[+[ \t]*[A-Za-z_\"'][^\]\n]*\]+[ \t\r]*(#.*)?$", re.MULTILINE
)
FROM_FILE = 0.0  # unit: the file says


@dataclass(frozen=True)
class Format:
    """How files of one format are known, read and written.

    kinds    that its documents may be of
    claims   whether a document of one of these kinds looks like it
    unit     metres in the file's unit of length, where the format says; else 1
    paths    patterns of paths that are written in this format
    """

    kinds: tuple[str, ...]
    claims: Callable[[Node], bool]
    read: Reader
    write: Writer
    unit: float = 1.0
    paths: tuple[str, ...] = ()


def _always(node: Node) -> bool:
    return True


FORMATS = {
    "opencv": Format(
        ("yaml", "xml", "json"), opencv.claims, opencv.read, opencv.write, paths=("*.xml",)
    ),
    "ros": Format(
        ("yaml", "json"), ros.claims, ros.read, ros.write, paths=("*camera_info*",)
    ),
    "kalibr": Format(
        ("yaml", "json"), kalibr.claims, kalibr.read, kalibr.write, paths=("*camchain*",)
    ),
    "anipose": Format(
        ("toml",),
        toml.claims_anipose,
        toml.read,
        toml.write_anipose,
        paths=("calib*.toml", "Calib*.toml"),
    ),
    "caliscope": Format(
        ("toml",),
        toml.claims_caliscope,
        toml.read,
        toml.write_caliscope,
        paths=("camera_array.toml",),
    ),
    "mrcal": Format(
        ("python", "json"), mrcal.claims, mrcal.read, mrcal.write, paths=("*.cameramodel",)
    ),
    "colmap": Format(
        ("colmap",), _always, colmap.read, colmap.write, paths=("cameras.txt",)
    ),
    "matlab": Format(
        ("mat", "json"), matlab.claims, matlab.read, matlab.write, FROM_FILE, ("*.mat",)
    ),
    "nerfstudio": Format(
        ("json",),
        nerfstudio.claims,
        nerfstudio.read,
        nerfstudio.write,
        paths=("transforms*.json",),
    ),
    "multical": Format(
        ("json",),
        multical.claims,
        multical.read,
        multical.write,
        paths=("calibration*.json",),
    ),
    "bop": Format(
        ("json",), bop.claims, bop.read, bop.write, bop.MILLIMETRE, ("scene_camera*.json",)
    ),
    "rigcal": Format(("csv",), _always, table.read, table.write, paths=("*.csv",)),
    "stored": Format(("bytes",), _always, stored.read, stored.write, paths=("*.bin",)),
}


ALIASES = {"pose2sim": "anipose"}


def _known(format: str) -> str:
    name = ALIASES.get(format, format)
    if name not in FORMATS:
        raise Error(f"format: one of {', '.join(FORMATS)} is expected, not {format!r}")
    return name


# ==== reading =================================================================


def load_cameras(
    path: PathLike | Sequence[PathLike],
    format: str | None = None,
    *,
    scale: float | None = None,
    lens: str | None = None,
) -> dict[str, Camera]:
    """The cameras of a file by their names, in the file's order.

    path    a file; a folder of COLMAP (cameras.txt) or rigcal (cameras.csv); or a list of
            files that belong together, as one camera a file
    format  one of the table above; None: known by the content
    scale   multiplies lengths. None: 1, but 0.001 for millimetres where the format says
            so, which gives metres
    lens    "brown" or "fisheye", for a file of 4 coefficients that does not say which

    Raises FileError, "file: what", for whatever cannot be read.
    """
    is_one = isinstance(path, (str, bytes)) or not isinstance(path, Iterable)
    paths = [path_of(p) for p in ([path] if is_one else path)]  # type: ignore[union-attr]
    if not paths:
        raise Error("path: there is no file in the list")
    with blame(paths[0]):
        format = None if format is None else _known(format)
        _check_options(scale, lens)
        documents = [_open(p, format) for entry in paths for p in _files(entry, format)]
        names = [format or _recognise(document) for document in documents]
        if len(set(names)) > 1:
            raise Error(
                f"the files are of several formats: {', '.join(sorted(set(names)))}"
            )
        fmt = FORMATS[names[0]]
        options = Options(fmt.unit if scale is None else scale, lens)
        cameras = _named(fmt.read(documents, options), lens)
        if not cameras:
            raise Error("there is no camera in the file")
        return cameras


def _check_options(scale: float | None, lens: str | None) -> None:
    if scale is not None and not (isinstance(scale, (int, float)) and 0 < scale < np.inf):
        raise Error(f"scale: a number above 0 is expected, not {scale!r}")
    if lens not in (None, "brown", "fisheye"):
        raise Error(f'lens: "brown" or "fisheye" is expected, not {lens!r}')


def _named(cameras: Iterable[Camera], lens: str | None) -> dict[str, Camera]:
    named: dict[str, Camera] = {}
    for camera in cameras:
        if camera.name in named:
            raise Error(f"camera {camera.name} is there twice")
        if lens is not None and camera.lens != lens:
            raise Error(
                f"camera {camera.name}: the file says that its lens is {camera.lens}"
            )
        named[camera.name] = camera
    return named


def _files(path: PathLike, format: str | None) -> list[str]:
    """The path; of a folder the files in it that are read."""
    folder = os.fspath(path)
    if not os.path.isdir(folder):
        return [folder]
    held = {name for name in os.listdir(folder)}
    if table.CAMERAS in held and colmap.CAMERAS in held and format is None:
        raise FileError(folder, 'two formats: pass format="colmap" or format="rigcal"')
    if table.CAMERAS in held and format in (None, "rigcal"):
        return [os.path.join(folder, n) for n in (table.CAMERAS, table.RIG) if n in held]
    if colmap.CAMERAS in held and format in (None, "colmap"):
        return [os.path.join(folder, colmap.CAMERAS)]
    if "cameras.bin" in held:
        raise FileError(
            folder, "a binary model: write it as text with colmap model_converter"
        )
    raise FileError(folder, f"a folder without {table.CAMERAS} and {colmap.CAMERAS}")


def _open(path: str, format: str | None) -> Document:
    """Reads a file and parses it, by its content."""
    data = read_file(path)
    with blame(path):
        kind = _kind(data)
        if format is not None and kind not in FORMATS[format].kinds:
            expected = " or ".join(FORMATS[format].kinds)
            raise Error(f"{expected} is expected for {format}, and this looks like {kind}")
        if kind == "mat":
            return Document(path, kind, data, Node(matlab.load_mat(data)))
        if kind in PARSERS:
            return Document(path, kind, data, Node(PARSERS[kind](decode(data))))
        return Document(path, kind, data)


def _kind(data: bytes) -> str:
    if data.startswith(stored.MAGIC):
        return "bytes"
    if data.startswith((b"MATLAB 5.0", b"MATLAB 7.3", b"\x89HDF")):
        return "mat"
    text = decode(data)
    lines = (line.strip() for line in text.split("\n"))
    first = next((line for line in lines if line and not line.startswith("#")), "")
    if first.startswith(("<?xml", "<opencv_storage")):
        return "xml"
    if first.startswith("{"):
        is_model = re.search(r"""['"](LENSMODEL|DISTORTION)_\w""", text)
        return "python" if is_model else "json"
    columns = table.header(first)
    if table.is_cameras(columns) or table.is_rig(columns):
        return "csv"
    if colmap.is_line(first.split()):
        return "colmap"
    if re.search(r"^Model *= *CAHV", text, re.MULTILINE):
        raise Error("the camera model CAHVOR is not supported")
    return "toml" if TOML_HEAD.search(text) else "yaml"


def _recognise(document: Document) -> str:
    names = [
        name
        for name, fmt in FORMATS.items()
        if document.kind in fmt.kinds and fmt.claims(document.node)
    ]
    if len(names) == 1:
        return names[0]
    if names:
        choice = " or ".join(f'format="{name}"' for name in names)
        raise FileError(document.path, f"several formats look like this: pass {choice}")
    fits = [name for name, fmt in FORMATS.items() if document.kind in fmt.kinds]
    known = ", ".join(fits)
    raise FileError(
        document.path,
        f"{document.kind}, but of no known format ({known}): pass format= to see what it "
        "lacks",
    )


# ==== writing =================================================================


def save_cameras(
    path: PathLike,
    cameras: Mapping[str, Camera] | Iterable[Camera],
    format: str | None = None,
    *,
    scale: float | None = None,
) -> None:
    """Writes cameras as a file.

    path     a file. With "{name}" in it, each camera gets a file of its own, for formats
             of one camera a file. A folder for colmap, and for rigcal with its poses
    cameras  by their names, or a sequence of cameras with names
    format   one of the table above; None: by the path, as "camchain.yaml", "Calib.toml"
    scale    as for load_cameras, by which lengths are divided

    Raises FileError for what the format cannot hold; nothing is written then. A Caveat
    is warned of where a pose has no place in the format.
    """
    target = path_of(path)
    if not isinstance(cameras, Iterable):
        raise Error(f"cameras: several are expected, not {type(cameras).__name__}")
    with blame(target):
        if isinstance(cameras, Mapping):
            pairs = [(str(name), camera) for name, camera in cameras.items()]
        else:
            pairs = [(getattr(camera, "name", ""), camera) for camera in cameras]
        listed = [_renamed(name, camera) for name, camera in pairs]
        if not listed:
            raise Error("there is no camera to write")
        _named(listed, None)
        name = _format_of(target) if format is None else _known(format)
        _check_options(scale, None)
        fmt = FORMATS[name]
        options = Options(fmt.unit if scale is None else scale)
        write = _writer(name, target)
        files: dict[str, str | bytes] = {}
        for part, group in _groups(target, listed):
            for file, content in write(group, options).items():
                files[os.path.join(part, file) if file else part] = content
    for file, content in files.items():
        write_file(file, content)


def _renamed(name: str, camera: Camera) -> Camera:
    """The camera with the name that it has in the mapping."""
    if not isinstance(camera, Camera):
        raise Error(f"cameras: a Camera is expected, not {type(camera).__name__}")
    if not name.strip() or not name.isprintable():
        raise Error(f"{name!r}: a camera needs a name of printable characters")
    return camera if camera.name == name else replace(camera, name=name)


def _groups(target: str, cameras: Sequence[Camera]) -> list[tuple[str, list[Camera]]]:
    if "{name}" not in target:
        return [(target, list(cameras))]
    for camera in cameras:
        if re.search(r"[/\\]|^\.*$", camera.name):
            raise Error(f"{camera.name!r}: this name cannot be that of a file")
    return [(target.replace("{name}", camera.name), [camera]) for camera in cameras]


def _writer(name: str, target: str) -> Writer:
    """The writer of a format, told what the path says of the kind of file."""
    ending = os.path.splitext(target)[1].lower()
    if name == "opencv" and ending in (".xml", ".json"):
        return partial(opencv.write, kind=ending[1:])
    if name == "matlab" and ending == ".json":
        return partial(matlab.write, kind="json")
    if name == "rigcal" and _is_folder(target):
        return partial(table.write, kind="folder")
    return FORMATS[name].write


def _is_folder(target: str) -> bool:
    return os.path.isdir(target) or target.endswith(("/", os.sep))


def _format_of(target: str) -> str:
    base = os.path.basename(target)
    names = [n for n, fmt in FORMATS.items() if any(fnmatch(base, p) for p in fmt.paths)]
    if len(names) != 1:
        known = ", ".join(FORMATS)
        raise Error(
            f"the name of the file does not tell the format: pass format=, of {known}"
        )
    return names[0]
