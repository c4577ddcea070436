"""The likely mistake if a target is not found, or only doubtfully."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import Error
from ..transform import Array
from .detectors import FAMILIES, SIDE_LEAST, Grey, detector, grid_of, homography, quadrants
from .pictures import opencv
from .targets import AprilGrid, Charuco, Chessboard, Tag, Tags, Target

__all__ = ["beyond", "edge_width", "is_better", "second_board", "why_nothing"]

BLURRED = 8.0  # px from dark to light: an image in focus has 2 to 4
LIKE_INSIDE = 0.75  # of a saddle inside: half of it is at the border of a board
NEAR = 2  # columns and rows that are tried on either side of those given
FAR = 4  # and in one image
PROBED = 2  # images in which other sizes are looked for: each takes a while
OTHERS = (
    "4X4_1000",
    "5X5_1000",
    "6X6_1000",
    "7X7_1000",
    "ARUCO_ORIGINAL",
    "APRILTAG_36h11",
)


def edge_width(image: Grey) -> float:
    """How wide the sharpest edges are [px]: contrast over the steepest slope, of rows or of
    columns, whichever is less steep: motion blurs the edges across it alone."""
    x = image.astype(np.float32)
    along = np.abs(x[1:-1, 2:] - x[1:-1, :-2]) / 2, np.abs(x[2:, 1:-1] - x[:-2, 1:-1]) / 2
    if not along[0].size:
        return 0.0
    contrast = float(np.subtract(*np.percentile(x, [99, 1])))
    steepest = min(float(np.percentile(slope, 99.9)) for slope in along)
    return contrast / max(steepest, 1e-3) if contrast > 0 else 0.0


def beyond(image: Grey, uv: Array, board: Chessboard) -> tuple[int, int]:
    """By how many columns and rows the board in the picture is larger than the one that was
    looked for, (0, 0) as a rule; below 0: smaller. Outside the picture nothing is seen."""
    columns, rows = board.columns, board.rows
    H = homography(grid_of(columns, rows), uv)
    x, y = (np.arange(n, dtype=float) for n in (columns, rows))

    def strength(xs: Array, ys: Array) -> float:
        grid = np.column_stack([m.ravel() for m in np.meshgrid(xs, ys)])
        sign = np.where(grid.sum(axis=1) % 2, -1, 1)
        values = sign * quadrants(image, H, grid)
        return abs(float(np.nanmedian(values))) if np.isfinite(values).any() else 0.0

    inside = max(strength(x[1:-1], y[1:-1]), 1.0)
    more = [0, 0]
    for axis, n in ((0, columns), (1, rows)):
        for step in (-1.0, float(n)):
            edge = np.array([step])
            if (
                strength(edge, y) if axis == 0 else strength(x, edge)
            ) > LIKE_INSIDE * inside:
                more[axis] += 1
        for step in (0.0, float(n - 1)):
            edge = np.array([step])
            if (
                strength(edge, y) if axis == 0 else strength(x, edge)
            ) < LIKE_INSIDE * inside:
                more[axis] -= 1
    return more[0], more[1]


def second_board(image: Grey, uv: Array, board: Chessboard) -> bool:
    """Whether there is a second chessboard beside the one that was found."""
    cv2 = opencv()
    H = homography(grid_of(board.columns, board.rows), uv)
    c, r = board.columns, board.rows
    outline = np.array([[-1.2, -1.2], [c + 0.2, -1.2], [c + 0.2, r + 0.2], [-1.2, r + 0.2]])
    p = np.column_stack([outline, np.ones(4)]) @ H.T
    rest = image.copy()
    polygon = np.round(p[:, :2] / p[:, 2:]).astype(np.int32)
    cv2.fillPoly(rest, [polygon], int(np.median(image)))
    found = cv2.findChessboardCorners(rest, (c, r), flags=FAST)[0]
    return bool(found)


FAST = 1 + 2 + 8  # cv2.CALIB_CB_ADAPTIVE_THRESH, _NORMALIZE_IMAGE, _FAST_CHECK


def _sizes(board: Chessboard, by: int) -> list[tuple[int, int]]:
    """Sizes that differ from the given one by at most `by`, the nearest first."""
    given = (max(board.columns, board.rows), min(board.columns, board.rows))
    columns = range(max(3, given[0] - by), given[0] + by + 1)
    rows = range(max(3, given[1] - by), given[1] + by + 1)
    sizes = {(max(c, r), min(c, r)) for c in columns for r in rows} - {given}
    return sorted(sizes, key=lambda s: (abs(s[0] - given[0]) + abs(s[1] - given[1]), s))


def size_shown(images: Sequence[Grey], board: Chessboard) -> tuple[int, int] | None:
    """The number of inner corners that an image shows, if it is close to the given one."""
    cv2 = opencv()
    images = [image for image in images if min(image.shape) >= SIDE_LEAST]
    near = _sizes(board, NEAR)
    tried = [(image, size) for image in images[:PROBED] for size in near]
    further = [size for size in _sizes(board, FAR) if size not in near]
    for image, size in tried + [(image, size) for image in images[:1] for size in further]:
        found, uv = cv2.findChessboardCorners(image, size, flags=FAST)
        other = Chessboard(*size, board.square)
        if found and beyond(image, uv.reshape(-1, 2).astype(float), other) == (0, 0):
            return size
    return None


def _count(images: Sequence[Grey], target: Target) -> int:
    find = detector(target)
    return sum(len(find(image).pixels) for image in images)


def is_better(images: Sequence[Grey], target: Target) -> str:
    """The option of a ChArUco board that finds three times as many corners; or ""."""
    if not isinstance(target, Charuco):
        return ""
    given = _count(images, target)
    for changes in (
        {"legacy": not target.legacy},
        {"inverted": not target.inverted},
        {"legacy": not target.legacy, "inverted": not target.inverted},
        {"columns": target.rows, "rows": target.columns},
    ):
        other = dataclasses.replace(target, **changes)
        found = _count(images, other) if other != target else 0
        if found > 3 * given and found >= 4:
            what = ", ".join(f"{name}={value}" for name, value in changes.items())
            return (
                f"with {what} there are {found} corners in {len(images)} of the images, "
                f"and {given} as given: is the board of that pattern?"
            )
    return ""


def _other_markers(images: Sequence[Grey], family: str, least: int = 2) -> str:
    """The dictionary whose markers the images show, if it is another one."""
    from .detectors import dictionary

    aruco = opencv().aruco
    parameters = aruco.DetectorParameters()
    parameters.detectInvertedMarker = True
    counts = {}
    for name in OTHERS:
        find = aruco.ArucoDetector(dictionary(name), parameters).detectMarkers
        counts[name] = sum(len(find(image)[0]) for image in images[:PROBED])
    best = max(counts, key=lambda name: counts[name])
    own = family.upper().replace("DICT_", "").replace("TAG", "APRILTAG_", 1)
    if counts[best] >= least and best.split("_")[0:2] != own.split("_")[0:2]:
        if best.rsplit("_", 1)[0] == own.rsplit("_", 1)[0]:
            return f"markers of {best} are there: numbers beyond those of {family}"
        return f"markers of {best} are there: is {family} the right family?"
    return ""


def why_nothing(images: Sequence[Grey], target: Target) -> str:
    """The likely mistake in a sentence; "" if none is known."""
    if not images:
        return ""
    widths = [edge_width(image) for image in images]
    if min(widths) > BLURRED:
        return (
            f"the images are blurred: their sharpest edges are {np.median(widths):.0f} px "
            "wide, 2 to 4 in focus. Focus the camera, hold the board still, or give light"
        )
    if isinstance(target, Chessboard):
        size = size_shown(images, target)
        if size is not None:
            return (
                f"the images show a chessboard of {size[0]} x {size[1]} inner corners: "
                "count the corners between squares, not the squares"
            )
        markers = _other_markers(images, "none", 4)
        if markers:
            return f"{markers.partition(':')[0]}: is it a ChArUco board, or a grid of tags?"
    if not isinstance(target, Chessboard):
        flipped = [np.ascontiguousarray(image[:, ::-1]) for image in images]
        found = _count(flipped, target)
        if found >= 4 and found > 3 * _count(images, target):
            return (
                f"mirrored, {len(images)} of the images have {found} corners: are the "
                "images mirrored? Cameras that show a mirror image have a switch for it"
            )
    if isinstance(target, Charuco):
        better = is_better(images, target) or _other_markers(images, target.dictionary)
        if better:
            return better
        plain = size_shown(images, Chessboard(target.columns, target.rows, 1.0))
        if plain is not None and not any(detector(target)(image).tags for image in images):
            return (
                f"no marker is seen, and the images show a chessboard of {plain[0]} x "
                f"{plain[1]} inner corners: is it a Chessboard?"
            )
    if isinstance(target, (AprilGrid, Tag, Tags)):
        return _other_tags(images, target)
    if max(float(np.ptp(np.percentile(image, [1, 99]))) for image in images) < 40:
        return "the images have little contrast: give light"
    return "is the whole board in the images, with a light margin?"


def _other_tags(images: Sequence[Grey], target: AprilGrid | Tag | Tags) -> str:
    find = detector(target)
    seen = sorted({number for image in images for number in find(image).tags})
    if seen:
        return f"there are tags of the family, with the numbers {seen[:8]}"
    if target.family in FAMILIES:
        for family in ("tag36h11", "tag25h9", "tagStandard41h12"):  # seldom seen by chance
            if family == target.family:
                continue
            other: Any = detector(Tag(1.0, family=family))
            if sum(len(other(image).tags) for image in images) >= 2:
                return f"there are tags of {family}: is {target.family} the right family?"
    try:
        return _other_markers(images, target.family)
    except Error:
        return ""
