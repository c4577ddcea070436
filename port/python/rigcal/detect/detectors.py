"""The detectors of OpenCV and AprilTag: their corners in the order of rigcal's targets.

Pixel (0, 0) is the centre of the top-left pixel. OpenCV counts so. AprilTag counts from the
corner of that pixel: 0.5 is subtracted from its numbers.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import Error
from ..transform import Array
from .pictures import opencv
from .targets import AprilGrid, Charuco, Chessboard, Tag, Tags, Target

__all__ = ["Seen", "detector"]

Grey = npt.NDArray[np.uint8]

# px: a picture with a shorter side shows no target. In one of two rows AprilTag's detector
# writes beyond its memory, and OpenCV's for chessboards fails in one of twelve.
SIDE_LEAST = 24
WINDOW = 5  # half the window in which a corner is refined [px]
WINDOW_PART = 0.4  # and at most this part of the way to the next corner
REFINED = (3, 100, 1e-6)  # cv2.TermCriteria: at most 100 steps, to 1e-6 px
WINDOWS = (
    0.6,
    0.8,
    1.2,
    1.4,
)  # of the half window, to see by how much a corner depends on it
SIGMA_LEAST = 0.1  # px: what is left where the window does not matter
APRILTAG_ORIGIN = 0.5  # px: its pixel (0, 0) is a corner, ours is a centre
FAMILIES = (
    "tag36h11", "tag25h9", "tag16h5", "tagCircle21h7", "tagCircle49h12",
    "tagCustom48h12", "tagStandard41h12", "tagStandard52h13",
)  # fmt: skip


@dataclass
class Seen:
    """What a detector saw in a picture: pixels (2,) by the name of the point.

    tags      numbers of the tags or markers that were seen
    twice     numbers that were seen more than once
    sigma_px  of each point, in the order of `pixels`: how well the picture fixes it
    """

    pixels: dict[str, Array] = field(default_factory=dict)
    tags: list[int] = field(default_factory=list)
    twice: list[int] = field(default_factory=list)
    sigma_px: list[float] = field(default_factory=list)


def sigmas(image: Grey, uv: Array, window: int) -> list[float]:
    """How far each corner moves [px] if it is refined in a different window.

    At sharp and straight edges it moves little. Blur, reflections, and objects in front of
    the board make it move.
    """
    if not len(uv):
        return []
    cv2 = opencv()
    start = np.ascontiguousarray(uv, np.float32).reshape(-1, 1, 2)
    halves = sorted({max(2, round(part * window)) for part in WINDOWS})
    moved = np.array(
        [
            cv2.cornerSubPix(image, start.copy(), (w, w), (-1, -1), REFINED).reshape(-1, 2)
            for w in halves
        ]
    )
    spread: Array = np.sqrt(np.var(moved, axis=0).sum(axis=1))
    # OpenCV returns the start if the corner has left the window.
    is_lost = 2 * (moved == start.reshape(-1, 2)).all(axis=2).sum(axis=0) >= len(halves)
    spread[is_lost] = window
    return np.hypot(SIGMA_LEAST, np.minimum(spread, window)).tolist()  # type: ignore[no-any-return]


def window_of(uv: Array, most: int = WINDOW) -> int:
    """Half the window for corners, so that it holds no other corner."""
    if len(uv) < 2:
        return most
    gaps = np.hypot(*(uv[:, None] - uv[None]).T)
    np.fill_diagonal(gaps, np.inf)
    return int(np.clip(WINDOW_PART * gaps.min(), 2, most))


# ---- chessboards ----------------------------------------------------------------


def quadrants(image: Grey, H: Array, xy: Array) -> Array:
    """How much a saddle, of (n, 2) places on the board in squares: dark - light of the two
    diagonals, in grey levels. It is above 0 where the squares towards (+, +) and (-, -) are
    dark. NaN outside the image."""
    total = np.zeros(len(xy))
    height, width = image.shape
    for dx, dy in ((0.3, 0.3), (-0.3, -0.3), (0.3, -0.3), (-0.3, 0.3)):
        p = np.column_stack([xy + [dx, dy], np.ones(len(xy))]) @ H.T
        u, v = np.round(p[:, :2] / p[:, 2:]).T
        inside = (u >= 1) & (v >= 1) & (u < width - 1) & (v < height - 1) & (p[:, 2] > 0)
        at = np.where(inside, v, 1).astype(int), np.where(inside, u, 1).astype(int)
        value = np.where(inside, image[at].astype(float), np.nan)
        total += -value if dx * dy > 0 else value
    return total / 2


def grid_of(columns: int, rows: int) -> Array:
    """(rows * columns, 2): places of the inner corners in squares."""
    y, x = np.mgrid[:rows, :columns].reshape(2, -1)
    return np.column_stack([x, y]).astype(float)


def homography(grid: Array, uv: Array) -> Array:
    """pixel_from_board, (3, 3), of inner corners."""
    H: Array = opencv().findHomography(grid, uv)[0]
    return H


def in_order(image: Grey, uv: Array, board: Chessboard) -> Array:
    """Corners row by row, read from the front. The colours of the squares show at which end
    the first one is."""
    columns, rows = board.columns, board.rows
    grid = grid_of(columns, rows)
    table = uv.reshape(rows, columns, 2)
    right = table[:, 1:] - table[:, :-1]
    down = table[1:] - table[:-1]
    x, y = right.reshape(-1, 2).mean(axis=0), down.reshape(-1, 2).mean(axis=0)
    if x[0] * y[1] - x[1] * y[0] < 0:  # read as in a mirror
        table = table[:, ::-1]
    saddle = quadrants(image, homography(grid, table.reshape(-1, 2)), grid)
    sign = np.where(grid.sum(axis=1) % 2, -1, 1)  # of the corner (x, y), if (0, 0) has 1
    is_dark = np.nansum(sign * saddle) > 0  # the board's square at its corner
    if is_dark == board.inverted:
        if (columns + rows) % 2:
            table = table[::-1, ::-1]
        elif columns == rows and columns % 2:
            table = np.rot90(table, 1)
    return table.reshape(-1, 2)


class ChessboardDetector:
    """cv2.findChessboardCorners and cv2.cornerSubPix; with "sector", where they find
    nothing, cv2.findChessboardCornersSB."""

    def __init__(self, board: Chessboard, options: Mapping[str, Any]) -> None:
        unknown = set(options) - {"window", "flags", "sector"}
        if unknown:
            raise Error(f"detector: {sorted(unknown)} of a chessboard are not known")
        self.board = board
        self.window = int(options.get("window", WINDOW))
        self.sector = bool(options.get("sector", False))
        cv2 = opencv()
        default = cv2.CALIB_CB_ADAPTIVE_THRESH + cv2.CALIB_CB_NORMALIZE_IMAGE
        self.flags = int(options.get("flags", default))

    def corners(self, image: Grey) -> Array | None:
        """(n, 2) in OpenCV's order, or None."""
        cv2 = opencv()
        size = (self.board.columns, self.board.rows)
        found, rough = cv2.findChessboardCorners(image, size, flags=self.flags)
        if found:
            w = window_of(rough.reshape(-1, 2).astype(np.float64), self.window)
            uv = cv2.cornerSubPix(image, rough, (w, w), (-1, -1), REFINED)
        elif self.sector:
            found, uv = cv2.findChessboardCornersSB(image, size)
        if not found:
            return None
        corners: Array = uv.reshape(-1, 2).astype(np.float64)
        return corners

    def __call__(self, image: Grey) -> Seen:
        if min(image.shape) < SIDE_LEAST:
            return Seen()
        uv = self.corners(255 - image if self.board.inverted else image)
        if uv is None and self.board.inverted:
            uv = self.corners(image)
        if uv is None:
            return Seen()
        uv = in_order(image, uv, self.board)
        pixels = {str(k): x for k, x in enumerate(uv)}
        return Seen(pixels, sigma_px=sigmas(image, uv, window_of(uv, self.window)))


# ---- OpenCV's markers -----------------------------------------------------------


def dictionary(name: str) -> Any:
    """A dictionary of cv2.aruco: "4X4_50", "DICT_4X4_50", "APRILTAG_36h11"."""
    aruco = opencv().aruco
    wanted = name.upper().replace("DICT_", "")
    known = {key[5:].upper(): key for key in dir(aruco) if key.startswith("DICT_")}
    if wanted not in known:
        raise Error(
            f"{name!r} is no family of AprilTag ({', '.join(FAMILIES)}) and no dictionary "
            f"of OpenCV ({', '.join(sorted(known))})"
        )
    return aruco.getPredefinedDictionary(getattr(aruco, known[wanted]))


def with_options(options: Mapping[str, Any], *parameters: Any) -> None:
    """Sets fields of OpenCV's parameters."""
    for name, value in options.items():
        holder = next((p for p in parameters if hasattr(p, name)), None)
        if holder is None:
            raise Error(f"detector: {name!r} is no parameter of OpenCV's detector")
        setattr(holder, name, value)


def repeated(numbers: list[int]) -> list[int]:
    """The numbers that occur more than once."""
    return sorted({n for n in numbers if numbers.count(n) > 1})


class CharucoDetector:
    """cv2.aruco.CharucoDetector with its own parameters."""

    def __init__(self, board: Charuco, options: Mapping[str, Any]) -> None:
        aruco = opencv().aruco
        size = (board.columns, board.rows)
        self.board = aruco.CharucoBoard(
            size, board.square, board.marker, dictionary(board.dictionary)
        )
        self.board.setLegacyPattern(board.legacy)
        self.inverted = board.inverted
        charuco, markers = aruco.CharucoParameters(), aruco.DetectorParameters()
        with_options(options, charuco, markers)
        refine = aruco.RefineParameters()
        self.detector = aruco.CharucoDetector(self.board, charuco, markers, refine)

    def __call__(self, image: Grey) -> Seen:
        if min(image.shape) < SIDE_LEAST:
            return Seen()
        if self.inverted:
            image = 255 - image
        corners, ids, _, markers = self.detector.detectBoard(image)
        tags = [] if markers is None else np.ravel(markers).tolist()
        if ids is None or not len(ids):
            return Seen(tags=tags, twice=repeated(tags))
        uv = np.reshape(corners, (-1, 2)).astype(np.float64)
        pixels = {str(k): x for k, x in zip(np.ravel(ids).tolist(), uv)}
        return Seen(pixels, tags, repeated(tags), sigmas(image, uv, window_of(uv)))


# ---- tags -----------------------------------------------------------------------

# Detectors of AprilTag's library that no thread uses now, by family and options. They are
# used again and never freed: pupil_apriltags uses a family after freeing it.
_KEPT: dict[tuple[str, str], list[Any]] = {}


def _kept_alive(library: Any) -> Any:
    return type("Detector", (library.Detector,), {"__del__": lambda self: None})


class TagDetector:
    """Tags by the AprilTag library, or by cv2.aruco if the family is a dictionary of it."""

    def __init__(self, target: AprilGrid | Tag | Tags, options: Mapping[str, Any]) -> None:
        self.target = target
        self.wanted = set(target.tags)
        if target.family in FAMILIES:
            self.find = self.apriltag(target.family, options)
        else:
            self.find = self.aruco(target.family, options)

    @staticmethod
    def apriltag(family: str, options: Mapping[str, Any]) -> Any:
        try:
            library = importlib.import_module("pupil_apriltags")
        except ImportError as problem:
            raise Error(
                f"AprilTag's library is needed for {family}: pip install "
                f'"rigcal[detect]" ({problem}); or family="APRILTAG_{family[3:]}", the '
                "tags of OpenCV"
            ) from None
        kept = _KEPT.setdefault((family, repr(sorted(options.items()))), [])

        def find(image: Grey) -> list[tuple[int, Array]]:
            try:
                own = kept.pop()
            except IndexError:
                own = _kept_alive(library)(families=family, nthreads=1, **options)
            tags = own.detect(image)
            kept.append(own)
            # AprilTag begins at the bottom left and goes in the other direction.
            return [
                (int(tag.tag_id), np.asarray(tag.corners)[::-1] - APRILTAG_ORIGIN)
                for tag in tags
            ]

        try:
            find(np.zeros((32, 32), np.uint8))
        except TypeError as problem:
            raise Error(f"detector: {problem}") from None
        return find

    @staticmethod
    def aruco(family: str, options: Mapping[str, Any]) -> Any:
        aruco = opencv().aruco
        parameters = aruco.DetectorParameters()
        parameters.cornerRefinementMethod = aruco.CORNER_REFINE_SUBPIX
        with_options(options, parameters)
        markers = aruco.ArucoDetector(dictionary(family), parameters)
        # OpenCV has AprilTag's pictures upside down.
        turn = 2 if "APRILTAG" in family.upper() else 0

        def find(image: Grey) -> list[tuple[int, Array]]:
            corners, ids, _ = markers.detectMarkers(image)
            numbers = [] if ids is None else np.ravel(ids).tolist()
            tables = [np.reshape(c, (4, 2)).astype(np.float64) for c in corners]
            return [(n, np.roll(c, -turn, axis=0)) for n, c in zip(numbers, tables)]

        return find

    def __call__(self, image: Grey) -> Seen:
        if min(image.shape) < SIDE_LEAST:
            return Seen()
        found = self.find(image)
        tags = [number for number, _ in found]
        seen = Seen(tags=tags, twice=repeated(tags))
        wanted = self.wanted or set(tags)
        uv: list[Array] = []
        windows = []
        for number, corners in found:
            if number in wanted and number not in seen.twice:
                for k, x in enumerate(corners):
                    seen.pixels[f"{number}_{k}"] = x
                uv.append(corners)
                windows.append(window_of(corners))
        if uv:
            seen.sigma_px = sigmas(image, np.concatenate(uv), min(windows))
        return seen


def detector(target: Target, options: Mapping[str, Any] | None = None) -> Any:
    """A function that takes a grey image and returns a Seen. Each thread needs its own."""
    options = {} if options is None else options
    if not isinstance(options, Mapping):
        raise Error(f"detector: options by name, not {type(options).__name__}")
    if isinstance(target, Chessboard):
        return ChessboardDetector(target, options)
    if isinstance(target, Charuco):
        return CharucoDetector(target, options)
    if isinstance(target, (AprilGrid, Tag, Tags)):
        return TagDetector(target, options)
    raise Error(
        "target: a Chessboard, Charuco, AprilGrid, Tag or Tags is expected, not "
        f"{type(target).__name__}"
    )
