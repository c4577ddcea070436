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
from ._calibrated import CalibratedRig, Pair
from .camera import Camera
from .errors import Error, FileError, path_of
from .formats import load_cameras, save_cameras, stored
from .formats._common import read_file
from .measure import Bands, Curves, Points, Spans, Transfers
from .monitor import Monitor
from .transform import Array, Transform

__all__ = ["Clock", "Fault", "LeftOut", "Rig", "Sigma", "load"]

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

    calibrated  cameras with their joint covariance, and what is measured with them
    cameras   {name: Camera}; cam_from_rig takes the rig's frame to the camera's
    sigmas    {name: Sigma}: how sure each is; of cameras whose covariance is known
    targets   {frame: Transform}: rig_from_target
    views     structured array, a row a view: camera, frame, n, cam_from_target (3, 4),
              rms_px, rotation_deg, position, second_rms_px, probability, verdict
    residuals structured array, a row a point, of the rig: view (row of views), camera,
              frame, point, X, Y, Z, u, v, du, dv, error_px, left_out; X to v as detected
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
    made      how: names of files, options, by what they are
    images    {(camera, frame): path, (video, number) or array}, if detections had them
    """

    calibrated: CalibratedRig
    cameras: dict[str, Camera]
    sigmas: dict[str, Sigma] = field(default_factory=dict)
    targets: dict[str, Transform] = field(default_factory=dict)
    views: Table = field(default_factory=lambda: np.zeros(0, _views_dtype([], [])))
    residuals: Table = field(
        default_factory=lambda: np.zeros(0, _residuals_dtype([], [], []))
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
    made: dict[str, str] = field(default_factory=dict)
    stored: bytes = b""  # of the library's store
    images: dict[tuple[str, str], Any] = field(default_factory=dict)

    # ---- as a collection of cameras -------------------------------------------

    def __getitem__(self, name: str) -> Camera:
        self.calibrated.number(str(name))
        return self.cameras[str(name)]

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

    def cam_from_rig(self, camera: str) -> Transform:
        """Takes the rig's frame to that of a camera."""
        pose = self[camera].cam_from_rig
        assert pose is not None
        return pose

    def between(self, to: str, frm: str) -> Transform:
        """Takes the frame of camera `frm` to that of camera `to`."""
        return self.cam_from_rig(to) @ self.cam_from_rig(frm).inv()

    def pair(self, a: str, b: str) -> Pair:
        """b_from_a and its covariance (6, 6) of (w, dt); None: not known."""
        return self.calibrated.pair(a, b)

    def covariance(self, camera: str, other: str | None = None) -> Array:
        """(6, 6) of (w, dt) of a camera; with another one, the cross covariance.

        R <- exp([w]x) R, t <- t + dt: w [rad] and dt are along the camera's axes."""
        return self.calibrated.covariance(camera, other)

    @property
    def joint_covariance(self) -> Array:
        """(6 n, 6 n) of (w, dt) of all cameras, in their order."""
        return np.block([[self.covariance(a, b) for b in self] for a in self])

    # ---- what it measures ----------------------------------------------------

    def triangulate(self, uv: Any, **options: Any) -> Points:
        """n points that two or more cameras saw: see CalibratedRig.triangulate.

        uv  {camera: (n, 2)} of pixels, NaN where it did not see the point. Points have the
            covariance of noise and calibration together."""
        if options.get("sigma_px") is None:
            options["sigma_px"] = self.noise_px
        return self.calibrated.triangulate(uv, **options)

    def match_line(self, a: str, uv: Any, b: str, **options: Any) -> Curves:
        """Where b sees the points behind pixels uv (K, 2) of a, as curves in its image with
        half the width of their band: see CalibratedRig.match_line."""
        return self.calibrated.match_line(a, uv, b, **options)

    def band(self, a: str, uv: Any, b: str, **options: Any) -> Bands:
        """The bands of image b that hold the matches: see CalibratedRig.band."""
        return self.calibrated.band(a, uv, b, **options)

    def spans(self, a: str, uv: Any, b: str, **options: Any) -> Spans:
        """The pixels of image b to search, row by row: see CalibratedRig.spans."""
        return self.calibrated.spans(a, uv, b, **options)

    def transfer(
        self, a: str, uv_a: Any, b: str, uv_b: Any, c: str, **options: Any
    ) -> Transfers:
        """Where c must see what a and b see: see CalibratedRig.transfer."""
        return self.calibrated.transfer(a, uv_a, b, uv_b, c, **options)

    def monitor(self, **options: Any) -> Monitor:
        """Watches the rig while it runs: see Monitor."""
        return self.calibrated.monitor(**options)

    # ---- pictures -------------------------------------------------------------

    def plot(
        self,
        *,
        ax: Any = None,
        dark: bool = False,
        k: float = 3.0,
        exaggeration: float | None = None,
        boards: bool = True,
    ) -> Any:
        """The rig in space: cameras as frustums of their image, boards as outlines, and how
        sure each centre is as an ellipsoid. Returns the figure.

        k             half axes of the ellipsoids, in standard deviations
        exaggeration  how many times as large they are drawn; None: so that they are seen.
                      The title tells it
        boards        False: without them
        ax            3-D axes of Matplotlib to draw on; dark: for a dark background

        Scales are equal, up is as the cameras stand. Needs rigcal[plot], as all pictures.
        """
        from . import plots

        return plots.plot_rig(
            self, ax=ax, dark=dark, k=k, exaggeration=exaggeration, boards=boards
        )

    def plot_residuals(
        self,
        cameras: str | Sequence[str] | None = None,
        *,
        scale: float | None = None,
        most: int | None = None,
        ax: Any = None,
        dark: bool = False,
    ) -> Any:
        """Residuals of the rig as arrows, a panel a camera, from where the rig puts a point
        towards where it was seen. Points left out are crosses. Returns the figure.

        cameras  names; None: all
        scale    how many times as long as they are; None: so that they are seen. The
                 title tells it
        most     arrows of a camera; None: as many as can be told apart
        ax       axes to draw on, of one camera
        """
        from . import plots

        return plots.plot_residuals(
            self, cameras=cameras, scale=scale, most=most, ax=ax, dark=dark
        )

    def plot_views(self, *, worst: int = 5, ax: Any = None, dark: bool = False) -> Any:
        """The rms of each view in the rig, the worst of them named. Returns the figure."""
        from . import plots

        return plots.plot_views(self, worst=worst, ax=ax, dark=dark)

    def plot_graph(self, *, ax: Any = None, dark: bool = False) -> Any:
        """How many frames each two cameras share, and who saw the target when; what is left
        out is dashed. Returns the figure.

        ax  axes to draw the first of the two on
        """
        from . import plots

        return plots.plot_graph(self, ax=ax, dark=dark)

    def plot_match(self, a: str, uv: Any, b: str, **options: Any) -> Any:
        """Where b sees the points behind pixels uv (K, 2) of a. Returns the figure.

        images      a pair, of a and of b: arrays or paths; None: blank, of the true sizes
        candidates  (m, 2) pixels of b: dots; those in a band are rings, the best are stars
        depth, probability, sigma_px   as of CalibratedRig.band
        dark        for a dark background
        """
        from . import plots

        return plots.plot_match(self, a, uv, b, **options)

    # ---- files ----------------------------------------------------------------

    def html(self, path: str | os.PathLike[str], title: str | None = None) -> None:
        """Writes one page with all there is to say of the rig: the verdict, what to do,
        pictures, tables. It needs nothing besides: no network, no other file.

        It is light or dark as the reader's system is, at most html.BYTES_MOST large, and
        there whole or not at all. Names of files are in it, no folders.
        """
        from .html import write_page

        write_page(self, path, title)

    def save(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """The stored bytes, with the joint covariance, as `*.bin` or format "stored"; else
        the cameras in a format of save_cameras, by the file's name or by `format`."""
        path = path_of(path)
        if format == "stored" or (format is None and path.endswith(".bin")):
            try:
                pathlib.Path(path).write_bytes(self.stored or self.calibrated.to_bytes())
            except OSError as problem:
                raise FileError(path, str(problem.strerror)) from None
        else:
            save_cameras(path, self.cameras, format)

    def write_prior(self, path: str | os.PathLike[str]) -> None:
        """rig.csv with the covariances of cameras and between them: what is known
        beforehand."""
        names = list(self)
        table: dict[str, list[str]] = {"camera": names}
        poses = [self.cam_from_rig(name) for name in self]
        numbers = np.array([[*pose.R.ravel(), *pose.t] for pose in poses])
        for name, column in zip(_tables.TRANSFORM, numbers.T.tolist()):
            table[name] = [repr(x) for x in column]
        blocks = [self.covariance(name) for name in self]
        for name in _tables.COVARIANCE:
            i, j = int(name[1]) - 1, int(name[2]) - 1
            table[name] = [repr(float(block[i, j])) for block in blocks]
        for k, other in enumerate(names[:-1] if self.calibrated.sigma_px > 0 else []):
            across = [self.covariance(name, other) for name in names[k + 1 :]]
            for i, j in np.ndindex(6, 6):
                numbers_of_later = [repr(float(block[i, j])) for block in across]
                table[f"S{i + 1}{j + 1}@{other}"] = [""] * (k + 1) + numbers_of_later
        _tables.write(pathlib.Path(path), table)

    @classmethod
    def from_folder(
        cls,
        folder: str | os.PathLike[str],
        report: str = "",
        warnings: Sequence[str] = (),
        given: Mapping[str, Camera] | None = None,
    ) -> Rig:
        """From what `rigcal calibrate --out FOLDER` wrote. given: cameras whose `extra`
        is kept."""
        reader = _Reader(pathlib.Path(path_of(folder, "folder")))
        try:
            return reader.rig(report, list(warnings), given or {})
        except FileError:
            raise
        except (ValueError, LookupError, TypeError, AttributeError) as problem:
            what = "this file is damaged, or of another run than the others"
            raise FileError(reader.folder / reader.reading, f"{what}: {problem}") from None


def load(path: str | os.PathLike[str], names: Sequence[str] | None = None) -> Rig:
    """A rig of stored bytes, of a folder of `calibrate`, or of cameras with poses in a file
    of any format. names: of the cameras of stored bytes, which do not hold them; None:
    those of the rig.csv beside a rig.bin, or cam0, cam1, ..."""
    path = path_of(path)
    where = pathlib.Path(path)
    if (where / "summary.json").is_file():
        rig = Rig.from_folder(where)
        rig.made["files"] = _name_of(where)
        return rig
    data = b"" if where.is_dir() else read_file(path)
    if data.startswith(stored.MAGIC):
        beside = where.with_name("rig.csv")
        if names is None and where.name == "rig.bin" and beside.is_file():
            names = _tables.read(beside).get("camera")
        try:
            calibrated = CalibratedRig.from_bytes(data, names)
        except Error as problem:
            raise FileError(path, str(problem)) from None
        made = {"file": _name_of(where)}
        return Rig(calibrated, calibrated.cameras, stored=data, made=made)
    cameras = load_cameras(path)
    posed = {name: c for name, c in cameras.items() if c.cam_from_rig is not None}
    if not posed:
        raise FileError(path, "no camera in it has a pose")
    return Rig(CalibratedRig.from_cameras(posed), posed, made={"file": _name_of(where)})


def _name_of(path: pathlib.Path) -> str:
    """The name without the folders that lead to it."""
    return path.name or path.resolve().name


def _load_bytes(data: bytes) -> list[Camera]:
    return list(CalibratedRig.from_bytes(data).cameras.values())


def _save_bytes(cameras: Sequence[Camera]) -> bytes:
    data: bytes = CalibratedRig.from_cameras(cameras).to_bytes()
    return data


stored.load_bytes, stored.save_bytes = _load_bytes, _save_bytes


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
        *((name, "f8") for name in _tables.OBSERVATIONS[3:]),
        ("du", "f8"),
        ("dv", "f8"),
        ("error_px", "f8"),
        ("left_out", "?"),
    ]


SUMMARY = (
    "F",
    "sqrt_F",
    "sigma_px",
    "noise_px",
    "verdict",
    "sentences",
    "findings",
    "next",
)


class _Reader:
    """The files of a folder."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.folder, self.reading = folder, "summary.json"
        try:
            text = (folder / "summary.json").read_text("utf-8", "surrogateescape")
            self.summary: dict[str, Any] = json.loads(text)
            missing = [key for key in SUMMARY if key not in self.summary]
        except OSError as problem:
            raise FileError(folder / "summary.json", str(problem.strerror)) from None
        except (ValueError, TypeError):
            raise FileError(folder / "summary.json", "this is no summary") from None
        if missing:
            what = f"there is no {', '.join(missing)}"
            raise FileError(folder / "summary.json", what)

    def table(self, name: str) -> dict[str, list[str]]:
        path, self.reading = self.folder / name, name
        return _tables.read(path) if path.is_file() else {}

    def rig(self, report: str, warnings: list[str], given: Mapping[str, Camera]) -> Rig:
        s = self.summary
        data = read_file(self.folder / "rig.bin")
        table = self.table("rig.csv")
        calibrated = CalibratedRig.from_bytes(data, table["camera"])
        sigmas = self.sigmas(table)
        if len(sigmas) == len(calibrated):
            calibrated.noise = np.array([sigma.noise_px for sigma in sigmas.values()])
        cameras = {
            name: replace(camera, extra=given[name].extra) if name in given else camera
            for name, camera in calibrated.cameras.items()
        }
        views = self.views()
        return Rig(
            calibrated,
            cameras,
            sigmas=sigmas,
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
            stored=data,
        )

    @staticmethod
    def sigmas(table: Mapping[str, Sequence[str]]) -> dict[str, Sigma]:
        rows = zip(
            *(table[key] for key in ("camera", "sigma_rot_deg", "sigma_pos", "sigma_px"))
        )
        return {
            name: Sigma(*map(float, numbers)) for name, *numbers in rows if all(numbers)
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
        for name in (*_tables.OBSERVATIONS[3:], "du", "dv", "error_px"):
            key = f"observed_{name}" if name in "uv" else name
            found[name] = _tables.numbers_of(table[key]) if key in table else np.nan
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
            found.append(last.strip(" ."))
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
    """Reads a line of clocks.csv."""
    return Clock(
        offset=float(text["offset"]),
        sigma_offset=float(text["sigma_offset"]),
        drift=float(text["drift"]),
        sigma_drift=float(text["sigma_drift"]),
        state=text["state"],
        paired_later=int(text["paired_later"]),
    )


def _fault(text: Mapping[str, str]) -> Fault:
    """Reads a line of faults.csv."""
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
