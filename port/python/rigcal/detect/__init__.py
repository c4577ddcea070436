"""Points of a calibration target in images and videos: `rigcal.detect`.

The detectors are those of OpenCV and AprilTag: pip install "rigcal[detect]".
"""

from __future__ import annotations

from typing import Any

from .detections import Detections
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
    clocks: bool | None = None,
    every: int = 1,
    cameras: Any = None,
    progress: Any = None,
    threads: int | None = None,
) -> Detections:
    """Finds the points of a target in the images or videos of each camera.

    sources   {camera: source} or a list of sources. A source is a pattern ("left*.jpg"), a
              folder, a video, or a list of paths or arrays. Cameras of a list have the name
              of the folder or file, or what the files have in common
    target    Charuco, Chessboard, AprilGrid, Tag or Tags
    times     when each picture was taken [s]: a table camera, frame, time_s or its file
    clocks    pair pictures by their times, each camera by its own clock
    every     of a video, only every so many pictures
    cameras   intrinsics, {name: Camera} or a file: image sizes are compared with them
    progress  None: a bar on a terminal; True, False; or called with each line
    """
    raise NotImplementedError
