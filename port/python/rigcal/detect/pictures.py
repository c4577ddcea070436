"""Pictures as arrays, from image files, videos, or arrays."""

from __future__ import annotations

import importlib
import os
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import Error, FileError

__all__ = ["Looks", "opencv", "read_picture"]

Image = npt.NDArray[Any]

EXIF_BYTES = 1 << 16  # EXIF is among the first bytes of a JPEG file
JPEG_TAIL = 1 << 16  # bytes, among which the end of the image is; cameras add some
ORIENTATION = 0x0112  # the tag of EXIF
TURNED = {3: 180, 5: 90, 6: 90, 7: 270, 8: 270}  # degrees, by its value; 1, 2, 4: none
DEPTHS = (8, 10, 12, 14, 16)  # bits of a sensor, in 16 bits of a file


def opencv() -> Any:
    """The module cv2; Error where it is not installed."""
    try:
        return importlib.import_module("cv2")
    except ImportError as problem:
        raise Error(
            f'OpenCV is needed for images: pip install "rigcal[detect]" ({problem})'
        ) from None


def _why(path: str) -> str:
    """ ": the file is empty", or ""."""
    is_empty = os.path.isfile(path) and not os.path.getsize(path)
    return ": the file is empty" if is_empty else ""


def open_video(path: str) -> Any:
    """cv2.VideoCapture of a video, its pictures as they are stored."""
    cv2 = opencv()
    video = cv2.VideoCapture(path)
    if not video.isOpened():
        raise FileError(path, f"this is no video that OpenCV reads{_why(path)}")
    video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return video


def read_picture(picture: Any) -> Image:
    """A picture of Detections.images or Rig.images: (h, w) grey or (h, w, 3) BGR.

    It is as it is stored: the rotation that EXIF or a video states is not applied, because
    intrinsics are of the sensor.
    """
    if isinstance(picture, np.ndarray):
        return picture
    cv2 = opencv()
    if isinstance(picture, tuple):
        path, number = picture
        video = open_video(path)
        video.set(cv2.CAP_PROP_POS_FRAMES, number)
        found, image = video.read()
        video.release()
        if not found:
            raise FileError(path, f"picture {number} cannot be read")
    else:
        path = str(picture)
        image = cv2.imread(path, cv2.IMREAD_UNCHANGED)  # which leaves EXIF aside
        if image is None:
            raise FileError(path, f"this is no image that OpenCV reads{_why(path)}")
    array: Image = image
    return array


@dataclass(frozen=True)
class Looks:
    """What is known of a picture: size (width, height), channels, bits of a value, and by
    how many degrees its EXIF says that it is turned."""

    size: tuple[int, int]
    channels: int
    bits: int
    turned: int = 0
    is_cut: bool = False  # its file ends before the image does


def looks_of(image: Image, path: str = "") -> Looks:
    """Error if it is not an image."""
    channels = image.shape[2] if image.ndim == 3 else 1
    if image.ndim not in (2, 3) or channels not in (1, 3, 4) or not image.size:
        raise Error(
            f"an image (h, w), (h, w, 3) or (h, w, 4) is expected, not {image.shape}"
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise Error(f"an image of uint8 or uint16 is expected, not {image.dtype}")
    height, width = image.shape[:2]
    bits = 8 * image.dtype.itemsize
    turned = exif_turn(path) if path else 0
    return Looks((width, height), channels, bits, turned, bool(path) and is_cut(path))


def is_cut(path: str) -> bool:
    """Whether the end of a JPEG file is missing."""
    try:
        with open(path, "rb") as file:
            is_jpeg = file.read(2) == b"\xff\xd8"
            return is_jpeg and b"\xff\xd9" not in file.read()[-JPEG_TAIL:]
    except OSError:
        return False


def exif_turn(path: str) -> int:
    """By how many degrees a JPEG file says that it is turned; 0 if it does not say."""
    try:
        with open(path, "rb") as file:
            data = file.read(EXIF_BYTES)
        start = data.index(b"Exif\0\0") + 6 if data[:2] == b"\xff\xd8" else len(data)
        order = {b"II": "<", b"MM": ">"}.get(data[start : start + 2], "")
        if not order:
            return 0
        (first,) = struct.unpack_from(order + "I", data, start + 4)
        (count,) = struct.unpack_from(order + "H", data, start + first)
        for k in range(count):
            at = start + first + 2 + 12 * k
            if struct.unpack_from(order + "H", data, at)[0] == ORIENTATION:
                return TURNED.get(struct.unpack_from(order + "H", data, at + 8)[0], 0)
    except (OSError, ValueError, struct.error):
        pass
    return 0


def depth_of(image: Image) -> int:
    """How many bits the values of a picture have: of 16, those that are in use."""
    if image.dtype == np.uint8:
        return 8
    most = int(image.max())
    return next(bits for bits in DEPTHS if most < 1 << bits)


def grey(image: Image) -> npt.NDArray[np.uint8]:
    """(h, w) of 8 bits: what detectors take. Alpha is dropped, 16 bits are scaled."""
    cv2 = opencv()
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim == 3:
        image = cv2.cvtColor(np.ascontiguousarray(image[:, :, :3]), cv2.COLOR_BGR2GRAY)
    if image.dtype == np.uint16:
        most = (1 << depth_of(image)) - 1
        image = np.round(image * (255.0 / most)).astype(np.uint8)
    return np.ascontiguousarray(image)
