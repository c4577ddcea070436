"""`rigcal detect`, and `rigcal calibrate` from images or videos."""

from __future__ import annotations

import argparse
import os
import pathlib
import re
from collections.abc import Sequence
from typing import Any

from ..calibrate import calibrate
from ..errors import Error
from ..formats import load_target
from . import Detections, detect
from .targets import AprilGrid, Charuco, Chessboard, Tag, Target

__all__ = ["add_target", "calibrate_images", "detect_images", "target_of"]

HELP = """\
  rigcal detect      SOURCE... TARGET --out FILE [--times FILE [--times-out FILE]]
                     [--every N] [--cameras FILE] [--progress]
  rigcal calibrate   (--images|--videos) SOURCE... TARGET --cameras FILE [--times FILE]
                     [--every N] [--html FILE] [options of calibrate]

SOURCE is one for each camera: a pattern in quotes, a folder, a video; or NAME=SOURCE. They
are in the order of the cameras in --cameras, unless their names are those of cameras.
TARGET is one of
  --board 9x6 --square 0.025           a chessboard by its inner corners
  --charuco 4x5 --square 0.054 --marker 0.0405 [--dictionary 4X4_1000] [--legacy]
                                       a ChArUco board by its squares
  --aprilgrid 6x6 --tag-size 0.088 --spacing 0.3 [--family tag36h11] [--first 0]
  --tag [ID] --tag-size 0.16 [--family tag36h11]
  --target FILE                        Kalibr's YAML of an aprilgrid or checkerboard
and --inverted, where what should be dark is light.
"""

TARGETS = ("board", "charuco", "aprilgrid", "tag", "target")
CALIBRATE_NUMBERS = {
    "sigma": "sigma_px", "threshold": "threshold_px", "sigma-time": "sigma_time",
}  # fmt: skip


def add_target(parser: argparse.ArgumentParser) -> None:
    """Options that say what is in the images, and how they are read."""
    for name in ("board", "charuco", "aprilgrid", "target"):
        parser.add_argument("--" + name)
    parser.add_argument("--tag", nargs="?", const="any")
    for name in ("square", "marker", "tag-size", "spacing"):
        parser.add_argument("--" + name, type=float)
    parser.add_argument("--dictionary", default="4X4_1000")
    parser.add_argument("--family", default="tag36h11")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--legacy", action="store_true")
    parser.add_argument("--inverted", action="store_true")
    parser.add_argument("--times")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--cameras")
    parser.add_argument("--progress", action="store_true")


def _size(text: str, option: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)[xX](\d+)", text)
    if not found:
        raise Error(f"--{option}: columns x rows are expected, as 9x6, not {text}")
    return int(found.group(1)), int(found.group(2))


def _needed(given: argparse.Namespace, option: str, *names: str) -> list[float]:
    missing = [name for name in names if getattr(given, name.replace("-", "_")) is None]
    if missing:
        raise Error(f"--{option} needs {' and '.join('--' + name for name in missing)}")
    return [float(getattr(given, name.replace("-", "_"))) for name in names]


def target_of(given: argparse.Namespace) -> Target:
    """The target that the options say."""
    kinds = [name for name in TARGETS if getattr(given, name) is not None]
    if len(kinds) != 1:
        known = ", ".join("--" + name for name in TARGETS)
        raise Error(f"one of {known} says what is in the images; {len(kinds)} are given")
    (kind,) = kinds
    text = getattr(given, kind)
    if kind == "board":
        (square,) = _needed(given, kind, "square")
        return Chessboard(*_size(text, kind), square, given.inverted)
    if kind == "charuco":
        square, marker = _needed(given, kind, "square", "marker")
        size = _size(text, kind)
        return Charuco(
            *size, square, marker, given.dictionary, given.legacy, given.inverted
        )
    if kind == "aprilgrid":
        tag, spacing = _needed(given, kind, "tag-size", "spacing")
        return AprilGrid(*_size(text, kind), tag, spacing, given.family, given.first)
    if kind == "tag":
        (tag,) = _needed(given, kind, "tag-size")
        if text != "any" and not text.isdecimal():
            raise Error(f"--tag: the number of a tag is expected, not {text}")
        return Tag(tag, None if text == "any" else int(text), given.family)
    layout = load_target(text)
    if layout.kind == "aprilgrid":
        return AprilGrid(
            layout.cols, layout.rows, layout.size, layout.spacing, given.family, given.first
        )
    if layout.kind == "checkerboard" and layout.size == layout.spacing:
        return Chessboard(layout.cols, layout.rows, layout.size, given.inverted)
    raise Error(f"--target: a {layout.kind} of this kind cannot be detected")


def sources_of(words: Sequence[str]) -> Any:
    """SOURCE or NAME=SOURCE, one a camera."""
    named = [re.fullmatch(r"([\w.+-]+)=(.+)", word) for word in words]
    named = [None if os.path.exists(w) else match for w, match in zip(words, named)]
    if all(named):
        names = [match.group(1) for match in named if match]
        if len(set(names)) < len(names):
            raise Error("two sources have the same name")
        return {match.group(1): match.group(2) for match in named if match}
    if any(named):
        raise Error("give all sources a name, NAME=SOURCE, or none")
    return list(words)


def _found(given: argparse.Namespace, words: Sequence[str]) -> Detections:
    return detect(
        sources_of(words),
        target_of(given),
        times=given.times,
        every=given.every,
        cameras=given.cameras,
        progress=None if not given.progress else True,
    )


def _told(detections: Detections) -> str:
    """Prints how much was seen, a line for each camera."""
    lines = []
    views = detections.views
    for name in detections.sizes:
        looked = sum(camera == name for camera, _ in detections.images)
        seen = [rows for (camera, _), rows in views.items() if camera == name]
        lines.append(
            f"{name}: {detections.target} in {len(seen)} of {looked} pictures, "
            f"{sum(map(len, seen))} points"
        )
    return "\n".join(lines)


def detect_images(given: argparse.Namespace) -> int:
    """rigcal detect: the table of what was seen."""
    found = _found(given, given.sources)
    found.save(given.out)
    if given.times_out:
        if found.times is None:
            raise Error("--times-out: the images have no times; pass --times")
        found.save_times(given.times_out)
    print(_told(found))
    return 0


def calibrate_images(given: argparse.Namespace) -> int:
    """rigcal calibrate --images or --videos: all in one."""
    if given.cameras is None:
        raise Error("--cameras: the file of the intrinsics is needed")
    found = _found(given, given.images or given.videos)
    print(_told(found) + "\n")
    how: dict[str, Any] = {
        name: getattr(given, option.replace("-", "_"))
        for option, name in CALIBRATE_NUMBERS.items()
    }
    if given.intrinsics_sigma is not None:
        try:
            how["intrinsics_sigma"] = [float(x) for x in given.intrinsics_sigma.split(",")]
        except ValueError:
            raise Error(
                "--intrinsics-sigma: five numbers, with commas, are expected"
            ) from None
    rig = calibrate(
        given.cameras,
        found,
        seed=given.seed,
        weigh=given.weigh,
        robust=given.robust,
        clocks=given.clocks,
        drift=given.drift,
        estimate_intrinsics=given.estimate_intrinsics,
        hold=given.hold,
        prior=given.prior,
        method=given.method,
        out=given.out,
        progress=None if not given.progress else True,
    )
    print(rig.report, end="")
    if given.out:
        found.save(pathlib.Path(given.out) / "observations.csv")
        if found.times is not None:
            found.save_times(pathlib.Path(given.out) / "times.csv")
    if given.html:
        page: Any = rig
        page.html(given.html)
    return 1 if rig.warnings else 0
