"""The rig as lines in space: frustums, ellipsoids, boards, and which way is up."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..camera import Camera
from ..errors import Error
from ..measure import pixel_to_ray
from ..transform import Array
from ._style import in_order, round_125

if TYPE_CHECKING:
    from ..rig import Rig

BOARDS_MOST = 60  # outlines; more hide each other
SHARE_OF_FRUSTUM = 0.13  # its length, of the size of the scene
SHARE_OF_ELLIPSOID = 0.11  # the longest half axis of all
SHARE_SEEN = 0.03  # of an ellipsoid that needs no exaggeration
ANGLES = np.linspace(0, 2 * np.pi, 33)


@dataclass
class Scene:
    """Lines in the rig's frame, in the caller's unit.

    up, ahead   unit vectors (3,): up, and where the cameras look
    frustums    {camera: (lines, (n, 3) each)}, the first is the border of the image
    centres     {camera: (3,)}
    ellipsoids  {camera: three ellipses (33, 3)}; k sigma, `exaggeration` times as large
    boards      {frame: outline (n, 3)}
    n_boards    how many there are to draw; more than len(boards) where some are not drawn
    size        of the scene: the diagonal of the box around centres and boards
    notes       what is missing, and why
    """

    up: Array
    ahead: Array
    frustums: dict[str, list[Array]] = field(default_factory=dict)
    centres: dict[str, Array] = field(default_factory=dict)
    ellipsoids: dict[str, list[Array]] = field(default_factory=dict)
    boards: dict[str, Array] = field(default_factory=dict)
    n_boards: int = 0
    size: float = 1.0
    exaggeration: float = 1.0
    notes: list[str] = field(default_factory=list)

    @property
    def turn(self) -> Array:
        """(3, 3): takes the rig's frame to one with z up, cameras look along y."""
        z = self.up
        y = self.ahead - z * (z @ self.ahead)
        if np.linalg.norm(y) < 1e-6:
            y = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
        y = y / np.linalg.norm(y)
        return np.array([np.cross(y, z), y, z])

    @property
    def points(self) -> Array:
        """(n, 3): all places that must be in the picture."""
        lines = [line for of in self.frustums.values() for line in of]
        return np.vstack([*self.centres.values(), *lines, *self.boards.values()])


def outline(X: Array) -> Array:
    """The convex hull of points (n, 3), seen along their thinnest direction, closed."""
    middle = X.mean(0)
    plane = np.linalg.svd(X - middle, full_matrices=False)[2][:2]
    flat = (X - middle) @ plane.T
    if flat.shape[1] < 2:
        return X
    order = np.lexsort(flat.T[::-1])

    def half(places: npt.NDArray[np.int64]) -> list[int]:
        hull: list[int] = []
        for k in places.tolist():
            while len(hull) > 1:
                a, b = flat[hull[-1]] - flat[hull[-2]], flat[k] - flat[hull[-2]]
                if a[0] * b[1] - a[1] * b[0] > 0:
                    break
                hull.pop()
            hull.append(k)
        return hull

    hull = half(order)[:-1] + half(order[::-1])
    return X[hull]


def _boards(rig: Rig) -> dict[str, Array]:
    """The outline of the target in each frame, in the rig's frame."""
    r = rig.residuals
    frames = [frame for frame in in_order(list(rig.targets)) if _is_finite(rig, frame)]
    if not len(r) or not frames:
        return {}
    step = max(1, math.ceil(len(frames) / BOARDS_MOST))
    X = np.column_stack([r["X"], r["Y"], r["Z"]])
    known = np.isfinite(X).all(1)
    names, which = np.unique(r["point"], return_inverse=True)
    first = np.full((len(names), 3), np.nan)
    first[which[known]] = X[known]
    is_one = bool((first[which[known]] == X[known]).all())  # one target in all frames
    whole = first[np.isfinite(first).all(1)]
    found = {}
    for frame in frames[::step]:
        own = whole if is_one else np.unique(X[known & (r["frame"] == frame)], axis=0)
        if len(own):
            found[frame] = rig.targets[frame].apply(outline(own))
    return found


def _is_finite(rig: Rig, frame: str) -> bool:
    T = rig.targets[frame]
    return bool(np.isfinite(T.t).all() and np.isfinite(T.R).all())


def corners(camera: Camera) -> Array:
    """(n, 3) rays of unit length through the border of the image, a corner every fourth."""
    width, height = camera.size or (2 * camera.cx, 2 * camera.cy)
    u = np.array([0, 0.25, 0.5, 0.75]) * width - 0.5
    v = np.array([0, 0.25, 0.5, 0.75]) * height - 0.5
    w, h = np.full(4, width - 0.5), np.full(4, height - 0.5)
    low = np.full(4, -0.5)
    uv = np.vstack(
        [
            np.column_stack(side)
            for side in ((u, low), (w, v), (w - 0.5 - u, h), (low, h - 0.5 - v))
        ]
    )
    simple = np.column_stack(
        [(uv[:, 0] - camera.cx) / camera.fx, (uv[:, 1] - camera.cy) / camera.fy,
         np.ones(len(uv))]
    )  # fmt: skip
    simple /= np.linalg.norm(simple, axis=1, keepdims=True)
    try:
        rays = pixel_to_ray(camera, uv).rays
    except Error:
        return simple
    bad = ~np.isfinite(rays).all(1) | (np.linalg.norm(rays, axis=1) < 0.5)
    return np.where(bad[:, None], simple, rays)


def centre_covariance(rig: Rig, name: str) -> Array | None:
    """(3, 3) of a camera's centre C = -R^T t in the rig's frame, None where not known:
    dC = -R^T ([t]x w + dt)."""
    try:
        Sigma = rig.covariance(name)
    except Error:
        return None
    T = rig.cam_from_rig(name)
    x, y, z = T.t
    J = -T.R.T @ np.hstack([[[0, -z, y], [z, 0, -x], [-y, x, 0]], np.eye(3)])
    C: Array = J @ Sigma @ J.T
    return C if np.isfinite(C).all() else None


def _up(centres: Array, downs: Array, aheads: Array) -> tuple[Array, Array]:
    """Up as the cameras stand; of cameras that all look down, against their sight."""
    ahead = aheads.mean(0)
    if np.linalg.norm(ahead) < 1e-6:
        ahead = aheads[0]
    up = -downs.mean(0)
    if np.linalg.norm(up) < 0.5:
        up = -ahead
    if np.linalg.norm(up) < 0.5:
        up = np.linalg.svd(centres - centres.mean(0))[2][-1]
        up = up * np.sign(-downs[0] @ up or 1.0)
    return up / np.linalg.norm(up), ahead / np.linalg.norm(ahead)


def make_scene(
    rig: Rig, k: float = 3.0, exaggeration: float | None = None, boards: bool = True
) -> Scene:
    """k: half axes of the ellipsoids in standard deviations of the centre."""
    poses = {name: rig.cam_from_rig(name) for name in rig}
    centres = {name: T.center for name, T in poses.items()}
    C = np.array(list(centres.values()))
    up, ahead = _up(
        C, np.array([T.R[1] for T in poses.values()]),
        np.array([T.R[2] for T in poses.values()]),
    )  # fmt: skip
    scene = Scene(up, ahead, centres=centres)
    if boards:
        scene.boards = _boards(rig)
        scene.n_boards = len(rig.targets) if scene.boards else 0
    places = np.vstack([C, *scene.boards.values()])
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not (math.isfinite(size) and size > 0):
        size = 1.0
        scene.notes.append("one camera and no board: the scale is arbitrary")
    scene.size = size
    length = SHARE_OF_FRUSTUM * size
    for name in rig:
        scene.frustums[name] = _frustum(rig, name, length)
        if rig[name].size is None:
            scene.notes.append(f"{name}: its image size is not known")
    _add_ellipsoids(scene, rig, k, exaggeration)
    if boards and not scene.boards:
        scene.notes.append("no board: the rig does not come from a recording")
    elif len(scene.boards) < scene.n_boards:
        scene.notes.append(f"{len(scene.boards)} of {scene.n_boards} boards are drawn")
    return scene


def _frustum(rig: Rig, name: str, length: float) -> list[Array]:
    """The border of the image at a depth, and edges from the centre to its corners."""
    T = rig.cam_from_rig(name).inv()
    rays = corners(rig[name])
    depth = rays[::4, 2].min()
    if depth > 0.3:  # flat, unless the lens is very wide
        rays = rays / rays[:, 2:] * depth
    border = T.apply(rays * length)
    return [np.vstack([border, border[:1]]), *(np.array([T.t, p]) for p in border[::4])]


def _add_ellipsoids(scene: Scene, rig: Rig, k: float, exaggeration: float | None) -> None:
    axes = {}
    still, unknown = [], []
    for name in rig:
        C = centre_covariance(rig, name)
        if C is None or (rig.calibrated.sigma_px == 0 and not C.any()):
            unknown.append(name)
            continue
        values, vectors = np.linalg.eigh(C)
        if values[-1] <= 0:
            still.append(name)
            continue
        axes[name] = vectors * np.sqrt(np.maximum(values, 0)) * k
    longest = max(
        (float(np.linalg.norm(a, axis=0).max()) for a in axes.values()), default=0
    )
    if exaggeration is None:
        exaggeration = 1.0
        if 0 < longest < SHARE_SEEN * scene.size:
            exaggeration = round_125(SHARE_OF_ELLIPSOID * scene.size / longest)
    scene.exaggeration = exaggeration
    wave = np.array([np.cos(ANGLES), np.sin(ANGLES)])
    for name, a in axes.items():
        scene.ellipsoids[name] = [
            scene.centres[name] + exaggeration * (a[:, [i, j]] @ wave).T
            for i, j in ((0, 1), (1, 2), (0, 2))
        ]
    if still:
        scene.notes.append(f"no ellipsoid of {_some(still)}: the rig's frame, or held")
    if unknown:
        what = _some(unknown) if axes else "any camera"
        scene.notes.append(f"no ellipsoid of {what}: the covariance is not known")


def _some(names: list[str]) -> str:
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more
