"""Extrinsic calibration of camera rigs: see README.md."""

from .calibrate import calibrate
from .camera import Camera
from .errors import Caveat, Error, FileError
from .formats import Target, load_cameras, load_target, save_cameras, save_target
from .rig import Rig, load
from .transform import Transform

__all__ = [
    "Camera",
    "Caveat",
    "Error",
    "FileError",
    "Rig",
    "Target",
    "Transform",
    "calibrate",
    "load",
    "load_cameras",
    "load_target",
    "save_cameras",
    "save_target",
]
