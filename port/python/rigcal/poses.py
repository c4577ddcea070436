"""Poses of cameras from views of known points, one or many at a time."""

from __future__ import annotations

import collections
import functools
import warnings
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _arrays
from ._arrays import (
    Array,
    camera_array,
    flag,
    indices,
    numeric,
    one_camera,
    real,
    reals,
    whole,
)
from ._layout import (
    BLAME,
    DIAGNOSIS,
    OBSERVATION,
    POSE,
    POSE_OPTIONS,
    RESULT,
    ROBUST_OPTIONS,
    SOLVED,
    UNCERTAINTY,
    VIEW,
    VIEWS,
)
from ._library import address, lib, must
from ._names import RIGCAL_POSES_MAX, BlameVerdicts, DiagnosisVerdicts, Status
from ._threads import in_slices
from .camera import Camera
from .errors import Caveat, Error
from .transform import Transform

__all__ = [
    "Blame",
    "Diagnosis",
    "Pose",
    "Poses",
    "blame",
    "diagnose",
    "solve_pose",
    "solve_poses",
    "solve_tag",
    "solve_tags",
]

Ragged = Union[npt.ArrayLike, "list[npt.ArrayLike]"]
SLICE = 256  # views: some 4 ms of one core, so that an interrupt is soon heard


# ---- what comes out -----------------------------------------------------------


class Pose:
    """A camera's pose: X_cam = R X_world + t, x right, y down, z forward.

    status       a Status: 0, or a caveat, which `warnings` has by name too
    rms_px       reprojection error, root mean square a point
    probability  that this is the right one of those found, for normal noise
    others       the other poses that were found, best first
    bad          point that a caveat is of; None
    """

    def __init__(
        self,
        found: Array,
        status: Status,
        bad: int | None = None,
        uncertainty: Array | None = None,
        inliers: npt.NDArray[np.bool_] | None = None,
        frames: tuple[str, str] = ("cam", "world"),
    ) -> None:
        # Reals, not structs: NumPy copies structs ten times as slowly.
        self._numbers = found
        self._sure = uncertainty
        self._inliers = inliers
        self._frames = frames
        self.status = status
        self.bad = bad

    @property
    def _found(self) -> npt.NDArray[Any]:
        """struct rigcal_pose, as many as were found."""
        return self._numbers.view(POSE)[:, 0]

    @functools.cached_property
    def cam_from_world(self) -> Transform:
        """The pose, with the names of its frames."""
        transform = self._found["cam_from_world"][0]
        return Transform(transform["R"].reshape(3, 3), transform["t"], *self._frames)

    @property
    def rms_px(self) -> float:
        """Reprojection error, root mean square a point [px]."""
        return float(self._found["rms_px"][0])

    @property
    def sse(self) -> float:
        """Sum of |du|^2 / sigma_i^2 over the points [px^2 where no sigma is given]."""
        return float(self._found["sse"][0])

    @property
    def probability(self) -> float:
        """That this is the right one of those found, for normal noise."""
        return float(self._found["probability"][0])

    @property
    def others(self) -> list[Pose]:
        """The other poses that were found, best first."""
        return [
            Pose(self._numbers[k : k + 1], self.status, frames=self._frames)
            for k in range(1, len(self._numbers))
        ]

    @property
    def warnings(self) -> list[str]:
        """Names of caveats: ["RIGCAL_AMBIGUOUS"]; [] is none."""
        return [self.status.name] if self.status > 0 else []

    @property
    def inliers(self) -> npt.NDArray[np.bool_] | None:
        """(n,) which points agree, of a robust pose; None of another."""
        return self._inliers

    def _known(self, field: str) -> Array:
        if self._sure is None:
            raise Error(f"{field}: how sure this pose is, is not known")
        known: Array = self._sure.view(UNCERTAINTY)[field][0]
        return known

    @property
    def covariance(self) -> Array:
        """(6, 6) of (w, dt): R <- exp([w]x) R, t <- t + dt, along the camera's axes."""
        return self._known("Sigma").reshape(6, 6)

    @property
    def sigma_rotation(self) -> Array:
        """(3,) standard deviations of w [rad]."""
        return self._known("rotation")

    @property
    def sigma_translation(self) -> Array:
        """(3,) standard deviations of t."""
        return self._known("translation")

    @property
    def sigma_center(self) -> Array:
        """(3,) standard deviations of the camera's centre, along the world's axes."""
        return self._known("center")

    @property
    def sigma_px(self) -> float:
        """The noise of a pixel's coordinate that the covariance is for."""
        return float(self._known("sigma_px"))

    def __repr__(self) -> str:
        return (
            f"Pose({self.cam_from_world!r}, rms {self.rms_px:.3g} px, "
            f"probability {self.probability:.3g}, {self.status.name})"
        )


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of K views as arrays. Where a view failed its numbers are NaN.

    status       (K,) int32: Status of each; below 0 it failed
    R, t         (K, 3, 3), (K, 3): X_cam = R X_world + t
    rms_px, sse, probability   (K,)
    n_found      (K,) poses of each view; `P[k].others` has those beyond the first
    bad          (K,) the point at fault, -1
    inliers      of each point of each view, in the shape of uv; None: not robust
    """

    _poses: npt.NDArray[Any]
    _results: npt.NDArray[Any]
    _uncertainties: npt.NDArray[Any] | None
    _first: npt.NDArray[np.int64]
    inliers: npt.NDArray[np.bool_] | None
    _frames: list[tuple[str, str]]
    _camera_of: npt.NDArray[np.int32] | None

    def __len__(self) -> int:
        return len(self._results)

    @property
    def status(self) -> npt.NDArray[np.int32]:
        """(K,) Status of each; below 0 it failed."""
        status: npt.NDArray[np.int32] = self._results["status"]
        return status

    @property
    def names(self) -> list[str]:
        """(K) names of the statuses."""
        return [Status(s).name for s in self.status.tolist()]

    @property
    def n_found(self) -> npt.NDArray[np.int32]:
        """(K,) how many poses of each view were found."""
        found: npt.NDArray[np.int32] = self._results["n_found"]
        return found

    @property
    def bad(self) -> npt.NDArray[np.int32]:
        """(K,) the point at fault; -1: none."""
        bad: npt.NDArray[np.int32] = self._results["at_fault"]
        return bad

    def _of_best(self, field: str) -> Array:
        numbers: Array = self._poses[field][:, 0]
        return numbers

    @property
    def R(self) -> Array:
        """(K, 3, 3) of cam_from_world."""
        rotations: Array = self._poses["cam_from_world"]["R"][:, 0].reshape(-1, 3, 3)
        return rotations

    @property
    def t(self) -> Array:
        """(K, 3) of cam_from_world."""
        moves: Array = self._poses["cam_from_world"]["t"][:, 0]
        return moves

    @property
    def rms_px(self) -> Array:
        """(K,) reprojection error, root mean square a point [px]."""
        return self._of_best("rms_px")

    @property
    def sse(self) -> Array:
        """(K,) sum of |du|^2 / sigma_i^2 over the points [px^2 where no sigma is given]."""
        return self._of_best("sse")

    @property
    def probability(self) -> Array:
        """(K,) that each is the right one of those found, for normal noise."""
        return self._of_best("probability")

    def _known(self, field: str) -> Array:
        if self._uncertainties is None:
            raise Error(f"{field}: ask for it: solve_poses(..., covariance=True)")
        known: Array = self._uncertainties[field]
        return known

    @property
    def covariance(self) -> Array:
        """(K, 6, 6) of (w, dt) as of Pose."""
        return self._known("Sigma").reshape(-1, 6, 6)

    @property
    def sigma_rotation(self) -> Array:
        """(K, 3) [rad]."""
        return self._known("rotation")

    @property
    def sigma_center(self) -> Array:
        """(K, 3) of the centre, along the world's axes."""
        return self._known("center")

    def __getitem__(self, k: int) -> Pose:
        """View k; Error where it failed."""
        k = range(len(self))[k]
        status, covariance, bad, n_found, _ = self._results[k].tolist()
        got = must(status, f"view {k}", None if bad < 0 else bad)
        first, end = self._first[k : k + 2].tolist()
        flat = None if self.inliers is None else self.inliers.reshape(-1)[first:end]
        table = self._uncertainties
        return Pose(
            as_reals(self._poses[k])[:n_found],
            got,
            None if bad < 0 else bad,
            as_reals(table)[k] if table is not None and covariance == 0 else None,
            flat,
            self._frames[0 if self._camera_of is None else int(self._camera_of[k])],
        )


# ---- options ------------------------------------------------------------------


def pose_options(
    sigma_px: float | None, start: Transform | None
) -> npt.NDArray[Any] | None:
    """struct rigcal_pose_options; None: all defaults."""
    if sigma_px is None and start is None:
        return None
    options = np.zeros(1, POSE_OPTIONS)
    lib.pose_defaults(address(options))
    if sigma_px is not None:
        options["sigma_px"] = real(sigma_px, "sigma_px", 1e-6, 1e6)
    if start is not None:
        options["use_start"] = 1
        options["start"] = _arrays.transform_struct(start, "start")
    return options


def robust_options(
    sigma_px: float | None,
    threshold_px: float | None,
    samples: int | None,
    seed: int | None,
    max_units: int | None,
) -> npt.NDArray[Any]:
    """struct rigcal_robust_options; None: the default of each."""
    options = np.zeros(1, ROBUST_OPTIONS)
    lib.robust_defaults(address(options))
    if sigma_px is not None:
        options["sigma_px"] = real(sigma_px, "sigma_px", 1e-6, 1e6)
    if threshold_px is not None:
        options["threshold_px"] = real(threshold_px, "threshold_px", 1e-6, 1e6)
    if samples is not None:
        options["samples"] = whole(samples, "samples", 1, 100000)
    if seed is not None:
        options["seed"] = whole(seed, "seed", 0, 2**32 - 1)
    if max_units is not None:
        options["max_units"] = whole(max_units, "max_units", 1, 2**31 - 1)
    return options


def not_robust(*options: Any) -> None:
    """Error if an option of struct rigcal_robust_options is given to another solver."""
    if any(option is not None for option in options):
        raise Error("threshold_px, samples, seed, max_units: for robust=True")


def frames_of(camera: Camera) -> tuple[str, str]:
    return (camera.name or "cam", "world")


# ---- one pose -----------------------------------------------------------------


def as_reals(structs: npt.NDArray[Any]) -> Array:
    """(n, reals) of structs (n,) that consist of reals alone."""
    numbers: Array = structs.view(np.float64).reshape(len(structs), -1)
    return numbers


class Block:
    """Memory of one call: kept for the next one, since making it takes longer than a
    pose."""

    def __init__(self) -> None:
        self.poses = as_reals(np.zeros(RIGCAL_POSES_MAX, POSE))
        self.result = np.zeros(1, RESULT)
        self.uncertainty = as_reals(np.zeros(1, UNCERTAINTY))[0]
        self.first = np.zeros(2, np.int64)
        self.solved = np.zeros(1, SOLVED)
        self.solved["poses"], self.solved["most"] = address(self.poses), RIGCAL_POSES_MAX
        self.solved["results"] = address(self.result)
        self.solved["uncertainties"] = address(self.uncertainty)
        self.inliers = self.solved["inliers"]
        self.views = np.zeros(1, VIEWS)
        self.views["first"] = address(self.first)
        self.cameras, self.X, self.uv, self.sigma = (
            self.views[field] for field in ("cameras", "X", "uv", "sigma")
        )
        self.solved_at, self.views_at = address(self.solved), address(self.views)
        self.make_room(64)

    def make_room(self, n: int) -> None:
        """Allocates work memory for views of n points."""
        self.room = n
        self.work = np.empty(6 * n)
        self.work_at = address(self.work)


BLOCKS: collections.deque[Block] = collections.deque(maxlen=64)


def take_block() -> Block:
    try:
        return BLOCKS.pop()
    except IndexError:
        return Block()


def matched(X: npt.ArrayLike, uv: npt.ArrayLike, sigma: Any) -> tuple[Array, Array, Any]:
    """The points of one view, their pixels and their sigma or None, as C arrays."""
    points, pixels = reals(X, ("n", 3), "X"), reals(uv, ("n", 2), "uv")
    if len(points) != len(pixels):
        raise Error(
            f"X has shape {points.shape} and uv {pixels.shape}: as many are expected"
        )
    if sigma is not None:
        sigma = reals(sigma, (len(pixels),), "sigma")
    return points, pixels, sigma


def refuse(status: int, bad: int, arrays: dict[str, Array | None]) -> None:
    """Raises the Error of a failed pose. It names an argument that is not finite."""
    at = None if bad < 0 else bad
    if status == Status.RIGCAL_ERR_NOT_FINITE:
        for name, array in arrays.items():
            if array is not None and not np.isfinite(array).all():
                raise Error(
                    f"{name}: an element is NaN or infinite; its shape is {array.shape}",
                    Status(status).name,
                    at,
                )
    shapes = ", ".join(f"{n} {a.shape}" for n, a in arrays.items() if a is not None)
    must(status, shapes, at)


def warn(status: Status, stacklevel: int) -> None:
    if status > 0:
        warnings.warn(f"{status.name}: {status.text}", Caveat, stacklevel=stacklevel + 1)


def solve_pose(
    camera: Camera,
    X: npt.ArrayLike,
    uv: npt.ArrayLike,
    *,
    sigma: npt.ArrayLike | None = None,
    sigma_px: float | None = None,
    start: Transform | None = None,
    robust: bool = False,
    threshold_px: float | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_units: int | None = None,
) -> Pose:
    """The pose of one camera from n >= 3 points (robust: 5), without a guess.

    camera        its lens; its cam_from_rig is not used
    X             (n, 3) points in the frame of the target or world
    uv            (n, 2) the pixels that they were seen at, distorted
    sigma         (n,) standard deviations of the points relative to each other
    sigma_px      noise of a pixel's coordinate, if it is known
    start         a previous pose: only the optimum near it is looked for
    robust        some points are wrong: find those that agree (Pose.inliers);
                  threshold_px, samples, seed, max_units: struct
                  rigcal_robust_options

    Raises Error where there is no pose; warns with Caveat of one that is not sure.
    rigcal.h, "pose" and "robust"; EQUATIONS.md A to D.
    """
    points, pixels, factors = matched(X, uv, sigma)
    struct, n = one_camera(camera), len(pixels)
    inliers = None
    robust = flag(robust, "robust")
    if robust:
        if start is not None:
            raise Error("start: a robust pose has no start")
        options: npt.NDArray[Any] | None = robust_options(
            sigma_px, threshold_px, samples, seed, max_units
        )
        inliers = np.zeros(n, np.bool_)
    else:
        not_robust(threshold_px, samples, seed, max_units)
        options = pose_options(sigma_px, start)

    block = take_block()
    try:
        if n > block.room:
            block.make_room(n)
        block.cameras[0], block.first[1] = address(struct), n
        block.X[0], block.uv[0] = address(points), address(pixels)
        block.sigma[0] = 0 if factors is None else address(factors)
        block.inliers[0] = 0 if inliers is None else address(inliers)
        solve = lib.batch_robust if robust else lib.batch_poses
        solve(
            block.solved_at,
            block.work_at,
            block.views_at,
            1,
            None if options is None else address(options),
        )
        status, covariance, bad, n_found, _ = block.result.tolist()[0]
        found = block.poses[:n_found].copy()
        uncertainty = block.uncertainty.copy() if covariance == 0 else None
    finally:
        BLOCKS.append(block)
    if status < 0:
        refuse(status, bad, {"X": points, "uv": pixels, "sigma": factors})
    got = Status(status)
    if got > 0:
        warn(got, 2)
    at = None if bad < 0 else bad
    return Pose(found, got, at, uncertainty, inliers, frames_of(camera))


# ---- many poses ---------------------------------------------------------------


def offsets(counts: Any) -> npt.NDArray[np.int64]:
    """(K + 1,) where each view begins, from the number of its points."""
    first = np.zeros(len(counts) + 1, np.int64)
    np.cumsum(counts, out=first[1:])
    return first


def joined(parts: Any, width: int, what: str) -> tuple[Array, list[int]]:
    """A list of (n_k, width) arrays as one, and their lengths."""
    arrays = [reals(part, ("n", width), f"{what}[{k}]") for k, part in enumerate(parts)]
    empty: list[Array] = [np.zeros((0, width))]
    return np.concatenate(arrays or empty), [len(array) for array in arrays]


@dataclass
class Batch:
    """Views of a batch as struct rigcal_batch_views has them."""

    X: Array
    uv: Array
    sigma: Array | None
    first: npt.NDArray[np.int64]
    is_one_target: bool

    @property
    def longest(self) -> int:
        return int(np.diff(self.first).max(initial=0))


def one_target(X: Array, counts: npt.NDArray[np.int64] | list[int]) -> None:
    for k, count in enumerate(counts):
        if count != len(X):
            raise Error(f"X has shape {X.shape}, and view {k} has {count} pixels")


def ragged(X: Any, uv: Any, n: npt.ArrayLike) -> Batch:
    """Views one after the other: uv (sum of n, 2)."""
    counts = indices(n, ("K",), "n", _arrays.COUNT_MAX)
    pixels, points = reals(uv, ("sum of n", 2), "uv"), reals(X, ("n", 3), "X")
    first = offsets(counts)
    if first[-1] != len(pixels):
        raise Error(f"uv has shape {pixels.shape}, and the sum of n is {first[-1]}")
    is_one = len(points) != len(pixels)
    if is_one:
        one_target(points, counts.tolist())
    return Batch(points, pixels, None, first, is_one)


POINTS = "numbers of shape (n, 3) or (K, n, 3)", "fiu"


def batch(X: Any, uv: Any, n: npt.ArrayLike | None) -> Batch:
    """Views of any of the forms that solve_poses takes."""
    if n is not None:
        return ragged(X, uv, n)
    if isinstance(uv, (list, tuple)):
        pixels, counts = joined(uv, 2, "uv")
        if isinstance(X, np.ndarray) and X.ndim == 3:
            X = list(X)
        if isinstance(X, (list, tuple)) and X and numeric(X[0], "X", *POINTS).ndim == 2:
            points, of_points = joined(X, 3, "X")
            if of_points != counts:
                raise Error(f"X has views of {of_points} points, and uv of {counts}")
            return Batch(points, pixels, None, offsets(counts), False)
        points = reals(X, ("n", 3), "X")
        one_target(points, counts)
        return Batch(points, pixels, None, offsets(counts), True)
    pixels = reals(uv, ("K", "n", 2), "uv")
    views, count, _ = pixels.shape
    is_one = numeric(X, "X", *POINTS).ndim == 2
    points = reals(X, (count, 3) if is_one else (views, count, 3), "X")
    first = np.arange(views + 1, dtype=np.int64) * count
    return Batch(points, pixels, None, first, is_one)


def sigma_of(sigma: Any, views: Batch, is_list: bool) -> Array:
    """The sigma of each point of a batch, whose views were a list or one array."""
    if is_list and isinstance(sigma, (list, tuple)):
        counts = np.diff(views.first).tolist()
        if len(sigma) != len(counts):
            raise Error(f"sigma: {len(counts)} views are expected, not {len(sigma)}")
        parts = [
            reals(part, (count,), f"sigma[{k}]")
            for k, (part, count) in enumerate(zip(sigma, counts))
        ]
        return np.concatenate([*parts, np.zeros(0)])
    return reals(sigma, views.uv.shape[:-1], "sigma")


def solve_poses(
    camera: Camera | list[Camera],
    X: Ragged,
    uv: Ragged,
    n: npt.ArrayLike | None = None,
    *,
    camera_of: npt.ArrayLike | None = None,
    sigma: npt.ArrayLike | None = None,
    sigma_px: float | None = None,
    robust: bool = False,
    threshold_px: float | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_units: int | None = None,
    covariance: bool = False,
    most: int = 1,
    threads: int | None = None,
) -> Poses:
    """The poses of K views in one call; a view that fails does not stop the others.

    camera      of all views, or a list, and camera_of (K,) which of them each view is of
    X, uv       (K, n, 3) and (K, n, 2); or X (n, 3), the same target in every view; or
                lists of (n_k, 3) and (n_k, 2); or, with n (K,) the number of points of
                each view, all views one after the other, (sum n, 3) and (sum n, 2)
    sigma       of each point, in the shape of uv without its last axis; of a list of
                views, a list of (n_k,) or (sum n_k,)
    covariance  True: how sure each is, too: some 10 % more time
    most        poses kept of each view: 1 to 4; `P[k].others`
    threads     None: one a core. Python's other threads run during it

    All else as of solve_pose. Contiguous float64 arrays are read where they are.
    """
    views = batch(X, uv, n)
    count = len(views.first) - 1
    cameras = camera_array(camera)
    which = None
    if camera_of is not None:
        which = indices(camera_of, (count,), "camera_of", len(cameras)).astype(np.int32)
    elif len(cameras) != 1:
        raise Error(
            f"camera_of: {len(cameras)} cameras, and not said which view is of which"
        )
    if sigma is not None:
        views.sigma = sigma_of(sigma, views, n is None and isinstance(uv, (list, tuple)))
    robust = flag(robust, "robust")
    if robust:
        options: npt.NDArray[Any] | None = robust_options(
            sigma_px, threshold_px, samples, seed, max_units
        )
    else:
        not_robust(threshold_px, samples, seed, max_units)
        options = pose_options(sigma_px, None)
    most = whole(most, "most", 1, RIGCAL_POSES_MAX)

    poses = np.empty((count, most), POSE)
    results = np.empty(count, RESULT)
    uncertainties = np.empty(count, UNCERTAINTY) if flag(covariance, "covariance") else None
    inliers = np.zeros(views.uv.shape[:-1], np.bool_) if robust else None
    work = views.longest

    def solve(a: int, b: int) -> None:
        block = np.zeros(1, VIEWS)
        block["cameras"], block["X"] = address(cameras), address(views.X)
        block["camera_of"] = 0 if which is None else address(which[a:])
        block["uv"], block["first"] = address(views.uv), address(views.first[a:])
        block["sigma"] = 0 if views.sigma is None else address(views.sigma)
        block["is_one_target"] = views.is_one_target
        solved = np.zeros(1, SOLVED)
        solved["poses"], solved["most"] = address(poses[a:]), most
        solved["results"] = address(results[a:])
        solved["uncertainties"] = 0 if uncertainties is None else address(uncertainties[a:])
        solved["inliers"] = 0 if inliers is None else address(inliers)
        memory = np.empty(6 * work)
        (lib.batch_robust if robust else lib.batch_poses)(
            address(solved),
            address(memory),
            address(block),
            b - a,
            None if options is None else address(options),
        )

    in_slices(solve, count, SLICE, threads)
    frames = [frames_of(c) for c in ([camera] if isinstance(camera, Camera) else camera)]
    return Poses(poses, results, uncertainties, views.first, inliers, frames, which)


# ---- tags ---------------------------------------------------------------------


def solve_tags(
    camera: Camera,
    corners: npt.ArrayLike,
    size: float,
    *,
    sigma_px: float | None = None,
    most: int = 2,
    threads: int | None = None,
) -> Poses:
    """The poses of K square tags, each by its four corners.

    corners  (K, 4, 2) pixels: top left, top right, bottom right, bottom left as the tag is
             read. That is ArUco's order; of AprilTag's detectors reverse it, and subtract
             0.5: they count from the pixel's corner
    size     length of the edge, in the unit of t

    The tag's frame: origin in its middle, x right, y up, z out of it. rigcal.h, "tag".
    """
    pixels = reals(corners, ("K", 4, 2), "corners")
    length = real(size, "size", 0, 1e30)
    most = whole(most, "most", 1, RIGCAL_POSES_MAX)
    struct, options = one_camera(camera), pose_options(sigma_px, None)
    count = len(pixels)
    poses, results = np.empty((count, most), POSE), np.empty(count, RESULT)
    uncertainties = np.empty(count, UNCERTAINTY)

    def solve(a: int, b: int) -> None:
        solved = np.zeros(1, SOLVED)
        solved["poses"], solved["most"] = address(poses[a:]), most
        solved["results"] = address(results[a:])
        solved["uncertainties"] = address(uncertainties[a:])
        lib.batch_tags(
            address(solved),
            address(struct),
            address(pixels[a:]),
            length,
            b - a,
            None if options is None else address(options),
        )

    in_slices(solve, count, SLICE, threads)
    first = np.arange(count + 1, dtype=np.int64) * 4
    frames = [(camera.name or "cam", "tag")]
    return Poses(poses, results, uncertainties, first, None, frames, None)


def solve_tag(
    camera: Camera, corners: npt.ArrayLike, size: float, *, sigma_px: float | None = None
) -> Pose:
    """The pose of one square tag: see solve_tags. corners (4, 2)."""
    pixels = reals(corners, (4, 2), "corners")
    tags = solve_tags(camera, pixels[np.newaxis], size, sigma_px=sigma_px, threads=1)
    if tags.status[0] < 0:
        refuse(int(tags.status[0]), int(tags.bad[0]), {"corners": pixels})
    pose = tags[0]
    warn(pose.status, 2)
    return pose


# ---- what is wrong --------------------------------------------------------------


@dataclass(frozen=True)
class Blame:
    """Which point is to blame for a bad fit: struct rigcal_blame.

    verdict         RIGCAL_BLAME_NONE, _LIKELY or _SURE
    point           without which the rest agree best; None: no rest has a pose
    is_rest_poor    whether the rest fit badly too
    rms_px          of all points; None: they have no pose
    rms_without_px  without that point
    chance          that noise alone does as much
    probability     that it is this point, if it is one of them
    rms_without     (n,) without each point [px]; NaN: not known
    """

    verdict: BlameVerdicts
    point: int | None
    is_rest_poor: bool
    rms_px: float | None
    rms_without_px: float
    chance: float
    probability: float
    rms_without: Array


@dataclass(frozen=True)
class Diagnosis:
    """What would make a bad fit consistent: struct rigcal_diagnosis.

    verdict    RIGCAL_DIAGNOSIS_CONSISTENT, _UNITS, _ONE_POINT, _MIRRORED, _UNEXPLAINED
    is_handed  whether the data decide if they are mirrored
    rms_mirrored_px, rms_flipped_px   with the target, or the image, mirrored; None: no pose
    units      factor of the length of t to that of `start`; None: no such factor
    """

    verdict: DiagnosisVerdicts
    is_handed: bool
    rms_mirrored_px: float | None
    rms_flipped_px: float | None
    units: float | None
    blame: Blame


def known(number: float, least: float = 0) -> float | None:
    return float(number) if number >= least else None


def make_blame(struct: Any, rms_without: Array) -> Blame:
    return Blame(
        BlameVerdicts(int(struct["verdict"])),
        None if struct["point"] < 0 else int(struct["point"]),
        bool(struct["is_rest_poor"]),
        known(struct["rms_px"]),
        float(struct["rms_without_px"]),
        float(struct["chance"]),
        float(struct["probability"]),
        np.where(rms_without < 0, np.nan, rms_without),
    )


def examine(
    dtype: np.dtype[Any],
    function: Any,
    camera: Camera,
    X: Any,
    uv: Any,
    sigma: Any,
    options: Any,
) -> tuple[Any, Array]:
    """Runs rigcal_pose_blame or _diagnose on one view."""
    points, pixels, factors = matched(X, uv, sigma)
    struct = one_camera(camera)
    observations = np.empty(len(pixels), OBSERVATION)
    observations["X_w"], observations["uv"] = points, pixels
    view = np.zeros(1, VIEW)
    view["camera"], view["observations"] = address(struct), address(observations)
    view["sigma"] = 0 if factors is None else address(factors)
    view["n"] = len(pixels)
    out, without = np.zeros(1, dtype), np.zeros(len(pixels))
    at_options = None if options is None else address(options)
    status = function(address(out), address(without), address(view), at_options)
    if status < 0:
        refuse(status, -1, {"X": points, "uv": pixels, "sigma": factors})
    return out[0], without


def blame(
    camera: Camera,
    X: npt.ArrayLike,
    uv: npt.ArrayLike,
    *,
    sigma: npt.ArrayLike | None = None,
    sigma_px: float | None = None,
) -> Blame:
    """Which one of n >= 5 points to blame for a bad fit; arguments as of solve_pose."""
    options = pose_options(sigma_px, None)
    return make_blame(*examine(BLAME, lib.pose_blame, camera, X, uv, sigma, options))


def diagnose(
    camera: Camera,
    X: npt.ArrayLike,
    uv: npt.ArrayLike,
    *,
    sigma: npt.ArrayLike | None = None,
    sigma_px: float | None = None,
    start: Transform | None = None,
) -> Diagnosis:
    """Whether n >= 5 points fit and, if not, what would make them: one wrong point,
    mirrored coordinates, other units than `start`, a previous pose, has."""
    if isinstance(camera, Camera):
        _arrays.needs_size(camera, "camera")
    options = pose_options(sigma_px, start)
    found, without = examine(DIAGNOSIS, lib.pose_diagnose, camera, X, uv, sigma, options)
    return Diagnosis(
        DiagnosisVerdicts(int(found["verdict"])),
        bool(found["is_handed"]),
        known(found["rms_mirrored_px"]),
        known(found["rms_flipped_px"]),
        known(found["units"], 1e-9),
        make_blame(found["blame"], without),
    )
