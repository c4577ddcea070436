"""Pixels, rays, points and matching lines, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._arrays import (
    Array,
    camera_struct,
    needs_size,
    numeric,
    one_camera,
    real,
    reals,
    transform_struct,
    whole,
)
from ._layout import BAND, BAND_POINT, MATCH, RAY, SPAN
from ._library import address, lib, must
from ._names import RIGCAL_SPANS_ROW, Status
from ._threads import in_slices
from .camera import Camera
from .errors import Error
from .transform import Transform

if TYPE_CHECKING:
    from ._calibrated import CalibratedRig

__all__ = [
    "Bands",
    "Curves",
    "Matches",
    "Pixels",
    "Points",
    "Rays",
    "Spans",
    "Transfers",
    "distort",
    "pixel_to_ray",
    "project",
    "undistort",
]

Statuses = npt.NDArray[np.int32]


# ---- pixels and rays ----------------------------------------------------------


class Pixels(NamedTuple):
    """uv (n, 2) [px], NaN where there is none, and status (n,) of each: see Status."""

    uv: Array
    status: Statuses


class Rays(NamedTuple):
    """rays (n, 3) of length 1 in the camera's frame, NaN where there is none; status."""

    rays: Array
    status: Statuses


def project(
    camera: Camera, X: npt.ArrayLike, cam_from_world: Transform | None = None
) -> Pixels:
    """The pixels of points, inside the image or not.

    X               (n, 3), in the frame of the camera, or of `cam_from_world`
    cam_from_world  where the camera is; None: X is in its frame

    status: RIGCAL_ERR_BEHIND, not in front; RIGCAL_ERR_NO_RAY, beyond the lens. rigcal.h,
    "camera".
    """
    struct, points = one_camera(camera), reals(X, ("n", 3), "X")
    pose = None
    if cam_from_world is not None:
        pose = transform_struct(cam_from_world, "cam_from_world")
    uv, status = np.empty((len(points), 2)), np.empty(len(points), np.int32)
    lib.batch_project(
        address(uv),
        address(status),
        address(struct),
        None if pose is None else address(pose),
        address(points),
        len(points),
    )
    return Pixels(uv, status)


def of_pixels(function: Any, camera: Camera, uv: npt.ArrayLike, width: int) -> Any:
    """Runs a function of batch.h on each pixel; (n, width) and statuses."""
    struct, pixels = one_camera(camera), reals(uv, ("n", 2), "uv")
    out, status = np.empty((len(pixels), width)), np.empty(len(pixels), np.int32)
    function(address(out), address(status), address(struct), address(pixels), len(pixels))
    return out, status


def pixel_to_ray(camera: Camera, uv: npt.ArrayLike) -> Rays:
    """Unit rays that are imaged at pixels uv (n, 2), distorted as they were seen."""
    return Rays(*of_pixels(lib.batch_rays, camera, uv, 3))


def undistort(camera: Camera, uv: npt.ArrayLike) -> Pixels:
    """Pixels (n, 2) at which the same camera without distortion would see those rays."""
    return Pixels(*of_pixels(lib.batch_undistort, camera, uv, 2))


def distort(camera: Camera, uv: npt.ArrayLike) -> Pixels:
    """Pixels (n, 2) at which the camera sees the rays of undistorted pixels uv."""
    return Pixels(*of_pixels(lib.batch_distort, camera, uv, 2))


# ---- points -------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Points:
    """Points measured by a rig; where one failed its numbers are NaN.

    status   (n,) Status of each: RIGCAL_VIEWS_LEFT_OUT, RIGCAL_POOR_FIT, ...
    used     (n, cameras) which views each point is measured from
    """

    _points: npt.NDArray[Any]
    used: npt.NDArray[np.bool_]
    status: Statuses
    _gains: npt.NDArray[Any] | None
    _rig: CalibratedRig

    def __len__(self) -> int:
        return len(self.status)

    def _field(self, name: str) -> Array:
        numbers: Array = self._points[name]
        return numbers

    @property
    def X(self) -> Array:
        """(n, 3) in the frame of the rig."""
        return self._field("X")

    @property
    def Sigma(self) -> Array:
        """(n, 3, 3) covariance: of the noise of the pixels and of the calibration."""
        return self._field("Sigma").reshape(-1, 3, 3)

    @property
    def Sigma_noise(self) -> Array:
        """(n, 3, 3) covariance of the noise of the pixels alone."""
        return self._field("Sigma_noise").reshape(-1, 3, 3)

    @property
    def sigma(self) -> Array:
        """(n, 3) standard deviations of X, Y and Z."""
        deviations: Array = np.sqrt(self._points["Sigma"][:, ::4])
        return deviations

    @property
    def rms_px(self) -> Array:
        """(n,) reprojection error, root mean square a view that is used [px]."""
        return self._field("rms_px")

    @property
    def chi2(self) -> Array:
        """(n,) chi square of the views of each point, of `freedom` degrees."""
        return self._field("chi2")

    @property
    def freedom(self) -> Array:
        """(n,) degrees of freedom of chi2: 2 a view that is used, less 3."""
        return self._field("freedom")

    @property
    def parallax(self) -> Array:
        """(n,) widest angle between two of its rays [rad]."""
        return self._field("parallax")

    def _point(self, k: int) -> npt.NDArray[Any]:
        """struct rigcal_measured_point (1,), whose pointer is valid: that of a copy of
        these points, or of pickled ones, is not."""
        assert self._gains is not None
        point: npt.NDArray[Any] = self._points[k : k + 1].copy()
        point["gains"] = address(self._gains[k])
        return point

    def distance(self, i: int, j: int, other: Points | None = None) -> tuple[float, float]:
        """How far point i is from point j (of `other`, of the same rig), and the standard
        deviation of that: the calibration's error is common to both and mostly cancels."""
        that = self if other is None else other
        if not isinstance(that, Points):
            raise Error(f"other: Points are expected, not {type(that).__name__}")
        if self._gains is None or that._gains is None:
            raise Error("distance: ask for it: triangulate(..., distances=True)")
        if that._rig is not self._rig:
            raise Error("other: its points are of another rig")
        i, j = range(len(self))[i], range(len(that))[j]
        for points, k in ((self, i), (that, j)):
            must(int(points.status[k]), f"point {k}")
        out, a, b = np.zeros(2), self._point(i), that._point(j)
        status = lib.point_distance(
            address(out), address(out[1:]), address(self._rig.struct), address(a),
            address(b),
        )  # fmt: skip
        must(status, f"distance of points {i} and {j}")
        return float(out[0]), float(out[1])


@dataclass(frozen=True, eq=False)
class Transfers:
    """Where a third camera must see points; NaN where one failed.

    uv (n, 2) [px], Sigma (n, 2, 2) [px^2] without the noise of that camera's own pixels,
    X (n, 3), Sigma_X (n, 3, 3), chi2 (n,) of the match of the two, status (n,)
    """

    uv: Array
    Sigma: Array
    X: Array
    Sigma_X: Array
    chi2: Array
    status: Statuses


# ---- lines, bands, spans ------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Curves:
    """Matching lines in the real, distorted image of b, as up to n places of each band.

    uv          (K, n, 2) [px] from near to far; NaN beyond n_places[k]
    across      (K, n, 2) unit vector across the line
    half_width  (K, n) [px]: the borders are uv -+ half_width across
    depth       (K, n) distance from camera a along its ray; 0: at infinity
    n_places    (K,); places that b cannot see are left out
    status      (K,)
    """

    uv: Array
    across: Array
    half_width: Array
    depth: Array
    n_places: npt.NDArray[np.int32]
    status: Statuses


@dataclass(frozen=True, eq=False)
class Matches:
    """Candidates against bands; index -1 and NaN where there is none.

    index        of the candidate in its array
    is_inside    in the band, the depth in range
    chi2         chi square of 1 for a true match
    distance_px  from the line in the real image, signed
    half_width_px   of the band there
    score        the least is the best match
    depth        distance from camera a along its ray
    n_inside     of a search: (K,) how many candidates are in each band; else None
    status       of each candidate; of a search (K,) of each band
    """

    index: npt.NDArray[np.int32]
    is_inside: npt.NDArray[np.bool_]
    chi2: Array
    distance_px: Array
    half_width_px: Array
    score: Array
    depth: Array
    n_inside: npt.NDArray[np.int32] | None
    status: Statuses


def make_matches(found: Any, n_inside: Any, status: Any) -> Matches:
    return Matches(
        found["index"],
        found["is_inside"] != 0,
        found["chi2"],
        found["distance_px"],
        found["half_width_px"],
        found["score"],
        found["depth_a"],
        n_inside,
        status,
    )


@dataclass(frozen=True, eq=False)
class Spans:
    """Pixels of image b to search, for K bands.

    rows, first, last  (m,) columns first to last of a row, of all bands
    begin              (K + 1,) those of band k are begin[k] to begin[k + 1] - 1
    status             (K,); RIGCAL_ERR_OUTSIDE: no pixel
    size               (width, height) of the image
    """

    rows: npt.NDArray[np.int32]
    first: npt.NDArray[np.int32]
    last: npt.NDArray[np.int32]
    begin: npt.NDArray[np.int64]
    status: Statuses
    size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.status)

    def __getitem__(self, k: int) -> npt.NDArray[np.int32]:
        """(m, 3) row, first, last of band k."""
        k = range(len(self))[k]
        part = slice(self.begin[k], self.begin[k + 1])
        return np.stack([self.rows[part], self.first[part], self.last[part]], 1)

    def mask(self, k: int) -> npt.NDArray[np.bool_]:
        """(height, width): True where to search for the match of pixel k."""
        width, height = self.size
        inside = np.zeros((height, width), np.bool_)
        for row, first, last in self[k].tolist():
            inside[row, first : last + 1] = True
        return inside


SPANS_SLICE = 32  # bands: some tenths of a second at most


@dataclass(frozen=True, eq=False)
class Bands:
    """The bands in image b of K pixels of image a: where a match can be.

    status  (K,) Status: RIGCAL_ERR_EPIPOLE, RIGCAL_ERR_NO_RAY, ...
    """

    _bands: npt.NDArray[Any]
    status: Statuses
    camera_b: Camera

    def __len__(self) -> int:
        return len(self.status)

    def _merged(self, status: Statuses) -> Statuses:
        """The reason why a band does not exist."""
        return np.where(self.status < 0, self.status, status)

    def curve(self, n: int = 64) -> Curves:
        """The middle lines and widths at n >= 2 places each."""
        n = whole(n, "n", 2, 10**6)
        points = np.empty((len(self), n), BAND_POINT)
        count, status = np.empty(len(self), np.int32), np.empty(len(self), np.int32)
        lib.batch_curves(
            address(points), n, address(count), address(status), address(self._bands),
            len(self),
        )  # fmt: skip
        return Curves(
            points["uv"],
            points["across"],
            points["half_width"],
            points["depth_a"],
            count,
            self._merged(status),
        )

    def test(self, uv_b: npt.ArrayLike) -> Matches:
        """Pixel k of uv_b (K, 2) against band k; of one band, any number of pixels."""
        pixels = reals(uv_b, ("n", 2), "uv_b")
        if len(self) not in (1, len(pixels)):
            raise Error(f"uv_b: shape {pixels.shape}, and there are {len(self)} bands")
        found, status = np.empty(len(pixels), MATCH), np.empty(len(pixels), np.int32)
        lib.batch_tests(
            address(found), address(status), address(self._bands), len(self) == 1,
            address(pixels), len(pixels),
        )  # fmt: skip
        return make_matches(found, None, self._merged(status))

    def search(
        self, uv_b: npt.ArrayLike, most: int = 8, threads: int | None = None
    ) -> Matches:
        """Those of the candidates uv_b (m, 2) that are in each band, best first: arrays
        (K, most), index -1 where there are no more."""
        pixels, most = reals(uv_b, ("m", 2), "uv_b"), whole(most, "most", 1, 2**20)
        rays, ray_status = np.empty(len(pixels), RAY), np.empty(len(pixels), np.int32)
        lib.batch_turning_rays(
            address(rays), address(ray_status), address(camera_struct(self.camera_b)),
            address(pixels), len(pixels),
        )  # fmt: skip
        seen = np.flatnonzero(ray_status == 0).astype(np.int32)
        rays = np.ascontiguousarray(rays[seen])
        found = np.empty((len(self), most), MATCH)
        inside, status = np.zeros(len(self), np.int32), np.zeros(len(self), np.int32)

        def search(a: int, b: int) -> None:
            lib.batch_searches(
                address(found[a:]), most, address(inside[a:]), address(status[a:]),
                address(self._bands[a:]), b - a, address(rays), len(rays),
            )  # fmt: skip

        in_slices(search, len(self), SPANS_SLICE, threads)
        index = found["index"]
        if len(seen):
            found["index"] = np.where(index >= 0, seen[np.maximum(index, 0)], -1)
        return make_matches(found, inside, self._merged(status))

    def spans(self, threads: int | None = None) -> Spans:
        """The pixels of image b that are in each band, row by row."""
        needs_size(self.camera_b, "camera b")
        assert self.camera_b.size is not None
        height = self.camera_b.size[1]
        parts: dict[int, tuple[npt.NDArray[Any], npt.NDArray[np.int64]]] = {}
        status = np.zeros(len(self), np.int32)

        def find(a: int, b: int) -> None:
            solver = np.empty(lib.sizes["rigcal_spans_solver"], np.uint8)
            room, done = np.empty(4 * height + 64, SPAN), a
            begin, found = np.zeros(b - a + 1, np.int64), []
            while done < b:
                count = lib.batch_spans(
                    address(room), len(room), address(begin[done - a :]),
                    address(status[done:]), address(solver), address(self._bands[done:]),
                    b - done,
                )  # fmt: skip
                found.append(room[: begin[done - a + count]].copy())
                begin[done - a : done - a + count + 1] += sum(map(len, found[:-1]))
                if count == 0:
                    room = np.empty(height * RIGCAL_SPANS_ROW, SPAN)
                done += count
            parts[a] = np.concatenate(found), begin

        in_slices(find, len(self), SPANS_SLICE, threads)
        spans = [parts[a][0] for a in sorted(parts)]
        counts = [np.diff(parts[a][1]) for a in sorted(parts)]
        begin = np.zeros(len(self) + 1, np.int64)
        if parts:
            np.cumsum(np.concatenate(counts), out=begin[1:])
        all_spans = np.concatenate(spans) if spans else np.empty(0, SPAN)
        return Spans(
            all_spans["row"],
            all_spans["first"],
            all_spans["last"],
            begin,
            self._merged(status),
            self.camera_b.size,
        )


def make_bands(pair: npt.NDArray[Any], uv: npt.ArrayLike, camera_b: Camera) -> Bands:
    """The bands of pixels uv (K, 2) or (2,) by struct rigcal_match_pair."""
    seen = numeric(uv, "uv", "numbers of shape (K, 2)", "fiu")
    pixels = reals(seen[np.newaxis] if seen.shape == (2,) else seen, ("K", 2), "uv")
    bands, status = np.empty(len(pixels), BAND), np.empty(len(pixels), np.int32)
    lib.batch_bands(
        address(bands), address(status), address(pair), address(pixels), len(pixels)
    )
    return Bands(bands, status, camera_b)


def match_k(probability: float, purpose: int) -> float:
    """Standard deviations for a probability: rigcal_match_k."""
    k = np.zeros(1)
    share = real(probability, "probability", 0.001, 0.999999)
    must(lib.match_k(address(k), share, purpose), "probability")
    return float(k[0])


def failed(status: int) -> bool:
    return status < 0 or status == Status.RIGCAL_DISCONNECTED
