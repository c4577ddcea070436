"""Extrinsic calibration of camera rigs: see README.md."""

from .camera import Camera
from .errors import Caveat, Error, FileError
from .formats import Target, load_cameras, load_target, save_cameras, save_target
from .transform import Transform

__all__ = [
    "Camera",
    "Caveat",
    "Error",
    "FileError",
    "Target",
    "Transform",
    "load_cameras",
    "load_target",
    "save_cameras",
    "save_target",
]
