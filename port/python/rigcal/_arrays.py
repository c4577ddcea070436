"""Arguments as the C arrays that they have to be; Error names the argument and its shape.

A contiguous, aligned float64 array is handed on as it is, without a copy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._layout import CAMERA, TRANSFORM
from ._names import Lenses
from .camera import Camera
from .errors import Error
from .transform import Transform

__all__ = [
    "camera_array",
    "camera_struct",
    "one_camera",
    "real",
    "reals",
    "transform_struct",
]

Array = npt.NDArray[np.float64]
FLOAT = np.dtype(np.float64)
COUNT_MAX = 2**28  # items: the library's range


def fits(shape: tuple[int, ...], wanted: tuple[int | str, ...]) -> bool:
    if len(shape) != len(wanted):
        return False
    for n, w in zip(shape, wanted):  # noqa: SIM110 -- a generator takes four times as long
        if n != w and type(w) is not str:
            return False
    return True


def shown(wanted: tuple[int | str, ...]) -> str:
    inside = ", ".join(str(w) for w in wanted)
    return f"({inside},)" if len(wanted) == 1 else f"({inside})"


def numeric(value: npt.ArrayLike, what: str, wanted: str, kinds: str) -> npt.NDArray[Any]:
    """`value` as an array of any shape, with a type of one of these kinds."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise Error(f"{what}: an element is masked; its shape is {value.shape}")
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):  # ragged lists
        raise Error(f"{what}: {wanted} are expected") from None
    if array.dtype.kind not in kinds:
        raise Error(
            f"{what}: {wanted} are expected, not {array.dtype} of shape {array.shape}"
        )
    return array


def reals(value: npt.ArrayLike, wanted: tuple[int | str, ...], what: str) -> Array:
    """`value` as a contiguous float64 array of a shape like (2, "n", 3), where a letter is
    any number. It may hold NaN."""
    is_plain = (
        type(value) is np.ndarray
        and value.dtype is FLOAT
        and value.flags.c_contiguous
        and value.flags.aligned
    )
    if is_plain:
        array: npt.NDArray[Any] = value  # type: ignore[assignment]
    else:
        array = numeric(value, what, f"numbers of shape {shown(wanted)}", "fiu")
    if not fits(array.shape, wanted):
        raise Error(f"{what}: shape {shown(wanted)} is expected, not {array.shape}")
    if array.size > 8 * COUNT_MAX:
        raise Error(f"{what}: shape {array.shape} has more than 2^28 items")
    return array if is_plain else np.require(array, FLOAT, ["C", "A"])


def indices(
    value: npt.ArrayLike, wanted: tuple[int | str, ...], what: str, below: int
) -> Any:
    """`value` as int64, each 0 to below - 1: a copy, which nobody else changes."""
    array = numeric(value, what, f"whole numbers of shape {shown(wanted)}", "iu")
    if not fits(array.shape, wanted):
        raise Error(f"{what}: shape {shown(wanted)} is expected, not {array.shape}")
    if array.size and (array.min() < 0 or array.max() >= below):
        raise Error(f"{what}: 0 to {below - 1} is expected; its shape is {array.shape}")
    return array.astype(np.int64)


def real(value: Any, what: str, low: float, high: float) -> float:
    """A finite number from low to high."""
    try:
        if isinstance(value, (str, bytes)):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise Error(f"{what}: a number is expected, not {type(value).__name__}") from None
    if not low <= number <= high:
        raise Error(f"{what}: {low:g} to {high:g} is expected, not {number:g}")
    return number


def whole(value: Any, what: str, low: int, high: int) -> int:
    """A whole number from low to high."""
    if isinstance(value, (int, np.integer)) and low <= value <= high:
        return int(value)
    raise Error(f"{what}: a whole number from {low} to {high} is expected, not {value!r}")


def flag(value: Any, what: str) -> bool:
    """True or False, also as 1 or 0."""
    if isinstance(value, (bool, int, np.bool_)):
        return bool(value)
    raise Error(f"{what}: True or False is expected, not {type(value).__name__}")


def camera_struct(camera: Camera) -> npt.NDArray[Any]:
    """struct rigcal_camera (1,), kept with the camera, which does not change.

    A camera without a size gets one about its principal point: poses, rays and projections
    do not hang on it."""
    struct: npt.NDArray[Any] | None = camera.__dict__.get("_struct")
    if struct is None:
        struct = np.zeros(1, CAMERA)
        fisheye = camera.lens == "fisheye"
        lens = Lenses.RIGCAL_LENS_FISHEYE if fisheye else Lenses.RIGCAL_LENS_BROWN
        size = camera.size or [
            min(max(int(2 * c), 1), 10**6) for c in (camera.cx, camera.cy)
        ]
        struct["lens"], (struct["width"], struct["height"]) = lens, size
        for key in ("fx", "fy", "cx", "cy"):
            struct[key] = getattr(camera, key)
        for key, value in camera.coefficients.items():
            struct[key] = value
        struct.setflags(write=False)
        camera.__dict__["_struct"] = struct
    return struct


def one_camera(camera: Any) -> npt.NDArray[Any]:
    """struct rigcal_camera (1,); Error if it is anything but a Camera."""
    if not isinstance(camera, Camera):
        raise Error(f"camera: a Camera is expected, not {type(camera).__name__}")
    return camera_struct(camera)


def camera_array(cameras: Any, what: str = "camera") -> npt.NDArray[Any]:
    """struct rigcal_camera (n,) of a Camera, or of a list of them."""
    if isinstance(cameras, Camera):
        return camera_struct(cameras)
    if not isinstance(cameras, (list, tuple)) or not cameras:
        raise Error(f"{what}: a Camera or a list of them is expected")
    for camera in cameras:
        if not isinstance(camera, Camera):
            raise Error(f"{what}: {type(camera).__name__} is not a Camera")
    return np.concatenate([camera_struct(camera) for camera in cameras])


def needs_size(camera: Camera, what: str) -> None:
    if camera.size is None:
        raise Error(f"{what}: the size of the image is needed: Camera(..., size=(w, h))")


def transform_struct(transform: Any, what: str) -> npt.NDArray[Any]:
    """struct rigcal_transform (1,)."""
    if not isinstance(transform, Transform):
        raise Error(f"{what}: a Transform is expected, not {type(transform).__name__}")
    struct = np.zeros(1, TRANSFORM)
    struct["R"], struct["t"] = transform.R.ravel(), transform.t
    return struct
