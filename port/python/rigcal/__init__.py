"""Extrinsic calibration of camera rigs: see README.md."""

from .camera import Camera
from .errors import Caveat, Error, FileError
from .transform import Transform

__all__ = ["Camera", "Caveat", "Error", "FileError", "Transform"]
