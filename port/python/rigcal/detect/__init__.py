"""Points of a calibration target in images and videos: `rigcal.detect`.

The detectors are those of OpenCV and AprilTag: pip install "rigcal[detect]".
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

from .. import _tables
from ..errors import Caveat
from .detections import Detections
from .find import find
from .pictures import read_picture
from .targets import AprilGrid, Charuco, Chessboard, Tag, Tags, Target

__all__ = [
    "AprilGrid",
    "Charuco",
    "Chessboard",
    "Detections",
    "Tag",
    "Tags",
    "detect",
    "read_picture",
]


def detect(
    sources: Any,
    target: Target,
    *,
    times: Any = None,
    every: int = 1,
    cameras: Any = None,
    detector: Mapping[str, Any] | None = None,
    threads: int | None = None,
    progress: Any = None,
) -> Detections:
    """Finds the points of a target in the images or videos of each camera.

    sources   {camera: source} or a list of sources. A source is a pattern ("left*.jpg"), a
              folder, a video, or a list of paths or of arrays. Cameras of a list have the
              name of their folder, or what the names of their files have in common
    target    Charuco, Chessboard, AprilGrid, Tag or Tags
    times     when each picture was taken [s]: camera, frame, time_s, a table or its file;
              the frame is the number of a picture in a video, or in the name of an image
    every     of a video, only every so many pictures
    cameras   intrinsics, {name: Camera} or a file: sources have their names, in their order
              where they have other ones; sizes of images are compared
    detector  parameters of the detector by its own names, {"quad_decimate": 1.0}
    threads   as many pictures are searched at once; None: as many as there are cores
    progress  None: a bar on a terminal; True, False; or called with each line

    Images are paired by the numbers in the names of their files, or else by their order;
    videos, and pictures with times, by time: each with the nearest one. Error if nothing is
    found, or if images and intrinsics do not belong together. What is odd is a Caveat, and
    in Detections.warnings.
    """
    from ..calibrate import _teller

    known = None if cameras is None else _tables.named_cameras(cameras)
    tell, end = _teller(progress)
    try:
        found = find(sources, target, times, every, known, detector, threads, tell)
    finally:
        end()
    _warn(found.warnings)
    return found


def _warn(texts: list[str]) -> None:
    for text in texts:
        warnings.warn(text, Caveat, stacklevel=3)
