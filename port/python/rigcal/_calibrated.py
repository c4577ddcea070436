"""A calibrated rig: its cameras with their joint covariance, and what it measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._arrays import (
    Array,
    flag,
    numeric,
    one_camera,
    real,
    reals,
    transform_struct,
    whole,
)
from ._layout import (
    CALIBRATED_RIG,
    MATCH_PAIR,
    MEASURED_POINT,
    MOUNTED_CAMERA,
    POINT_GAIN,
    SAVED_INFO,
    SIGHTINGS,
    TRANSFER,
)
from ._library import address, lib, must
from ._names import RIGCAL_STORE_CAMERAS_MAX, Lenses, MatchPurposes, Status
from ._threads import in_slices
from .camera import BROWN, FISHEYE, Camera
from .errors import Error
from .measure import Bands, Curves, Points, Spans, Transfers, make_bands, match_k
from .transform import Transform

if TYPE_CHECKING:
    from .monitor import Monitor

__all__ = ["CalibratedRig", "Pair"]

Which = Union[int, str]  # a camera: its number or its name
POINTS_SLICE = 256  # points: some milliseconds


class Pair(NamedTuple):
    """b_from_a and its covariance (6, 6) of (w, dt); None: not known."""

    transform: Transform
    covariance: Array | None


class CalibratedRig:
    """Cameras in one frame. Arrays are those of struct rigcal_calibrated_rig.

    names      of the cameras, in their order
    sigma_px   the noise that the covariance is for; 0: there is none, poses count as exact
    F, freedom_between, freedom_within   how much the views disagree: rigcal_rig.h
    group      (n,) cameras of different groups have no common frame
    held       (n,) True: the camera has no unknowns
    noise      (n,) noise of a pixel's coordinate of each camera, or None: sigma_px of all
    sequence, tag   numbers of the caller's, of any meaning, that the stored form keeps
    """

    def __init__(
        self,
        names: Sequence[str],
        mounted: npt.NDArray[Any],
        *,
        group: npt.ArrayLike | None = None,
        held: npt.ArrayLike | None = None,
        Sigma: npt.ArrayLike | None = None,
        sigma_px: float = 0.0,
        F: float = 0.0,
        freedom_between: float = 0.0,
        freedom_within: float = 0.0,
        noise: npt.ArrayLike | None = None,
        sequence: int = 0,
        tag: int = 0,
    ) -> None:
        n = len(names)
        if not 1 <= n <= RIGCAL_STORE_CAMERAS_MAX or len(set(names)) != n:
            raise Error("names: one or more different names are expected")
        if mounted.shape != (n,) or mounted.dtype != MOUNTED_CAMERA:
            raise Error(f"mounted: struct rigcal_mounted_camera ({n},) is expected")
        self.names = [str(name) for name in names]
        self._mounted = np.ascontiguousarray(mounted).copy()
        self._group = np.zeros(n, np.int32)
        self._group[:] = 0 if group is None else np.asarray(group)
        self._held = np.zeros(n, np.uint8)
        self._held[:] = 0 if held is None else np.asarray(held)
        free = n - int(np.count_nonzero(self._held))
        size = lib.calibrated_size(free) if sigma_px > 0 else 0
        self._Sigma = np.zeros(max(size, 1))
        if size:
            self._Sigma[:] = reals([] if Sigma is None else Sigma, (size,), "Sigma")
        self.sigma_px, self.F = float(sigma_px), float(F)
        self.sequence = whole(sequence, "sequence", 0, 2**32 - 1)
        self.tag = whole(tag, "tag", 0, 2**32 - 1)
        self.freedom_between = float(freedom_between)
        self.freedom_within = float(freedom_within)
        self.noise = None if noise is None else self._noise_of(noise, "noise")
        self.struct = self._make_struct(size)

    def _make_struct(self, size: int) -> npt.NDArray[Any]:
        """struct rigcal_calibrated_rig (1,) with pointers to the arrays of this rig."""
        struct = np.zeros(1, CALIBRATED_RIG)
        struct["cameras"], struct["group"] = address(self._mounted), address(self._group)
        struct["held"], struct["Sigma"] = address(self._held), address(self._Sigma)
        struct["capacity"] = struct["n_cameras"] = len(self.names)
        struct["Sigma_capacity"] = size
        for field in ("sigma_px", "F", "freedom_between", "freedom_within"):
            struct[field] = getattr(self, field)
        return struct

    def __getstate__(self) -> dict[str, Any]:
        """All but the struct, whose pointers are valid only in this process."""
        return {key: value for key, value in self.__dict__.items() if key != "struct"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.struct = self._make_struct(len(self._Sigma) if self.sigma_px > 0 else 0)

    # ---- made from, and into ----

    @classmethod
    def from_cameras(cls, cameras: Mapping[str, Camera] | Sequence[Camera]) -> Any:
        """From cameras with cam_from_rig, whose poses then count as exact."""
        if not isinstance(cameras, (Mapping, Sequence)):
            raise Error(f"cameras: several are expected, not {type(cameras).__name__}")
        listed = list(cameras.values() if isinstance(cameras, Mapping) else cameras)
        structs = [one_camera(camera) for camera in listed]
        if isinstance(cameras, Mapping):
            names = list(cameras)
        else:
            names = [camera.name or f"cam{k}" for k, camera in enumerate(listed)]
        mounted = np.zeros(len(listed), MOUNTED_CAMERA)
        for name, camera, struct, to in zip(names, listed, structs, mounted):
            if camera.cam_from_rig is None:
                raise Error(f"camera {name}: it has no cam_from_rig")
            to["camera"] = struct[0]
            to["cam_from_rig"] = transform_struct(camera.cam_from_rig, name)[0]
        rig = cls(names, mounted)
        for k, camera in enumerate(listed):
            if camera.size is None:
                rig._sizeless = {*rig._sizeless, k}
        return rig

    _sizeless: frozenset[int] | set[int] = frozenset()  # cameras whose size is not known

    @classmethod
    def from_bytes(cls, data: bytes, names: Sequence[str] | None = None) -> Any:
        """From the stored form (rigcal.h, "store"); names None: cam0, cam1, ..."""
        try:
            bytes_ = np.frombuffer(data, np.uint8)
        except (TypeError, ValueError):  # no bytes, or with gaps between them
            raise Error(f"data: bytes are expected, not {type(data).__name__}") from None
        info = np.zeros(1, SAVED_INFO)
        must(lib.store_info(address(info), address(bytes_), len(bytes_)), "bytes")
        n, free = int(info["n_cameras"][0]), max(int(info["n_free"][0]), 0)
        if names is not None and not isinstance(names, Sequence):
            raise Error(f"names: {n} are expected, not {type(names).__name__}")
        if names is not None and len(names) != n:
            raise Error(f"names: {n} are expected, not {len(names)}")
        size = lib.calibrated_size(free)
        mounted, group = np.zeros(n, MOUNTED_CAMERA), np.zeros(n, np.int32)
        held, Sigma = np.zeros(n, np.uint8), np.zeros(max(size, 1))
        struct = np.zeros(1, CALIBRATED_RIG)
        struct["cameras"], struct["group"] = address(mounted), address(group)
        struct["held"], struct["capacity"] = address(held), n
        struct["Sigma"], struct["Sigma_capacity"] = address(Sigma), size
        must(
            lib.store_load_rig(
                address(struct), address(info), address(bytes_), len(bytes_)
            ),
            "bytes",
        )
        return cls(
            names or [f"cam{k}" for k in range(n)],
            mounted,
            group=group,
            held=held,
            Sigma=Sigma[:size],
            sequence=int(info["sequence"][0]),
            tag=int(info["tag"][0]),
            **{
                field: float(struct[field][0])
                for field in ("sigma_px", "F", "freedom_between", "freedom_within")
            },
        )

    def to_bytes(self) -> bytes:
        """The stored form, the same from every machine; names are not in it."""
        n, sequence, tag = len(self.names), self.sequence, self.tag
        n_bytes = np.zeros(1, np.uintp)
        if self.sigma_px > 0:
            free = n - int(np.count_nonzero(self._held))
            out = np.zeros(lib.store_rig_size(n, free), np.uint8)
            status = lib.store_save_rig(
                address(out),
                len(out),
                address(n_bytes),
                address(self.struct),
                sequence,
                tag,
            )
        else:
            out = np.zeros(lib.store_size(n), np.uint8)
            status = lib.store_save(
                address(out), len(out), address(n_bytes), address(self._mounted), n,
                sequence, tag,
            )  # fmt: skip
        must(status, "rig")
        return out[: int(n_bytes[0])].tobytes()

    # ---- its cameras ----

    def __len__(self) -> int:
        return len(self.names)

    def number(self, camera: Which, argument: str = "") -> int:
        """The number of a camera of this name; argument: the one that names it."""
        if isinstance(camera, str):
            if camera not in self.names:
                known, where = ", ".join(self.names), argument and f"{argument}: "
                raise Error(f"{where}there is no camera {camera!r} in this rig: {known}")
            return self.names.index(camera)
        return whole(camera, argument or "camera", 0, len(self.names) - 1)

    def __getitem__(self, camera: Which) -> Camera:
        """A camera with its cam_from_rig."""
        k = self.number(camera)
        mounted = self._mounted[k]
        lens, width, height, fx, fy, cx, cy = mounted["camera"].tolist()[:7]
        is_fisheye = lens == Lenses.RIGCAL_LENS_FISHEYE
        dist = [float(mounted["camera"][key]) for key in (FISHEYE if is_fisheye else BROWN)]
        if not is_fisheye:
            while dist and dist[-1] == 0:
                dist.pop()
            least = next(n for n in (0, 4, 5, 8) if n >= len(dist))
            dist += [0.0] * (least - len(dist))
        transform = mounted["cam_from_rig"]
        return Camera(
            fx, fy, cx, cy,
            size=None if k in self._sizeless else (width, height),
            dist=tuple(dist),
            lens="fisheye" if is_fisheye else "brown",
            name=self.names[k],
            cam_from_rig=Transform(
                transform["R"].reshape(3, 3), transform["t"], self.names[k], "rig"
            ),
        )  # fmt: skip

    @property
    def cameras(self) -> dict[str, Camera]:
        """{name: Camera}, each with its cam_from_rig."""
        return {name: self[name] for name in self.names}

    @property
    def group(self) -> npt.NDArray[np.int32]:
        """(n,) numbers: cameras of different groups have no common frame."""
        group: npt.NDArray[np.int32] = self._group.copy()
        return group

    @property
    def held(self) -> npt.NDArray[np.bool_]:
        """(n,) True: the camera has no unknowns."""
        held: npt.NDArray[np.bool_] = self._held != 0
        return held

    def covariance(self, camera: Which, other: Which | None = None) -> Array:
        """(6, 6) of (w, dt) of a camera's pose; of two cameras, the cross covariance."""
        a = self.number(camera)
        b = a if other is None else self.number(other)
        if self.sigma_px == 0 and a == b and self._mounted["has_Sigma"][a]:
            own: Array = self._mounted["Sigma"][a].reshape(6, 6).copy()
            return own
        Sigma = np.zeros(36)
        must(
            lib.calibrated_covariance(address(Sigma), address(self.struct), a, b),
            f"the covariance of {self.names[a]}",
        )
        return Sigma.reshape(6, 6)

    def pair(self, a: Which, b: Which) -> Pair:
        """b_from_a, and its covariance with the cross terms of both."""
        i, j = self.number(a, "a"), self.number(b, "b")
        if self.sigma_px == 0:
            if self._group[i] != self._group[j]:
                must(Status.RIGCAL_DISCONNECTED, f"{self.names[j]} from {self.names[i]}")
            to, frm = self[j].cam_from_rig, self[i].cam_from_rig
            assert to is not None
            assert frm is not None
            return Pair(to @ frm.inv(), None)
        out, Sigma = np.zeros(12), np.zeros(36)
        must(
            lib.calibrated_pair(address(out), address(Sigma), address(self.struct), i, j),
            f"{self.names[j]} from {self.names[i]}",
        )
        names = self.names[j], self.names[i]
        return Pair(Transform(out[:9].reshape(3, 3), out[9:], *names), Sigma.reshape(6, 6))

    # ---- noise ----

    def _noise_of(self, value: Any, what: str) -> Array:
        """(n,) of a number, of (n,) numbers, or of a dict by name."""
        if isinstance(value, Mapping):
            numbers = np.full(len(self.names), np.nan)
            for name, number in value.items():
                which = self.number(name, what)
                numbers[which] = real(number, f"{what}[{name!r}]", 1e-6, 1e6)
            return numbers
        if numeric(value, what, "a number, or one of each camera,", "fiu").ndim == 0:
            return np.full(len(self.names), real(value, what, 1e-6, 1e6))
        array = reals(value, (len(self.names),), what)
        for number in array.tolist():
            real(number, what, 1e-6, 1e6)
        return array

    def noise_px(self, sigma_px: Any = None) -> Array:
        """(n,) noise of a pixel's coordinate of each camera: as given, or of this rig."""
        if sigma_px is not None:
            return self._noise_of(sigma_px, "sigma_px")
        if self.noise is not None:
            return self.noise
        if self.sigma_px > 0:
            return np.full(len(self.names), self.sigma_px)
        raise Error("sigma_px: this rig does not know the noise of a pixel: state it")

    # ---- what it measures ----

    def _pixels(self, uv: Any) -> tuple[list[Array | None], int]:
        """The pixels of each camera, None for one without, and the number of points."""
        if isinstance(uv, Mapping):
            seen: list[Array | None] = [None] * len(self.names)
            for name, pixels in uv.items():
                seen[self.number(name, "uv")] = reals(pixels, ("n", 2), f"uv[{name!r}]")
            counts = {array.shape for array in seen if array is not None}
            if len(counts) != 1:
                raise Error(f"uv: as many pixels of each camera are expected, not {counts}")
            return seen, counts.pop()[0]
        array = reals(uv, (len(self.names), "n", 2), "uv")
        return list(array), array.shape[1]

    def triangulate(
        self,
        uv: Mapping[str, npt.ArrayLike] | npt.ArrayLike,
        *,
        sigma_px: Any = None,
        parallax_least: float = 0.0,
        keep_all: bool = False,
        distances: bool = False,
        threads: int | None = None,
    ) -> Points:
        """n points from what two or more cameras saw of them, with their covariance.

        uv              of each camera by its name, (n, 2) each; or (cameras, n, 2). NaN: it
                        did not see that point. Pixels as seen, distorted
        sigma_px        noise of a pixel's coordinate: a number, (cameras,) or by name;
                        None: that of the rig
        parallax_least  angle [rad] that the widest two rays must have; 0: 0.1 degree
        keep_all        True: no view is dropped, whatever it says
        distances       True: keep what Points.distance needs
        threads         None: one a core

        rigcal_point.h; EQUATIONS.md POINT.
        """
        seen, n = self._pixels(uv)
        noise, cameras = self.noise_px(sigma_px), len(self.names)
        least = real(parallax_least, "parallax_least", 0, np.pi / 2)
        keep_all, distances = flag(keep_all, "keep_all"), flag(distances, "distances")
        points, status = np.zeros(n, MEASURED_POINT), np.zeros(n, np.int32)
        used = np.zeros((n, cameras), np.bool_)
        gains = np.zeros((n, cameras), POINT_GAIN) if distances else None
        room = lib.point_work(cameras)

        def measure(a: int, b: int) -> None:
            work = np.empty(room)
            where = np.array([0 if x is None else address(x[a:]) for x in seen], np.uintp)
            s = np.zeros(1, SIGHTINGS)
            s["rig"], s["sigma_px"] = address(self.struct), address(noise)
            s["parallax_least"], s["keep_all"] = least, keep_all
            s["work"], s["work_capacity"] = address(work), room
            lib.batch_points(
                address(points[a:]), address(used[a:]), address(status[a:]),
                None if gains is None else address(gains[a:]), address(s), address(where),
                b - a,
            )  # fmt: skip

        in_slices(measure, n, POINTS_SLICE, threads)
        return Points(points, used, status, gains, self)

    def transfer(
        self,
        a: Which,
        uv_a: npt.ArrayLike,
        b: Which,
        uv_b: npt.ArrayLike,
        c: Which,
        *,
        sigma_px: Any = None,
    ) -> Transfers:
        """Where camera c must see what a sees at uv_a (n, 2) and b at uv_b (n, 2)."""
        seen_a, seen_b = reals(uv_a, ("n", 2), "uv_a"), reals(uv_b, ("n", 2), "uv_b")
        if len(seen_a) != len(seen_b):
            raise Error(f"uv_a has shape {seen_a.shape} and uv_b {seen_b.shape}")
        n = len(seen_a)
        numbers = [self.number(x, name) for x, name in zip((a, b, c), "abc")]
        abc, noise = np.array(numbers, np.uintp), self.noise_px(sigma_px)
        sigma_ab = noise[numbers[:2]]
        out, status = np.zeros(n, TRANSFER), np.zeros(n, np.int32)
        lib.batch_transfers(
            address(out), address(status), address(self.struct), address(abc),
            address(seen_a), address(seen_b), address(sigma_ab), n,
        )  # fmt: skip
        return Transfers(
            out["uv"], out["Sigma"].reshape(-1, 2, 2), out["X"],
            out["Sigma_X"].reshape(-1, 3, 3), out["chi2"], status,
        )  # fmt: skip

    def band(
        self,
        a: Which,
        uv: npt.ArrayLike,
        b: Which,
        *,
        depth: tuple[float, float | None] = (0.0, None),
        probability: float = 0.99,
        sigma_px: Any = None,
    ) -> Bands:
        """The bands in image b in which the matches of pixels uv (K, 2) of a must be.

        depth        nearest and farthest distance from camera a along the ray; None: no end
        probability  that the true match is within
        sigma_px     as of triangulate

        rigcal_match.h; EQUATIONS.md MATCH.
        """
        i, j = self.number(a, "a"), self.number(b, "b")
        if i == j:
            raise Error(f"a and b are one camera, {self.names[i]}: a line takes two")
        if not isinstance(depth, (tuple, list)) or len(depth) != 2:
            raise Error("depth: (nearest, farthest) are expected")
        near = real(depth[0], "depth", 0, 1e30)
        far = 0.0 if depth[1] is None else real(depth[1], "depth", 0, 1e30)
        if depth[1] is not None and not far > near:
            raise Error(
                f"depth: the farthest, {far:g}, is not beyond the nearest, {near:g}"
            )
        noise = self.noise_px(sigma_px)
        if sigma_px is not None or self.noise is not None:  # sigma_px of the rig has it
            noise = noise * max(1.0, self.F) ** 0.5
        known = self.pair(i, j)
        pair = np.zeros(1, MATCH_PAIR)
        camera = self._mounted["camera"]
        pair["camera_a"], pair["camera_b"] = address(camera[i:]), address(camera[j:])
        pair["b_from_a"] = transform_struct(known.transform, "pair")
        if known.covariance is not None:
            pair["Sigma"] = known.covariance.ravel()
        pair["sigma_a"], pair["sigma_b"] = noise[i], noise[j]
        pair["k"] = match_k(probability, MatchPurposes.RIGCAL_MATCH_SEARCH)
        pair["near_a"], pair["far_a"] = near, far
        return make_bands(pair, uv, self[j])

    def match_line(
        self,
        a: Which,
        uv: npt.ArrayLike,
        b: Which,
        *,
        depth: tuple[float, float | None] = (0.0, None),
        n: int = 64,
        **options: Any,
    ) -> Curves:
        """The matching lines in the real image of b of pixels uv (K, 2) of a, as curves of
        n places with the band's half width: band(...).curve(n)."""
        return self.band(a, uv, b, depth=depth, **options).curve(n)

    def spans(
        self,
        a: Which,
        uv: npt.ArrayLike,
        b: Which,
        *,
        depth: tuple[float, float | None] = (0.0, None),
        threads: int | None = None,
        **options: Any,
    ) -> Spans:
        """The pixels of image b to search for the matches of uv (K, 2) of a, row by row:
        band(...).spans()."""
        return self.band(a, uv, b, depth=depth, **options).spans(threads)

    def monitor(self, **options: Any) -> Monitor:
        """Watches this rig while it runs: see Monitor."""
        from .monitor import Monitor

        return Monitor(self, **options)
