"""Pictures as arrays: of image files, of videos, as they are given."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import Error, FileError

__all__ = ["opencv", "read_picture"]


def opencv() -> Any:
    """The module cv2; Error where it is not installed."""
    try:
        return importlib.import_module("cv2")
    except ImportError as problem:
        raise Error(
            f'OpenCV is needed for images: pip install "rigcal[detect]" ({problem})'
        ) from None


def read_picture(picture: Any) -> npt.NDArray[Any]:
    """A picture of Detections.images or Rig.images: (h, w) grey or (h, w, 3) BGR, as stored.

    The rotation that EXIF or a video states is not applied: intrinsics are of the sensor.
    """
    if isinstance(picture, np.ndarray):
        return picture
    cv2 = opencv()
    if isinstance(picture, tuple):
        path, number = picture
        video = cv2.VideoCapture(path)
        video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        video.set(cv2.CAP_PROP_POS_FRAMES, number)
        found, image = video.read()
        video.release()
        if not found:
            raise FileError(path, f"picture {number} cannot be read")
        array: npt.NDArray[Any] = image
        return array
    flags = cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION
    array = cv2.imread(str(picture), flags)
    if array is None:
        raise FileError(str(picture), "this is no image that OpenCV reads")
    return array
