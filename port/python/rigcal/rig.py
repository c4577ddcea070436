"""A calibrated rig: its cameras, how sure they are, and what was found."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _tables
from .camera import Camera
from .errors import Error, FileError
from .formats import load_cameras, save_cameras
from .transform import Array, Transform

__all__ = ["Clock", "Fault", "LeftOut", "Pair", "Rig", "load"]

Table = npt.NDArray[Any]  # structured


@dataclass(frozen=True)
class Sigma:
    """How sure a camera's pose in the rig is.

    rotation_deg  standard deviation of the rotation [degrees]
    position      of the camera's centre, in the caller's unit of length
    noise_px      noise of one coordinate of its pixels, by its residuals in the rig
    """

    rotation_deg: float
    position: float
    noise_px: float


@dataclass(frozen=True, eq=False)
class Pair:
    """Camera b from camera a.

    b_from_a      the transform
    covariance    (6, 6) of (w [rad], dt): R <- exp([w]x) R, t <- t + dt; NaN: not known
    rotation_deg, position  standard deviations, as of Sigma
    """

    b_from_a: Transform
    covariance: Array
    rotation_deg: float
    position: float


@dataclass(frozen=True)
class LeftOut:
    """A view that does not count in the rig: why, and what to do."""

    camera: str
    frame: str
    why: str
    advice: str


@dataclass(frozen=True)
class Fault:
    """One thing that may be wrong with the rig as a whole: faults.csv in FORMAT.md.

    name      "clock", "focal", "bent" and so on
    camera, frame  that it is about, or ""
    explains  whether it is the reason that the views disagree
    p         the chance of as much by noise alone; NaN: this recording cannot show it
    gain_px2  what the sum of squares falls by; F_after: F without it
    shows_turn_deg, shows_shift  what a fault that would be seen does to a camera at most
    values, sigmas  how large it is, with standard deviations
    """

    name: str
    camera: str
    frame: str
    explains: bool
    p: float
    gain_px2: float
    F_after: float
    shows_turn_deg: float
    shows_shift: float
    values: tuple[float, ...]
    sigmas: tuple[float, ...]


@dataclass(frozen=True)
class Clock:
    """A camera sees at its stamp t what the others see at t + offset.

    drift  of that, by time; state  "free", "held", "still" or "alone"
    paired_later  its pictures belong to the frame that is so many later than their own
    """

    offset: float
    sigma_offset: float
    drift: float
    sigma_drift: float
    state: str
    paired_later: int


@dataclass(eq=False)
class Rig:
    """What `rigcal.calibrate` and `rigcal.load` return. rig["left"] is a Camera.

    cameras   {name: Camera}; cam_from_rig takes the rig's frame to the camera's
    sigmas    {name: Sigma}: how sure each is
    pairs     {(a, b): Pair} of cameras that share a frame of the target
    joint_covariance  (6 n, 6 n) of (w, dt) of all cameras in their order: w [rad] turns
              about the camera's axes, R <- exp([w]x) R, t <- t + dt. None: not known
    targets   {frame: Transform}: rig_from_target
    views     structured array, a row a view: camera, frame, n, cam_from_target (3, 4),
              rms_px, rotation_deg, position, second_rms_px, probability, verdict
    residuals structured array, a row a point, of the rig: view (row of views), camera,
              frame, point, du, dv, error_px, left_out
    left_out  views that do not count, and why
    F, sqrt_f how many times more than noise the views disagree; None: nothing can
    sigma_px  noise of one coordinate by the rig's residuals; noise_px: by the views
              themselves, or as stated: covariances are for it, times sqrt(F) above 1
    verdict   "agrees", "explained", "found", "unexplained" or None: why views disagree
    cause     the same in sentences
    advice    what to do, and what to shoot next
    faults    what may be wrong with the rig as a whole, the likeliest first
    clocks    {name: Clock}, with times
    report    what the C program prints
    warnings  what it says besides
    """

    cameras: dict[str, Camera]
    sigmas: dict[str, Sigma] = field(default_factory=dict)
    pairs: dict[tuple[str, str], Pair] = field(default_factory=dict)
    joint_covariance: Array | None = None
    targets: dict[str, Transform] = field(default_factory=dict)
    views: Table = field(default_factory=lambda: np.zeros(0, _views_dtype([""], [""])))
    residuals: Table = field(
        default_factory=lambda: np.zeros(0, _residuals_dtype([""], [""], [""]))
    )
    left_out: list[LeftOut] = field(default_factory=list)
    F: float | None = None
    sqrt_f: float | None = None
    sigma_px: float | None = None
    noise_px: float | None = None
    verdict: str | None = None
    cause: str = ""
    advice: list[str] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    clocks: dict[str, Clock] = field(default_factory=dict)
    report: str = ""
    warnings: list[str] = field(default_factory=list)
    stored: bytes = b""  # of rigcal_store_save_rig, or rigcal_store_save

    # ---- as a collection of cameras -------------------------------------------

    def __getitem__(self, name: str) -> Camera:
        try:
            return self.cameras[name]
        except (KeyError, TypeError):
            there = ", ".join(self.cameras)
            raise Error(
                f"there is no camera {name!r} in the rig, which has {there}"
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.cameras)

    def __len__(self) -> int:
        return len(self.cameras)

    def __contains__(self, name: object) -> bool:
        return name in self.cameras

    def __repr__(self) -> str:
        return f"Rig({', '.join(self.cameras)})"

    def __str__(self) -> str:
        return self.report or repr(self)

    # ---- transforms and how sure they are -------------------------------------

    def cam_from_rig(self, name: str) -> Transform:
        """Takes the rig's frame to that of a camera."""
        pose = self[name].cam_from_rig
        if pose is None:
            raise Error(f"camera {name!r} has no pose in the rig")
        return pose

    def between(self, to: str, frm: str) -> Transform:
        """Takes the frame of camera `frm` to that of camera `to`."""
        return self.cam_from_rig(to) @ self.cam_from_rig(frm).inv()

    def covariance(self, camera: str, other: str | None = None) -> Array:
        """(6, 6) of (w, dt) of a camera; with another: of its w, dt with those of it."""
        if self.joint_covariance is None:
            raise Error("the covariance of the rig is not known: README.md tells when")
        names = list(self.cameras)
        a, b = (names.index(self._named(n)) for n in (camera, other or camera))
        rows, columns = slice(6 * a, 6 * a + 6), slice(6 * b, 6 * b + 6)
        return np.array(self.joint_covariance[rows, columns], dtype=np.float64)

    def _named(self, name: str) -> str:
        self[name]
        return name

    # ---- files ----------------------------------------------------------------

    def save(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """The stored bytes, with the joint covariance, as `*.bin` or format "bin"; else
        the cameras in a format of save_cameras, by the file's name or by `format`."""
        if format == "bin" or (format is None and os.fspath(path).endswith(".bin")):
            if not self.stored:
                raise Error("this rig has no stored bytes")
            try:
                pathlib.Path(path).write_bytes(self.stored)
            except OSError as problem:
                raise FileError(path, str(problem.strerror)) from None
            return
        save_cameras(path, self.cameras, format)

    def write_prior(self, path: str | os.PathLike[str]) -> None:
        """rig.csv with each camera's covariance: what is known beforehand."""
        if self.joint_covariance is None:
            raise Error("prior: the covariance of this rig is not known")
        table: dict[str, list[str]] = {"camera": list(self.cameras)}
        poses = [self.cam_from_rig(name) for name in self.cameras]
        numbers = np.array([[*pose.R.ravel(), *pose.t] for pose in poses])
        for name, column in zip(_tables.TRANSFORM, numbers.T.tolist()):
            table[name] = [repr(x) for x in column]
        blocks = [self.covariance(name) for name in self.cameras]
        for name in _tables.COVARIANCE:
            i, j = int(name[1]) - 1, int(name[2]) - 1
            table[name] = [repr(float(block[i, j])) for block in blocks]
        _tables.write(pathlib.Path(path), table)

    @classmethod
    def from_folder(
        cls,
        folder: str | os.PathLike[str],
        cameras: Mapping[str, Camera],
        report: str = "",
        warnings: Sequence[str] = (),
    ) -> Rig:
        """From what `rigcal calibrate --out FOLDER` wrote, and the intrinsics."""
        return _Reader(pathlib.Path(folder), cameras).rig(report, list(warnings))


def load(path: str | os.PathLike[str]) -> Rig:
    """A rig of stored bytes (rig.bin), of a folder of `calibrate`, or of a file of any
    format that has poses."""
    where = pathlib.Path(path)
    if where.is_dir():
        return Rig.from_folder(where, _intrinsics(where))
    _tables.must_exist(path)
    cameras = load_cameras(path)
    posed = {name: c for name, c in cameras.items() if c.cam_from_rig is not None}
    if not posed:
        raise FileError(path, "no camera in it has a pose")
    return Rig(cameras=posed)


def _intrinsics(folder: pathlib.Path) -> dict[str, Camera]:
    stored = list(load_cameras(folder / "rig.bin").values())
    names = _tables.read(folder / "rig.csv")["camera"]
    return dict(zip(names, stored))


# ---- the program's files ------------------------------------------------------


def _text_dtype(texts: Sequence[str]) -> str:
    return f"U{max(map(len, texts), default=1) or 1}"


def _views_dtype(cameras: Sequence[str], frames: Sequence[str]) -> Any:
    return [
        ("camera", _text_dtype(cameras)),
        ("frame", _text_dtype(frames)),
        ("n", "i8"),
        ("cam_from_target", "f8", (3, 4)),
        ("rms_px", "f8"),
        ("rotation_deg", "f8"),
        ("position", "f8"),
        ("second_rms_px", "f8"),
        ("probability", "f8"),
        ("verdict", "U11"),
    ]


def _residuals_dtype(
    cameras: Sequence[str], frames: Sequence[str], points: Sequence[str]
) -> Any:
    return [
        ("view", "i8"),
        ("camera", _text_dtype(cameras)),
        ("frame", _text_dtype(frames)),
        ("point", _text_dtype(points)),
        ("du", "f8"),
        ("dv", "f8"),
        ("error_px", "f8"),
        ("left_out", "?"),
    ]


class _Reader:
    """The files of a folder."""

    def __init__(self, folder: pathlib.Path, cameras: Mapping[str, Camera]) -> None:
        self.folder = folder
        self.given = cameras
        try:
            text = (folder / "summary.json").read_text("utf-8", "surrogateescape")
            self.summary: dict[str, Any] = json.loads(text)
        except OSError as problem:
            raise FileError(folder / "summary.json", str(problem.strerror)) from None
        except ValueError:
            raise FileError(folder / "summary.json", "this is no summary") from None

    def table(self, name: str) -> dict[str, list[str]]:
        path = self.folder / name
        return _tables.read(path) if path.is_file() else {}

    def rig(self, report: str, warnings: list[str]) -> Rig:
        s = self.summary
        table = self.table("rig.csv")
        intrinsics = {**self.given}
        if (self.folder / "cameras.csv").is_file():  # as they were estimated
            intrinsics.update(load_cameras(self.folder / "cameras.csv"))
        cameras = {
            name: replace(
                intrinsics[name],
                name=name,
                cam_from_rig=Transform(R, t, to=name, frm="rig"),
            )
            for name, (R, t) in zip(table["camera"], _tables.transforms(table))
        }
        sigmas = {
            name: Sigma(*numbers)
            for name, *numbers in zip(
                table["camera"],
                *(
                    _tables.numbers_of(table[key]).tolist()
                    for key in ("sigma_rot_deg", "sigma_pos", "sigma_px")
                ),
            )
        }
        views = self.views()
        return Rig(
            cameras=cameras,
            sigmas=sigmas,
            pairs=self.pairs(),
            joint_covariance=_joint(table),
            targets=self.targets(),
            views=views,
            residuals=self.residuals(views),
            left_out=self.left_out(views),
            F=s["F"],
            sqrt_f=s["sqrt_F"],
            sigma_px=s["sigma_px"],
            noise_px=s["noise_px"],
            verdict=s["verdict"],
            cause=s["sentences"] or "",
            advice=self.advice(),
            faults=self.faults(),
            clocks=self.clocks(),
            report=report,
            warnings=warnings,
            stored=(self.folder / "rig.bin").read_bytes(),
        )

    def pairs(self) -> dict[tuple[str, str], Pair]:
        table = self.table("pairs.csv")
        rows = zip(
            table["camera_a"],
            table["camera_b"],
            _tables.transforms(table),
            _tables.covariances(table),
            _tables.numbers_of(table["sigma_rot_deg"]).tolist(),
            _tables.numbers_of(table["sigma_pos"]).tolist(),
        )
        return {
            (a, b): Pair(Transform(R, t, to=b, frm=a), Sigma, deg, position)
            for a, b, (R, t), Sigma, deg, position in rows
        }

    def targets(self) -> dict[str, Transform]:
        table = self.table("targets.csv")
        return {
            frame: Transform(R, t, to="rig", frm="target")
            for frame, (R, t) in zip(table["frame"], _tables.transforms(table))
        }

    def views(self) -> Table:
        table = self.table("poses.csv")
        cameras, frames = table["camera"], table["frame"]
        views = np.zeros(len(cameras), _views_dtype(cameras, frames))
        views["camera"], views["frame"], views["n"] = cameras, frames, table["n"]
        for k, (R, t) in enumerate(_tables.transforms(table)):
            views["cam_from_target"][k] = np.column_stack([R, t])
        for name, key in (
            ("rms_px", "rms_px"),
            ("rotation_deg", "sigma_rot_deg"),
            ("position", "sigma_pos"),
            ("second_rms_px", "second_rms_px"),
            ("probability", "probability"),
        ):
            views[name] = _tables.numbers_of(table[key])
        views["verdict"] = table["verdict"]
        return views

    def residuals(self, views: Table) -> Table:
        table = self.table("residuals.csv")
        cameras, frames, points = (table[key] for key in ("camera", "frame", "point"))
        number = {
            key: k
            for k, key in enumerate(zip(views["camera"].tolist(), views["frame"].tolist()))
        }
        found = np.zeros(len(cameras), _residuals_dtype(cameras, frames, points))
        found["view"] = [number[key] for key in zip(cameras, frames)]
        found["camera"], found["frame"], found["point"] = cameras, frames, points
        for name in ("du", "dv", "error_px"):
            found[name] = _tables.numbers_of(table[name])
        found["left_out"] = [flag == "1" for flag in table["left_out"]]
        return found

    def left_out(self, views: Table) -> list[LeftOut]:
        """Views that the verdict leaves out, and those that have no pose."""
        findings = self.summary["findings"]
        contradict = np.isin(views["verdict"], ["contradicts", "one_of_two"])
        names = [(str(v["camera"]), str(v["frame"])) for v in views[contradict]]
        there = set(zip(views["camera"].tolist(), views["frame"].tolist()))
        for f in findings:
            names += [
                (camera, frame)
                for camera in f["cameras"]
                for frame in f["frames"]
                if (camera, frame) not in there
            ]
        found = []
        for camera, frame in dict.fromkeys(names):
            f = _reason(findings, camera, frame)
            found.append(LeftOut(camera, frame, f["what"], f["advice"]))
        return found

    def advice(self) -> list[str]:
        s = self.summary
        found = [f["advice"] for f in s["findings"] if f["about"] == "rig" and f["advice"]]
        _, next_, last = (s["sentences"] or "").rpartition("Next: ")
        if next_:
            found.append(last.strip())
        if s["next"]:
            found.append(s["next"])
        return found

    def faults(self) -> list[Fault]:
        table = self.table("faults.csv")
        texts = [dict(zip(table, row)) for row in zip(*table.values())]
        return [_fault(text) for text in texts]

    def clocks(self) -> dict[str, Clock]:
        table = self.table("clocks.csv")
        texts = [dict(zip(table, row)) for row in zip(*table.values())]
        return {text["camera"]: _clock(text) for text in texts}


def _clock(text: Mapping[str, str]) -> Clock:
    """One line of clocks.csv."""
    return Clock(
        offset=float(text["offset"]),
        sigma_offset=float(text["sigma_offset"]),
        drift=float(text["drift"]),
        sigma_drift=float(text["sigma_drift"]),
        state=text["state"],
        paired_later=int(text["paired_later"]),
    )


def _fault(text: Mapping[str, str]) -> Fault:
    """One line of faults.csv."""
    known = [k for k in range(1, 7) if text[f"value{k}"]]
    return Fault(
        name=text["fault"],
        camera=text["camera"],
        frame=text["frame"],
        explains=text["explains"] == "1",
        p=float(text["p"] or "nan"),
        gain_px2=float(text["gain_px2"] or "nan"),
        F_after=float(text["F_after"] or "nan"),
        shows_turn_deg=float(text["shows_turn_deg"] or "nan"),
        shows_shift=float(text["shows_shift"] or "nan"),
        values=tuple(float(text[f"value{k}"]) for k in known),
        sigmas=tuple(float(text[f"sigma{k}"]) for k in known),
    )


def _joint(table: Mapping[str, Sequence[str]]) -> Array | None:
    """(6 n, 6 n) of rig.csv; None where it is empty."""
    names = table["camera"]
    own = _tables.covariances(table)
    if not np.isfinite(own).all():
        return None
    joint = np.zeros((6 * len(names), 6 * len(names)))
    for a, name in enumerate(names):
        joint[6 * a : 6 * a + 6, 6 * a : 6 * a + 6] = own[a]
        keys = [f"S{i}{j}@{name}" for i in range(1, 7) for j in range(1, 7)]
        if keys[0] not in table:
            continue
        between = np.array([_tables.numbers_of(table[key]) for key in keys]).T
        for b in range(a + 1, len(names)):
            if np.isfinite(between[b]).all():
                block = between[b].reshape(6, 6)
                joint[6 * b : 6 * b + 6, 6 * a : 6 * a + 6] = block
                joint[6 * a : 6 * a + 6, 6 * b : 6 * b + 6] = block.T
    return joint


def _reason(
    findings: Sequence[Mapping[str, Any]], camera: str, frame: str
) -> Mapping[str, Any]:
    """The finding that is about a view, or else about its camera."""
    for f in findings:
        if camera in f["cameras"] and frame in f["frames"]:
            return f
    for f in findings:
        if camera in f["cameras"] and not f["frames"]:
            return f
    for f in findings:  # the one of two that is named, of another camera of the frame
        if frame in f["frames"]:
            return f
    return {"what": "why is not known", "advice": ""}
