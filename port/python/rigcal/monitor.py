"""A rig in use: whether a camera has moved, which one, and where it is now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import Array, real, reals, whole
from ._calibrated import CalibratedRig, Pair, Which
from ._layout import (
    BODY_REPORT,
    CALIBRATED_RIG,
    MONITOR_OPTIONS,
    MONITOR_REPORT,
    OBSERVATION,
)
from ._library import address, lib, must
from ._names import RIGCAL_MONITOR_TARGETS_MAX, Status
from .errors import Error
from .transform import Transform

__all__ = ["BodyReport", "Monitor", "MonitorReport"]


@dataclass(frozen=True)
class MonitorReport:
    """What a monitor says: struct rigcal_monitor_report.

    alarm         raised, and not yet answered
    body          the likeliest to have moved; without an alarm, that with most evidence
    confidence    after an alarm, the probability that it was this one: wait some frames
    evidence      log of the sum over its limit: 0 or more raises the alarm
    noise         of the rows over that stated: 1 is as stated; 0: no row yet
    smallest_rad  turn that would have been noticed of the body seen worst; 0: one is blind
    n_blind       bodies with too few rows of late
    frames, rows, doubted, frames_since   counts; frames_since: since the alarm
    """

    alarm: bool
    body: str
    confidence: float
    evidence: float
    noise: float
    smallest_rad: float
    n_blind: int
    frames: int
    rows: int
    doubted: int
    frames_since: int


@dataclass(frozen=True, eq=False)
class BodyReport:
    """What is to be said of one body: struct rigcal_body_report.

    weakest (6,): direction that is known worst, a turn w about the own centre, then a shift
    ds; weakest_sigma [rad] of it
    """

    is_blind: bool
    share: float
    blame: float
    smallest_rad: float
    weakest: Array
    weakest_sigma: float


class Monitor:
    """Watches a calibrated rig, frame by frame. One thread at a time may use it.

    rig         two cameras or more, with their joint covariance
    targets     how many targets are seen at a time, 0 to 16: names target0, target1, ...
    options     of struct rigcal_monitor_options: arl0_frames, common, wrong, walk_rad,
                walk_t, move_rad, move_t

        monitor = rig.monitor()
        for frame in frames:
            monitor.add_matches("left", uv_left, "right", uv_right)
            if monitor.end_frame(seconds=1 / 30).alarm: ...

    Matches must not be chosen by the calibration under test. rigcal_monitor.h tells what it
    cannot see; EQUATIONS.md MONITOR.
    """

    def __init__(self, rig: CalibratedRig, targets: int = 0, **options: float) -> None:
        if not isinstance(rig, CalibratedRig):
            raise Error(f"rig: a calibrated rig is expected, not {type(rig).__name__}")
        targets = whole(targets, "targets", 0, RIGCAL_MONITOR_TARGETS_MAX)
        if rig.sigma_px == 0:
            text = "rig: its poses count as exact, and their covariance is needed"
            raise Error(text, Status.RIGCAL_ERR_STATE.name)
        self._rig = rig
        self.names = rig.names + [f"target{k}" for k in range(targets)]
        values = np.zeros(1, MONITOR_OPTIONS)
        lib.monitor_defaults(address(values))
        for name, value in options.items():
            if name not in (MONITOR_OPTIONS.names or ()):
                raise Error(f"{name}: there is no such option")
            values[name] = real(value, name, 0, 1e30)
        self._memory = np.zeros(max(lib.monitor_size(len(rig), targets), 1))
        status = lib.monitor_begin(
            address(self._memory), len(self._memory), address(rig.struct), targets,
            address(values),
        )  # fmt: skip
        must(status, "rig")
        self._at = address(self._memory)

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_at"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._at = address(self._memory)

    def _body(self, body: Which) -> int:
        """The number of a camera or target."""
        if isinstance(body, str):
            if body not in self.names:
                raise Error(f"there is no {body!r}: {', '.join(self.names)}")
            return self.names.index(body)
        return whole(body, "body", 0, len(self.names) - 1)

    # ---- what is seen ----

    def add_matches(
        self,
        a: Which,
        uv_a: npt.ArrayLike,
        b: Which,
        uv_b: npt.ArrayLike,
        sigma_px: float | None = None,
    ) -> npt.NDArray[np.int32]:
        """n points of the scene, at uv_a (n, 2) of camera a and uv_b (n, 2) of b; the
        Status of each is returned. sigma_px None: the larger noise of the two."""
        i, j = self._rig.number(a, "a"), self._rig.number(b, "b")
        seen_a, seen_b = reals(uv_a, ("n", 2), "uv_a"), reals(uv_b, ("n", 2), "uv_b")
        if len(seen_a) != len(seen_b):
            raise Error(f"uv_a has shape {seen_a.shape} and uv_b {seen_b.shape}")
        noise = self._sigma(sigma_px, [i, j])
        status = np.zeros(len(seen_a), np.int32)
        lib.batch_matches(
            self._at, address(status), i, address(seen_a), j, address(seen_b), noise,
            len(seen_a),
        )  # fmt: skip
        return status

    def add_view(
        self,
        camera: Which,
        X: npt.ArrayLike,
        uv: npt.ArrayLike,
        target: int = 0,
        sigma_px: float | None = None,
    ) -> Status:
        """A camera sees a target: X (n, 3) in its frame, uv (n, 2). Error where it cannot
        be used; RIGCAL_AMBIGUOUS and RIGCAL_POOR_FIT: it was not placed."""
        k = self._rig.number(camera)
        points, pixels = reals(X, ("n", 3), "X"), reals(uv, ("n", 2), "uv")
        if len(points) != len(pixels):
            raise Error(f"X has shape {points.shape} and uv {pixels.shape}")
        observations = np.empty(len(pixels), OBSERVATION)
        observations["X_w"], observations["uv"] = points, pixels
        bad = np.zeros(1, np.int32)
        status = lib.monitor_view(
            self._at, address(bad), k, whole(target, "target", 0, 2**31),
            address(observations), len(pixels), self._sigma(sigma_px, [k]),
        )  # fmt: skip
        return must(status, f"X {points.shape}, uv {pixels.shape}", int(bad[0]))

    def _sigma(self, sigma_px: float | None, cameras: list[int]) -> float:
        if sigma_px is not None:
            return real(sigma_px, "sigma_px", 1e-6, 1e6)
        return float(self._rig.noise_px()[cameras].max())

    def lift(self, target: int = 0) -> None:
        """A target is carried away: it has no place any more."""
        must(lib.monitor_lifted(self._at, whole(target, "target", 0, 2**31)), "target")

    # ---- what it says ----

    def _report(self, report: npt.NDArray[Any]) -> MonitorReport:
        alarm, body, *numbers = report.tolist()[0]
        return MonitorReport(bool(alarm), self.names[body], *numbers)

    def end_frame(self, seconds: float = 0.0) -> MonitorReport:
        """Ends a frame, `seconds` after the last one ended: 0 to 1e6."""
        report, seconds = np.zeros(1, MONITOR_REPORT), real(seconds, "seconds", 0, 1e6)
        must(lib.monitor_frame(address(report), self._at, seconds), "monitor")
        return self._report(report)

    def report(self) -> MonitorReport:
        """The same at any time."""
        report = np.zeros(1, MONITOR_REPORT)
        must(lib.monitor_ask(address(report), self._at), "monitor")
        return self._report(report)

    @staticmethod
    def plot(reports: Sequence[MonitorReport], seconds: Any = None, **options: Any) -> Any:
        """The evidence over time, and who is blamed: see plot_monitor."""
        from .plots import plot_monitor

        return plot_monitor(reports, seconds, **options)

    def body(self, body: Which) -> BodyReport:
        """A camera, or a target by its name."""
        k, report = self._body(body), np.zeros(1, BODY_REPORT)
        must(lib.monitor_body(address(report), self._at, k), self.names[k])
        blind, share, blame, smallest, weakest, sigma = report[0]
        return BodyReport(
            bool(blind), float(share), float(blame), float(smallest), weakest, float(sigma)
        )

    # ---- answers ----

    def moved(self, body: Which) -> None:
        """This body moved: its pose is solved anew, and an alarm is over."""
        k = self._body(body)
        must(lib.monitor_moved(self._at, k), self.names[k])

    def dismiss(self) -> None:
        """Nothing moved: the alarm is over."""
        must(lib.monitor_dismiss(self._at), "monitor")

    # ---- where they are now ----

    def pair(self, a: Which, b: Which) -> Pair:
        """b_from_a of two bodies now, and its covariance."""
        i, j = self._body(a), self._body(b)
        out, Sigma = np.zeros(12), np.zeros(36)
        must(
            lib.monitor_pair(address(out), address(Sigma), self._at, i, j),
            f"{self.names[j]} from {self.names[i]}",
        )
        names = self.names[j], self.names[i]
        return Pair(Transform(out[:9].reshape(3, 3), out[9:], *names), Sigma.reshape(6, 6))

    def rig(self) -> CalibratedRig:
        """All cameras as they are now, with their joint covariance: to measure, to save."""
        old = self._rig
        mounted = old._mounted.copy()
        n = len(mounted)
        group, held = np.zeros(n, np.int32), np.zeros(n, np.uint8)
        size = lib.calibrated_size(n)
        Sigma, struct = np.zeros(size), np.zeros(1, CALIBRATED_RIG)
        struct["cameras"], struct["group"] = address(mounted), address(group)
        struct["held"], struct["capacity"] = address(held), n
        struct["Sigma"], struct["Sigma_capacity"] = address(Sigma), size
        must(lib.monitor_rig(address(struct), self._at), "monitor")
        free = n - int(np.count_nonzero(held))
        return CalibratedRig(
            old.names, mounted, group=group, held=held,
            Sigma=Sigma[: lib.calibrated_size(free)], noise=old.noise,
            sequence=old.sequence, tag=old.tag,
            **{
                field: float(struct[field][0])
                for field in ("sigma_px", "F", "freedom_between", "freedom_within")
            },
        )  # fmt: skip
