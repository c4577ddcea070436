"""A camera: intrinsics, and where it is in the rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import Error
from .transform import Array, Transform, numbers

__all__ = ["Camera"]

BROWN = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]  # OpenCV's order
FISHEYE = ["k1", "k2", "k3", "k4"]
BROWN_LENGTHS = (0, 4, 5, 8)
SIZE_MAX = 1000000  # pixels: the library's range
COEFFICIENT_MAX = 1e9  # the library's range
PIXEL_MAX = 1e9


def check_dist(dist: Sequence[float], lens: str) -> tuple[float, ...]:
    """The coefficients as a tuple of a length that `lens` has; Error otherwise."""
    values = tuple(numbers(dist, None, "dist").ravel().tolist())
    if not all(abs(v) <= COEFFICIENT_MAX for v in values):
        raise Error("dist: a coefficient is beyond 1e9")
    if lens == "fisheye":
        if len(values) not in (0, 4):
            raise Error(f"dist: a fisheye has 4 coefficients (k1..k4), not {len(values)}")
        return values
    if len(values) in (12, 14):  # OpenCV's longer models
        if any(values[8:12]):
            raise Error("dist: the thin prism model (s1..s4 not 0) is not supported")
        if any(values[12:]):
            raise Error("dist: the tilted sensor model (tau not 0) is not supported")
        return values[:8]
    if len(values) not in BROWN_LENGTHS:
        raise Error(f"dist: 0, 4, 5 or 8 coefficients are expected, not {len(values)}")
    return values


def check_size(size: Any) -> tuple[int, int] | None:
    """(width, height) as integers, None as it is; Error otherwise."""
    if size is None:
        return None
    width, height = numbers(size, (2,), "size").tolist()
    for pixels in (width, height):
        if pixels != int(pixels) or not 1 <= pixels <= SIZE_MAX:
            raise Error(
                f"size: whole pixels, 1 to {SIZE_MAX}, are expected, not {pixels:g}"
            )
    return int(width), int(height)


@dataclass(frozen=True)
class Camera:
    """Intrinsics of a camera and, where known, its pose in the rig.

    fx, fy        focal lengths [px], > 0
    cx, cy        principal point [px]; (0, 0) is the centre of the top-left pixel
    size          (width, height) [px], or None where the source does not say
    dist          k1 k2 p1 p2 [k3 [k4 k5 k6]] of a "brown" lens, k1 k2 k3 k4 of a
                  "fisheye", in OpenCV's order; () is no distortion
    lens          "brown" (OpenCV's standard and rational model) or "fisheye" (OpenCV's
                  fisheye, Kannala-Brandt, equidistant); formulas in rigcal.h, "camera"
    name          of the camera, unique in a rig
    cam_from_rig  X_cam = R X_rig + t, with x right, y down, z forward
    extra         what a file says besides, by the file's own key; not compared
    """

    fx: float
    fy: float
    cx: float
    cy: float
    size: tuple[int, int] | None = None
    dist: tuple[float, ...] = ()
    lens: str = "brown"
    name: str = ""
    cam_from_rig: Transform | None = None
    extra: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        for key in ("fx", "fy", "cx", "cy"):
            value = float(numbers(getattr(self, key), (), key))
            if key[0] == "f" and not 0 < value <= PIXEL_MAX:
                raise Error(f"{key}: a focal length above 0 is expected, in pixels")
            if not abs(value) <= PIXEL_MAX:
                raise Error(f"{key}: the principal point is beyond 1e9 pixels")
            object.__setattr__(self, key, value)
        if not isinstance(self.lens, str) or self.lens not in ("brown", "fisheye"):
            raise Error(f'lens: "brown" or "fisheye" is expected, not {self.lens!r}')
        if not isinstance(self.name, str):
            raise Error(f"name: text is expected, not {self.name!r}")
        if not isinstance(self.cam_from_rig, (Transform, type(None))):
            raise Error("cam_from_rig: a Transform or None is expected")
        object.__setattr__(self, "size", check_size(self.size))
        object.__setattr__(self, "dist", check_dist(self.dist, self.lens))

    @classmethod
    def from_matrix(cls, K: npt.ArrayLike, **fields: Any) -> Camera:
        """From K (3, 3) = fx 0 cx, 0 fy cy, 0 0 1 and the other fields by name."""
        K = numbers(K, (3, 3), "K")
        if K[0, 1] != 0:
            raise Error(f"K: skew is not supported, and it is {K[0, 1]:g}")
        if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
            raise Error("K: fx 0 cx, 0 fy cy, 0 0 1 are expected")
        return cls(K[0, 0], K[1, 1], K[0, 2], K[1, 2], **fields)

    @property
    def matrix(self) -> Array:
        """K, (3, 3): fx 0 cx, 0 fy cy, 0 0 1."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    @property
    def coefficients(self) -> dict[str, float]:
        """All eight of struct rigcal_camera by name: k1 k2 p1 p2 k3 k4 k5 k6."""
        names = FISHEYE if self.lens == "fisheye" else BROWN
        return {**dict.fromkeys(BROWN, 0.0), **dict(zip(names, self.dist))}
