"""The checks of `rigcal.calibrate` for detections: whether the square, the order of the
cameras and the size of their images are right."""

from __future__ import annotations

import dataclasses
import itertools
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..camera import Camera
from ..errors import Caveat, Error
from ..poses import solve_pose
from ..transform import Array, Transform
from .detections import Detections
from .find import check_size
from .targets import Chessboard

__all__ = [
    "check_sizes",
    "compare",
    "mirrored",
    "same_pictures",
    "swapped",
    "upside_down",
    "with_sizes",
]

FAR = 0.15  # a pose that differs so much, rad and parts of the distance, is another one
SAME_LENGTH = 0.01  # part by which baselines differ in spite of a right square
SAME_TURN = 0.1  # rad: two rigs of the same cameras
FITS_BETTER = 1.5  # times: views with the intrinsics of another camera
VIEWS_LEAST = 3  # for a word on intrinsics

Key = tuple[str, str]


def check_sizes(detections: Detections, cameras: Mapping[str, Camera]) -> None:
    """Error unless all cameras have intrinsics, of the size of their pictures."""
    unknown = [name for name in detections.cameras if name not in cameras]
    if unknown:
        raise Error(
            f"detections: {', '.join(unknown)} are not among the cameras, "
            f"{', '.join(cameras)}. rigcal.detect(..., cameras=...) gives them their names"
        )
    for name, size in detections.sizes.items():
        if name in cameras:
            check_size(name, size, cameras[name].size)


def with_sizes(cameras: Mapping[str, Camera], detections: Detections) -> dict[str, Camera]:
    """Cameras with the size of their pictures, where their file does not say it."""
    return {
        name: dataclasses.replace(camera, size=detections.sizes[name])
        if camera.size is None and name in detections.sizes
        else camera
        for name, camera in cameras.items()
    }


# ---- poses of views ---------------------------------------------------------------


def _pose(camera: Camera, X: Array, uv: Array) -> tuple[Array, float] | None:
    """cam_from_target, (4, 4), and rms [px] of a view."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Caveat)  # the program says it of the views
        try:
            pose = solve_pose(camera, X, uv)
        except Error:
            return None
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = pose.cam_from_world.R, pose.cam_from_world.t
    return T, pose.rms_px


def _views(detections: Detections) -> dict[Key, tuple[Array, Array]]:
    d = detections
    X = np.column_stack([d.X, d.Y, d.Z])
    uv = np.column_stack([d.u, d.v])
    return {key: (X[rows], uv[rows]) for key, rows in d.views.items()}


# ---- pictures that are turned or mirrored --------------------------------------------


def _apart(A: Array, B: Array) -> float:
    """The distance of poses (4, 4): radian of the turn + shift over distance."""
    turn = np.arccos(np.clip((np.trace(A[:3, :3].T @ B[:3, :3]) - 1) / 2, -1, 1))
    length = np.linalg.norm(A[:3, 3]) + np.linalg.norm(B[:3, 3])
    return float(turn + 2 * np.linalg.norm(A[:3, 3] - B[:3, 3]) / max(length, 1e-12))


def _matrix(T: Transform) -> Array:
    return np.vstack([np.column_stack([T.R, T.t]), [0, 0, 0, 1.0]])


def upside_down(
    found: Mapping[str, Camera], left_out: Sequence[Key], detections: Detections
) -> list[str]:
    """Views that do not count in the rig, and would if their picture were turned by 180
    degrees."""
    views = _views(detections)
    placed = {n: _matrix(c.cam_from_rig) for n, c in found.items() if c.cam_from_rig}
    told = []
    for frame in dict.fromkeys(frame for _, frame in left_out):
        poses = {}
        for name in placed:
            if (name, frame) in views:
                poses[name] = _pose(found[name], *views[name, frame])
        best: tuple[float, str] = (FAR, "")
        for name in [n for n, f in left_out if f == frame and n in placed]:
            X, uv = views[name, frame]
            size = np.array(detections.sizes.get(name) or found[name].size or (0, 0))
            turned = _pose(found[name], X, size - 1 - uv)
            for other, pose in poses.items():
                if other != name and pose is not None and turned is not None:
                    expected = placed[name] @ np.linalg.inv(placed[other]) @ pose[0]
                    best = min(best, (_apart(turned[0], expected), name))
        if best[1]:
            told.append(
                f"camera {best[1]} in frame {frame}: its picture is upside down: turned by "
                "180 degrees it agrees with the rig. Turn it back"
            )
    return told


def mirrored(detections: Detections, name: str, by_rows: bool) -> dict[str, Any]:
    """The table with the pictures of a camera mirrored, and the corners of the chessboard
    named as they are read then."""
    board = detections.target
    assert isinstance(board, Chessboard)
    table = dict(detections.table())
    rows = detections.camera == name
    number = detections.point[rows].astype(int)
    x, y = number % board.columns, number // board.columns
    if by_rows:
        y = board.rows - 1 - y
    else:
        x = board.columns - 1 - x
    names, X = list(board.points), np.array(list(board.points.values()))
    new = y * board.columns + x
    columns: dict[str, Any] = {
        "point": np.array(names)[new], "X": X[new, 0], "Y": X[new, 1], "Z": X[new, 2],
        "u": detections.sizes[name][0] - 1 - detections.u[rows],
    }  # fmt: skip
    if "turned" in table:
        after = dict(zip(detections.point.tolist(), table["turned"].tolist()))
        columns["turned"] = np.array([after[point] for point in columns["point"].tolist()])
    for column, values in columns.items():
        table[column] = table[column].copy()
        table[column][rows] = values
    return table


def same_pictures(detections: Detections) -> list[str]:
    """Cameras that saw the same to the last bit: two real cameras never do."""
    views, told = _views(detections), []
    for a, b in itertools.combinations(detections.cameras, 2):
        both = [f for f in detections.frames if (a, f) in views and (b, f) in views]
        same = [f for f in both if np.array_equal(views[a, f][1], views[b, f][1])]
        if same:
            shown = ", ".join(same[:4]) + (" ..." if len(same) > 4 else "")
            told.append(
                f"cameras {a} and {b} have the same picture in {len(same)} of {len(both)} "
                f"frames, {shown}: is a source given twice?"
            )
    return told


# ---- the order of cameras, and the square -------------------------------------------


def swapped(detections: Detections, cameras: Mapping[str, Camera]) -> list[str]:
    """Pairs of cameras whose views fit each other's intrinsics."""
    rms: dict[Key, list[float]] = {}
    views = _views(detections)
    names = detections.cameras
    for name in names:
        own = [view for (n, _), view in views.items() if n == name]
        for X, uv in own[:: max(1, len(own) // 12)]:
            both = [_pose(cameras[other], X, uv) for other in names]
            for other, pose in zip(names, both):
                rms.setdefault((name, other), []).append(
                    np.inf if pose is None else pose[1]
                )
    middle = {key: float(np.median(values)) for key, values in rms.items()}
    told = []
    for a, b in itertools.combinations(names, 2):
        if min(len(rms[a, a]), len(rms[b, b])) < VIEWS_LEAST:
            continue
        own, other = (
            np.hypot(middle[a, a], middle[b, b]),
            np.hypot(middle[a, b], middle[b, a]),
        )
        if own > FITS_BETTER * other and middle[a, a] > middle[a, b]:
            told.append(
                f"the images of {a} and {b} fit with the other's intrinsics "
                f"({other / 2**0.5:.2g} px, {own / 2**0.5:.2g} px with their own): are the "
                "two swapped?"
            )
    return told


def compare(
    found: Mapping[str, Camera], given: Mapping[str, Camera], detections: Detections
) -> list[str]:
    """Compares a rig with one that was known: another scale, cameras swapped."""
    before = {n: c.cam_from_rig for n, c in given.items() if c.cam_from_rig is not None}
    after = {n: c.cam_from_rig for n, c in found.items() if c.cam_from_rig is not None}
    names = [name for name in after if name in before]
    pairs = list(itertools.combinations(names, 2))
    if not pairs:
        return []

    def misfit(order: Mapping[str, str]) -> tuple[float, Array]:
        """The largest turn between the two rigs, and the factors of all baselines."""
        turns, factors = [], []
        for a, b in pairs:
            now = _matrix(after[b]) @ np.linalg.inv(_matrix(after[a]))
            then = _matrix(before[order[b]]) @ np.linalg.inv(_matrix(before[order[a]]))
            R = now[:3, :3] @ then[:3, :3].T
            turn = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
            lengths = np.linalg.norm(now[:3, 3]), np.linalg.norm(then[:3, 3])
            way = now[:3, 3] @ then[:3, 3] / max(lengths[0] * lengths[1], 1e-300)
            turns.append(max(float(turn), float(np.arccos(np.clip(way, -1, 1)))))
            factors.append(lengths[0] / max(lengths[1], 1e-300))
        return max(turns), np.array(factors)

    turn, factors = misfit({name: name for name in names})
    if turn > SAME_TURN:
        for a, b in pairs:
            order = {name: {a: b, b: a}.get(name, name) for name in names}
            other, factors = misfit(order)
            if other < SAME_TURN:
                return [
                    f"the rig is that of the file with {a} and {b} exchanged: are their "
                    "images swapped?"
                ]
        return []
    factor = float(np.median(factors))
    spread = float(np.ptp(factors)) / factor
    square = getattr(detections.target, "square", None)
    if abs(factor - 1) < SAME_LENGTH or spread > abs(factor - 1) / 2:
        return []
    a, b = pairs[0]
    lengths = [
        float(np.linalg.norm((T[b] @ T[a].inv()).t)) for T in (_bare(after), _bare(before))
    ]
    text = (
        f"{a} and {b} are {lengths[0]:.4g} apart, and {lengths[1]:.4g} by the file: all "
        f"lengths are {factor:.4g} of those"
    )
    if square:
        text += f". Is a square {square / factor:.4g}, not {square:.4g}?"
    return [text]


def _bare(poses: Mapping[str, Transform]) -> dict[str, Transform]:
    return {name: Transform(T.R, T.t, name, "rig") for name, T in poses.items()}
