"""Rigid transforms whose frames have names."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from .errors import Error

__all__ = ["Transform"]

Array = npt.NDArray[np.float64]

ROTATION_TOLERANCE = 1e-6  # of an entry of R R^T - I: that of RIGCAL_ERR_ROTATION
SIZE_MAX = 2**31  # numbers in one array
LENGTH_MAX = 1e30  # caller's unit: the library's range of lengths


def check_shape(given: tuple[int, ...], shape: tuple[int, ...] | None, what: str) -> None:
    if shape is not None and given != shape:
        raise Error(f"{what}: shape {shape} is expected, not {given}")
    if math.prod(given) > SIZE_MAX:
        raise Error(f"{what}: shape {given} has more than 2^31 items")


def numbers(value: npt.ArrayLike, shape: tuple[int, ...] | None, what: str) -> Array:
    """`value` as a read-only float64 copy of `shape` (None: any); Error names `what`."""
    expected = (
        "numbers are expected"
        if shape is None
        else f"numbers of shape {shape} are expected"
    )
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise Error(f"{what}: an element is masked")
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "biufO":  # texts, complex numbers, dates
            raise TypeError
        check_shape(given.shape, shape, what)  # before memory for a copy is asked for
        array = np.array(given, np.float64)
    except (TypeError, OverflowError):
        raise Error(f"{what}: {expected}") from None
    except ValueError as error:
        raise error if isinstance(error, Error) else Error(f"{what}: {expected}") from None
    if not np.isfinite(array).all():
        raise Error(f"{what}: an element is NaN or infinite")
    array.setflags(write=False)
    return array


def rotation_from_quat(q_wxyz: npt.ArrayLike) -> Array:
    """3x3 of a quaternion (w, x, y, z) of any length but 0."""
    q = numbers(q_wxyz, (4,), "quaternion")
    largest = np.abs(q).max()
    if largest == 0:
        raise Error("quaternion: its length is 0")
    q = q / largest
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quat_from_rotation(R: Array) -> Array:
    """Unit quaternion (w, x, y, z) with w >= 0, divided by its largest element
    (Shepperd 1978): accurate at every angle."""
    d = np.diag(R)
    four_squares = np.array(
        [
            1 + d.sum(),
            1 + 2 * d[0] - d.sum(),
            1 + 2 * d[1] - d.sum(),
            1 + 2 * d[2] - d.sum(),
        ]
    )
    # Row k holds 4 q[k] q, so the row of the largest q[k] gives q best.
    a, b, c = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    f, g, h = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    s = four_squares
    rows = np.array([[s[0], a, b, c], [a, s[1], f, g], [b, f, s[2], h], [c, g, h, s[3]]])
    q: Array = rows[int(np.argmax(four_squares))]
    q = q / np.sqrt(q @ q)
    return -q if q[0] < 0 else q


def rotation_from_rvec(rvec: npt.ArrayLike) -> Array:
    """3x3 of a rotation vector [rad]: axis times angle (OpenCV's rvec)."""
    w = numbers(rvec, (3,), "rotation vector")
    angle = float(np.sqrt(w @ w))
    if not angle <= 1e6:
        raise Error("rotation vector: longer than 1e6 rad")
    # np.sinc(x) = sin(pi x) / (pi x), which is 1 at 0.
    return rotation_from_quat([np.cos(angle / 2), *(w / 2 * np.sinc(angle / (2 * np.pi)))])


@dataclass(frozen=True, eq=False)
class Transform:
    """Takes coordinates in frame `frm` to frame `to`:  X_to = R X_frm + t.

    R    (3, 3) rotation, to 1e-6
    t    (3,) origin of `frm` in `to`, in the caller's unit of length
    to   name of the frame that coordinates are taken to
    frm  name of the frame that they are taken from

    `a @ b` does b first, then a. It needs a.frm == b.to, and raises Error otherwise.
    """

    R: Array
    t: Array
    to: str = "cam0"
    frm: str = "rig"
    __array_ufunc__: ClassVar[None] = None  # so that an array @ this is a TypeError

    def __post_init__(self) -> None:
        R = numbers(self.R, (3, 3), "R")
        t = numbers(self.t, (3,), "t")
        with np.errstate(over="ignore", invalid="ignore"):
            skew = np.abs(R @ R.T - np.eye(3)).max()
        if not (skew <= ROTATION_TOLERANCE and np.linalg.det(R) > 0):
            raise Error("R: the matrix is not a rotation to 1e-6")
        if not np.abs(t).max() <= LENGTH_MAX:
            raise Error("t: a coordinate is beyond 1e30")
        object.__setattr__(self, "R", R)
        object.__setattr__(self, "t", t)
        for frame in (self.to, self.frm):
            if not isinstance(frame, str):
                raise Error(f"a frame's name must be text, not {frame!r}")

    @classmethod
    def identity(cls, to: str = "cam0", frm: str = "rig") -> Transform:
        """Both frames coincide."""
        return cls(np.eye(3), np.zeros(3), to, frm)

    @classmethod
    def from_rvec(
        cls, rvec: npt.ArrayLike, t: npt.ArrayLike, to: str = "cam0", frm: str = "rig"
    ) -> Transform:
        """From a rotation vector (3,) [rad], OpenCV's rvec, and t (3,)."""
        return cls(rotation_from_rvec(rvec), numbers(t, (3,), "t"), to, frm)

    @classmethod
    def from_quat_wxyz(
        cls, q: npt.ArrayLike, t: npt.ArrayLike, to: str = "cam0", frm: str = "rig"
    ) -> Transform:
        """From a quaternion (w, x, y, z), scalar first, and t (3,)."""
        return cls(rotation_from_quat(q), numbers(t, (3,), "t"), to, frm)

    @classmethod
    def from_matrix(cls, T: npt.ArrayLike, to: str = "cam0", frm: str = "rig") -> Transform:
        """From a 4x4 matrix whose last row is 0 0 0 1."""
        T = numbers(T, (4, 4), "matrix")
        if np.abs(T[3] - [0, 0, 0, 1]).max() > ROTATION_TOLERANCE:
            raise Error("matrix: its last row is not 0 0 0 1")
        return cls(T[:3, :3], T[:3, 3], to, frm)

    @property
    def rvec(self) -> Array:
        """(3,) rotation vector [rad], of length 0 to pi: OpenCV's rvec."""
        q = self.quat_wxyz
        sine = float(np.sqrt(q[1:] @ q[1:]))
        if sine == 0:
            return np.zeros(3)
        vector: Array = q[1:] * (2 * np.arctan2(sine, q[0]) / sine)
        return vector

    @property
    def quat_wxyz(self) -> Array:
        """(4,) unit quaternion (w, x, y, z), w >= 0."""
        return quat_from_rotation(self.R)

    @property
    def matrix(self) -> Array:
        """(4, 4) with the last row 0 0 0 1."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.R, self.t
        return T

    @property
    def center(self) -> Array:
        """(3,) where the origin of `to` is, in `frm`: a camera's centre in the rig."""
        center: Array = -(self.R.T @ self.t)
        return center

    def inv(self) -> Transform:
        """Takes coordinates back from `to` to `frm`."""
        return Transform(self.R.T, self.center, self.frm, self.to)

    def apply(self, X: npt.ArrayLike) -> Array:
        """Points (..., 3) of `frm` in `to`, the same shape."""
        points = numbers(X, None, "X")
        if points.ndim == 0 or points.shape[-1] != 3:
            raise Error(f"X: shape (..., 3) is expected, not {points.shape}")
        moved: Array = points @ self.R.T + self.t
        return moved

    def __matmul__(self, other: Transform) -> Transform:
        if not isinstance(other, Transform):
            return NotImplemented
        if self.frm != other.to:
            raise Error(
                f"{self.to}_from_{self.frm} @ {other.to}_from_{other.frm}: the frames do "
                f"not meet, {self.frm} is not {other.to}"
            )
        return Transform(self.R @ other.R, self.R @ other.t + self.t, self.to, other.frm)

    def _key(self) -> tuple[str | float, ...]:
        return (self.to, self.frm, *self.R.ravel().tolist(), *self.t.tolist())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Transform) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        turn = ", ".join(f"{v:.6g}" for v in self.rvec)
        move = ", ".join(f"{v:.6g}" for v in self.t)
        return f"Transform({self.to}_from_{self.frm}: rvec ({turn}), t ({move}))"
