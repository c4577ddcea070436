"""Calibrates a rig: gives files to the program `rigcal` and reads what it writes.

The program does all the work, so both give the same numbers.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import IO, Any, Callable, Union

import numpy as np

from . import _tables
from ._arrays import flag
from .camera import Camera
from .detect import into_rig
from .detect.detections import Detections
from .detect.targets import Chessboard
from .errors import Caveat, Error, path_of
from .formats import save_cameras
from .rig import Rig

__all__ = ["calibrate"]

Progress = Union[bool, Callable[[str], None], None]

WARNED_MOST = 5  # caveats; Rig.warnings has all
PROGRESS = "rigcal-progress: "
NAMES = {"sigma": "sigma_px", "threshold": "threshold_px", "observations": "detections"}
INTRINSICS_SIGMA = ("focal", "aspect", "centre", "k1", "k2")


# ---- the program --------------------------------------------------------------


def program() -> str:
    """The path of the program: the package's own, or RIGCAL_PROGRAM of the environment."""
    given = os.environ.get("RIGCAL_PROGRAM")
    if given:
        return given
    from ._library import program as bundled

    return str(bundled())


class _Bar:
    """One line on standard error, shown once the work takes longer than a second."""

    WAIT, WIDTH, EVERY = 1.0, 24, 0.05  # seconds, characters, seconds

    def __init__(self, stream: Any) -> None:
        self.stream, self.length = stream, 0
        self.due = time.monotonic() + self.WAIT

    def __call__(self, text: str) -> None:
        now = time.monotonic()
        if now < self.due:
            return
        self.due = now + self.EVERY
        part = re.search(r"(\d+) of (\d+)$", text)
        done = int(part.group(1)) / max(int(part.group(2)), 1) if part else 1.0
        full = round(self.WIDTH * min(done, 1.0))
        line = f"rigcal [{'#' * full}{'.' * (self.WIDTH - full)}] {text}"
        self.show(line)

    def show(self, line: str) -> None:
        self.stream.write("\r" + line + " " * (self.length - len(line)))
        self.stream.flush()
        self.length = len(line)

    def close(self) -> None:
        if self.length:
            self.show("")
            self.stream.write("\r")
            self.stream.flush()


def _teller(progress: Progress) -> tuple[Callable[[str], None], Callable[[], None]]:
    """The function that gets each line of progress, and the one for the end."""
    if callable(progress):
        return progress, lambda: None
    stream = sys.stderr
    if progress is None:
        progress = bool(stream and stream.isatty())
    if not progress or stream is None:
        return lambda text: None, lambda: None
    bar = _Bar(stream)
    return bar, bar.close


def run(arguments: Sequence[str], progress: Progress = False) -> tuple[int, str, list[str]]:
    """Runs the program. Returns its exit status, its output, and its messages by line."""
    tell, end = _teller(progress)
    messages = []
    with tempfile.TemporaryFile() as output:
        try:
            process = subprocess.Popen(
                [program(), *arguments], stdout=output, stderr=subprocess.PIPE,
                stdin=subprocess.DEVNULL,
            )  # fmt: skip
        except OSError as problem:
            raise Error(f"the program rigcal cannot be run: {problem}") from None
        stderr: IO[bytes] = process.stderr  # type: ignore[assignment]
        try:
            for raw in stderr:
                line = raw.decode("utf-8", "surrogateescape").rstrip("\r\n")
                if line.startswith(PROGRESS):
                    tell(line[len(PROGRESS) :])
                else:
                    messages.append(line)
            status = process.wait()
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
            stderr.close()
            end()
        output.seek(0)
        text = output.read().decode("utf-8", "surrogateescape")
    return status, text, messages


def joined(messages: Iterable[str]) -> list[str]:
    """Messages, each with the advice that follows it: "what is wrong; what to do"."""
    found: list[str] = []
    for line in messages:
        text = re.sub(r"^rigcal: ", "", line)
        if found and text.startswith("  "):
            found[-1] += "; " + text.strip()
        elif text:
            found.append(text)
    return found


# ---- what is handed to it -----------------------------------------------------


class _Files:
    """The files of one run in a folder, and their names in messages."""

    def __init__(self, folder: str) -> None:
        self.folder = pathlib.Path(folder)
        self.called: dict[str, str] = {}  # argument, by path

    def new(self, name: str, argument: str) -> pathlib.Path:
        path = self.folder / name
        self.called[str(path)] = argument
        return path

    def table(self, name: str, argument: str, given: Any, wanted: Sequence[str]) -> str:
        """The path of a table: as given, or of the file that it is written to."""
        if isinstance(given, (str, os.PathLike)):
            return _tables.must_exist(given)
        table = _tables.columns(given, wanted, argument)
        path = self.new(name, argument)
        _tables.write(path, table)  # type: ignore[arg-type]
        return str(path)

    def cameras(self, argument: str, cameras: Mapping[str, Camera]) -> dict[str, str]:
        """Paths of cameras.csv and of rig.csv, which may be missing."""
        try:
            for name in cameras:
                _tables.check_name(name, f"{name!r}")
            folder = self.folder / argument
            folder.mkdir()
            save_cameras(os.fspath(folder) + os.sep, cameras, "rigcal")
        except Error as problem:
            what = getattr(problem, "what", problem.text)
            raise Error(f"{argument}: {what}") from None
        names = ("cameras.csv", "rig.csv")
        return {name: str(self.new(f"{argument}/{name}", argument)) for name in names}

    def in_words_of_arguments(self, line: str) -> str:
        """A message without the paths of this folder. Line 2 of a file is row 0."""
        for path, argument in self.called.items():
            is_about = path in line
            for number in re.findall(re.escape(path) + r":(\d+): ", line):
                line = line.replace(
                    f"{path}:{number}", f"{argument}, row {int(number) - 2}"
                )
            if is_about:
                line = re.sub(
                    r" on line (\d+)", lambda n: f" in row {int(n.group(1)) - 2}", line
                )
            line = line.replace(path, argument)
        return line


def _times(files: _Files, given: Any) -> str:
    if isinstance(given, str) and given == "frames":
        return given
    if isinstance(given, Mapping) and all(isinstance(key, tuple) for key in given):
        rows = [(*key, value) for key, value in given.items()]
        return files.table("times.csv", "times", rows, _tables.TIMES)
    return files.table("times.csv", "times", given, _tables.TIMES)


def _prior(files: _Files, given: Any) -> str:
    if isinstance(given, Rig):
        path = str(files.new("prior.csv", "prior"))
        given.write_prior(path)
        return path
    if isinstance(given, (str, os.PathLike)) and _tables.is_own(given):
        return str(given)
    path = files.cameras("prior", _tables.named_cameras(given, "prior"))["rig.csv"]
    if not os.path.isfile(path):
        raise Error("prior: no camera of it has a pose")
    return path


def _number(value: Any, name: str) -> str:
    """A number as the program reads it."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty((0,))
    if array.ndim or not np.isfinite(array):
        raise Error(f"{name}: a number is expected, not {value!r}")
    return repr(float(array))


def _held(given: Any) -> list[str]:
    """The names of `hold`."""
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, Iterable):
        raise Error(f"hold: names of cameras are expected, not {type(given).__name__}")
    return [str(name) for name in names]


def _intrinsics_sigma(given: Any) -> str:
    name = "intrinsics_sigma"
    values = given
    if isinstance(given, Mapping):
        unknown = set(given) - set(INTRINSICS_SIGMA)
        if unknown:
            raise Error(
                f"{name}: {INTRINSICS_SIGMA} are known, not {sorted(map(str, unknown))}"
            )
        values = [given.get(key, 0.0) for key in INTRINSICS_SIGMA]
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty((0,))
    if array.shape != (5,) or not np.isfinite(array).all():
        raise Error(
            f"{name}: five numbers, {', '.join(INTRINSICS_SIGMA)}, are expected, not "
            f"{values!r}"
        )
    return ",".join(repr(x) for x in array.tolist())


# ---- the call -----------------------------------------------------------------


def calibrate(
    cameras: Any,
    detections: Any,
    *,
    sigma_px: float | None = None,
    weigh: bool = False,
    robust: bool = False,
    threshold_px: float | None = None,
    seed: int | None = None,
    hold: str | Sequence[str] = (),
    prior: Any = None,
    times: Any = None,
    clocks: bool = False,
    drift: bool = False,
    sigma_time: float | None = None,
    intrinsics_sigma: Any = None,
    estimate_intrinsics: bool = False,
    method: str = "ml",
    out: str | os.PathLike[str] | None = None,
    progress: Progress = None,
) -> Rig:
    """Where each camera is, by what they saw of a target of known shape.

    cameras     {name: Camera}, cameras with names, or a file of any format: intrinsics
    detections  of rigcal.detect; or columns frame, camera, point, X, Y, Z, u, v: a data
                frame, a dict of columns, a structured array, rows, or the path of a CSV
                file. A frame is one place of the target; X, Y, Z is the point on the
                target, u, v its pixel, with (0, 0) the centre of the top-left pixel
    sigma_px    noise of one coordinate of a pixel. None: that of the residuals
    weigh       points count by their column sigma_px, as 1 / sigma_px^2, in the poses of
                views and in the rig; sigma_px is then the noise of the usual point, the
                median. False: all points count alike, as in plain least squares
    robust      leaves out points that disagree by more than threshold_px; seed chooses
                other random samples
    hold        names of cameras that stay where they are
    prior       an earlier Rig, its rig.csv, or cameras: what is known beforehand
    times       when each picture was taken [s]: frame, camera, time_s as detections,
                {(frame, camera): time}, or "frames": their numbers are times. None: those
                of detections. Without clocks and sigma_time these only test the clocks,
                and all pictures of a frame count as taken at once
    clocks      estimates how late each camera is; drift: and how fast its clock runs
    sigma_time  noise of a time by itself
    intrinsics_sigma     standard deviations: focal and aspect as parts, centre [px], k1, k2
    estimate_intrinsics  lets the recording change the intrinsics within these
    method      "ml", or "paper": the published procedure
    out         a folder to keep the program's files in
    progress    None: a bar on a terminal; True, False; or called with each line

    Error where there is no rig. What is wrong otherwise is a Caveat, and in Rig.warnings.
    """
    with tempfile.TemporaryDirectory(prefix="rigcal-") as folder:
        files = _Files(folder)
        known = _tables.named_cameras(cameras)
        noted: list[str] = []
        if isinstance(detections, Detections):
            if times is None and detections.times is not None:
                is_used = clocks or sigma_time is not None
                times = detections.times if is_used else _of_frames(detections.times)
            known = into_rig.with_sizes(known, detections)
            into_rig.check_sizes(detections, known)
            noted = into_rig.same_pictures(detections)
            noted += into_rig.swapped(detections, known)
        path = files.cameras("cameras", known)["cameras.csv"]
        arguments = ["calibrate", "--progress", "--cameras", path]
        arguments += [
            "--observations",
            files.table(
                "observations.csv", "detections", *_observations(detections, weigh)
            ),
        ]
        kept = path_of(out, "out") if out is not None else str(files.folder / "out")
        arguments += ["--out=" + kept, "--method=" + str(method)]
        for name, number in (
            ("sigma", sigma_px), ("threshold", threshold_px), ("seed", seed),
            ("sigma-time", sigma_time),
        ):  # fmt: skip
            if number is not None:
                arguments.append(
                    f"--{name}={_number(number, NAMES.get(name, name.replace('-', '_')))}"
                )
        for name, is_wanted in (
            ("weigh", weigh), ("robust", robust), ("clocks", clocks), ("drift", drift),
            ("estimate-intrinsics", estimate_intrinsics),
        ):  # fmt: skip
            if flag(is_wanted, name.replace("-", "_")):
                arguments.append("--" + name)
        arguments += [f"--hold={name}" for name in _held(hold)]
        if prior is not None:
            arguments.append("--prior=" + _prior(files, prior))
        if times is not None:
            arguments.append("--times=" + _times(files, times))
        if intrinsics_sigma is not None:
            arguments.append("--intrinsics-sigma=" + _intrinsics_sigma(intrinsics_sigma))
        status, report, messages = run(arguments, progress)
        report = files.in_words_of_arguments(report)
        told = joined(files.in_words_of_arguments(line) for line in messages)
        told = [_as_arguments(text) for text in told]
        if status not in (0, 1) or not report:  # then there is no rig, and no file
            # Wrong use is the last message. Caveats may stand before it.
            text = "\n".join(told[:WARNED_MOST] if status == 1 else told[-1:])
            raise Error(text or f"the program ended with status {status}")
        rig = Rig.from_folder(kept, report, told, known)
        if isinstance(detections, Detections):
            rig.images = dict(detections.images)
            before = known if prior is None or not isinstance(prior, Rig) else prior.cameras
            noted += _odd_pictures(rig, known, detections)
            told = noted + into_rig.compare(rig.cameras, before, detections) + told
            rig.warnings = told
        rig.made = made_of(cameras, detections, arguments)
    for text in told[:WARNED_MOST]:
        warnings.warn(text, Caveat, stacklevel=2)
    if len(told) > WARNED_MOST:
        warnings.warn(
            f"and {len(told) - WARNED_MOST} more: Rig.warnings has all",
            Caveat,
            stacklevel=2,
        )
    return rig


MIRRORED_MOST = 8  # cameras that are tried


def _odd_pictures(
    rig: Rig, known: Mapping[str, Camera], detections: Detections
) -> list[str]:
    """Finds pictures that are upside down, and cameras whose pictures are mirrored."""
    names = detections.cameras
    lost = [name for name in names if name not in rig.cameras]
    if not (lost and detections.sizes and isinstance(detections.target, Chessboard)):
        return into_rig.upside_down(
            rig.cameras, [(view.camera, view.frame) for view in rig.left_out], detections
        )
    fits = []
    for name, by_rows in itertools.product(names[:MIRRORED_MOST], (False, True)):
        table = into_rig.mirrored(detections, name, by_rows)
        with warnings.catch_warnings(), contextlib.suppress(Error):
            warnings.simplefilter("ignore", Caveat)
            other = calibrate(known, table)
            if len(other.cameras) == len(names) and not other.left_out:
                fits.append(name)
    which = " or ".join(dict.fromkeys(fits))
    return [f"are the pictures of {which} mirrored? Then they fit"] if fits else []


def _of_frames(times: Mapping[tuple[str, str], float]) -> dict[tuple[str, str], float]:
    """The mean time of each frame in the place of its pictures' own: to test the clocks of
    a rig that is adjusted as if all pictures of a frame were taken at once. The times as
    they are, where means would not rise as they do."""
    of: dict[str, list[float]] = {}
    for (frame, _), stamp in times.items():
        of.setdefault(frame, []).append(stamp)
    mean = {frame: float(np.mean(own)) for frame, own in of.items()}
    found = {(frame, camera): mean[frame] for frame, camera in times}
    for camera in {camera for _, camera in times}:
        stamps = sorted((stamp, f) for (f, c), stamp in times.items() if c == camera)
        if any(mean[b] <= mean[a] for (_, a), (_, b) in zip(stamps, stamps[1:])):
            return dict(times)
    return found


def _observations(detections: Any, weigh: bool) -> tuple[Any, Sequence[str]]:
    """A table, and those of its columns that the program reads."""
    wanted = list(_tables.OBSERVATIONS)
    if isinstance(detections, Detections):
        detections = detections.table()
        wanted.append("sigma_px")
    elif weigh:
        wanted.append("sigma_px")
    names = _tables.names_of(detections)
    if names is not None and "turned" in names:
        wanted.append("turned")
    return detections, wanted


def made_of(cameras: Any, detections: Any, arguments: Sequence[str]) -> dict[str, str]:
    """Rig.made from the arguments and the options of the program."""
    return {
        "cameras": _called(cameras),
        "detections": _called(detections),
        "options": " ".join(map(_without_folders, _options_of(arguments))) or "none",
    }


def _called(given: Any) -> str:
    """The name of an argument's file, or its type."""
    if isinstance(given, (str, os.PathLike)):
        return pathlib.Path(given).name
    return type(given).__name__


NOT_TOLD = ("cameras", "observations", "out", "progress", "method=ml")


def _options_of(arguments: Sequence[str]) -> list[str]:
    """Options of the program as given, without the files that every run has."""
    return [
        word
        for word in arguments
        if word.startswith("--")
        and word[2:].partition("=")[0] not in NOT_TOLD
        and word[2:] not in NOT_TOLD
    ]


def _without_folders(option: str) -> str:
    """--prior=/tmp/x/rig.csv as --prior=rig.csv"""
    name, is_given, value = option.partition("=")
    return name + is_given + pathlib.PurePath(value).name if is_given else name


def _as_arguments(text: str) -> str:
    """An option of a message, such as --sigma-time, by the name of its argument."""
    return re.sub(
        r"--([a-z][a-z-]*[a-z])",
        lambda found: NAMES.get(found.group(1), found.group(1).replace("-", "_")),
        text,
    )
