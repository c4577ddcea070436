"""Makes the pictures of the pages: python drawings.py FOLDER, the folder of the sources.

Drawings are SVG whose colours are those of the page, light or dark. Targets are drawn from
the points that the package itself has, so that the numbers in them are right.
"""

from __future__ import annotations

import glob
import pathlib
import sys
from typing import Any

import numpy as np

import rigcal

IMAGES = "/usr/share/doc/opencv-doc/examples/data"
STEREO = pathlib.Path(__file__).resolve().parents[3] / "examples/data/opencv_stereo"


TIPS = {
    "x": "#d0504b",
    "y": "#2d9f55",
    "z": "#3f83d8",
    "line": "var(--color-foreground-secondary)",
}


class Drawing:
    """Lines, dots and texts of one SVG."""

    def __init__(self, width: float, height: float, title: str) -> None:
        svg = f'xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
        box = 'viewBox="0 0 10 10" refX="8" refY="5" markerWidth="6" markerHeight="6"'
        tips = "".join(
            f'<marker id="tip-{name}" {box} orient="auto">'
            f'<path d="M0 0L10 5L0 10z" fill="{colour}"/></marker>'
            for name, colour in TIPS.items()
        )
        self.head = (
            f'<figure class="drawing"><svg {svg} width="{width}" role="img">'
            f"<title>{title}</title>\n<defs>{tips}</defs>\n"
        )
        self.parts: list[str] = []

    def path(
        self, points: Any, kind: str = "line", closed: bool = False, tip: str = ""
    ) -> None:
        d = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("z" if closed else "")
        end = f' marker-end="url(#tip-{tip})"' if tip else ""
        self.parts.append(f'<path class="{kind}" d="{d}"{end}/>')

    def curve(self, a: Any, middle: Any, b: Any) -> None:
        (x, y), (p, q), (u, v) = a, middle, b
        self.parts.append(
            f'<path class="line" d="M{x:.1f} {y:.1f}Q{p:.1f} {q:.1f} {u:.1f} {v:.1f}" '
            'marker-end="url(#tip-line)"/>'
        )

    def dot(self, point: Any, r: float = 3.5) -> None:
        self.parts.append(
            f'<circle class="point" cx="{point[0]:.1f}" cy="{point[1]:.1f}" r="{r}"/>'
        )

    def text(self, point: Any, text: str, kind: str = "", anchor: str = "start") -> None:
        self.parts.append(
            f'<text class="{kind}" x="{point[0]:.1f}" y="{point[1]:.1f}" '
            f'text-anchor="{anchor}">{text}</text>'
        )

    def write(self, path: pathlib.Path) -> None:
        path.write_text(self.head + "\n".join(self.parts) + "\n</svg></figure>\n")


# ---- frames ----------------------------------------------------------------------


def frames(path: pathlib.Path) -> None:
    """Two cameras and a board in space, with their axes and the transforms between them."""
    drawing = Drawing(720, 460, "Frames of two cameras and of a target")
    view = rigcal.Transform.from_rvec([0.5, 0.4, -0.05], [-1.2, 0.25, 4.2], "page", "rig")

    def on_page(X: Any) -> Any:
        Y = view.apply(X)
        return Y[..., :2] / Y[..., 2:] * 820 + [340, 280]

    def axes(frame_from: rigcal.Transform, length: float, name: str, shift: Any) -> None:
        origin = on_page(frame_from.apply(np.zeros(3)))
        for k, axis in enumerate("xyz"):
            tip = on_page(frame_from.apply(np.eye(3)[k] * length))
            drawing.path([origin, tip], f"axis {axis}", tip=axis)
            drawing.text(tip + (tip - origin) * 0.13 + [-4, 5], axis, axis)
        drawing.text(origin + shift, name, anchor="middle")

    def camera(rig_from_cam: rigcal.Transform) -> None:
        corners = np.array(
            [[-1, -0.75, 1.4], [1, -0.75, 1.4], [1, 0.75, 1.4], [-1, 0.75, 1.4]]
        )
        corners = on_page(rig_from_cam.apply(corners * 0.22))
        drawing.path(corners, "thin", closed=True)
        for corner in corners:
            drawing.path([on_page(rig_from_cam.apply(np.zeros(3))), corner], "thin")

    left = rigcal.Transform.identity("rig", "left")
    right = rigcal.Transform.from_rvec([0, -0.3, 0], [1.5, 0, 0.1], "rig", "right")
    board = rigcal.Transform.from_rvec([0.1, 0.0, 0.1], [0.35, -0.75, 1.8], "rig", "target")
    squares = np.mgrid[:5, :4].reshape(2, -1).T
    for i, j in squares:
        if (i + j) % 2:
            square = (
                np.array([[i, j, 0], [i + 1, j, 0], [i + 1, j + 1, 0], [i, j + 1, 0]])
                * 0.24
            )
            drawing.path(
                on_page(board.apply(square - [0.24, 0.24, 0])), "dark", closed=True
            )
    edge = np.array([[0, 0, 0], [5, 0, 0], [5, 4, 0], [0, 4, 0]]) * 0.24 - [0.24, 0.24, 0]
    drawing.path(on_page(board.apply(edge)), "thin", closed=True)
    for pose, name, shift in ((left, "left = rig", [-48, 8]), (right, "right", [40, 26])):
        camera(pose)
        axes(pose, 0.55, name, shift)
    axes(board, 0.5, "target", [-6, -56])
    X = np.array([0.72, 0.48, 0])
    drawing.dot(on_page(board.apply(X)), 5)
    drawing.text(on_page(board.apply(X)) + [9, -6], "X")
    for pose in (left, right):
        drawing.path(on_page(np.array([pose.apply(np.zeros(3)), board.apply(X)])), "thin")
    a, b = on_page(left.t) + [12, 16], on_page(right.t) + [-14, 10]
    drawing.curve(a, (a + b) / 2 + [0, 80], b)
    drawing.text((a + b) / 2 + [0, 62], "right_from_left", "small", "middle")
    a, b = on_page(board.t) + [-16, 0], on_page(left.t) + [-8, -14]
    drawing.curve(a, (a + b) / 2 + [-80, -50], b)
    drawing.text((a + b) / 2 + [-52, -34], "rig_from_target", "small", "end")
    drawing.write(path)


def pixels(path: pathlib.Path) -> None:
    """The top left corner of an image: the place of (0, 0) in several programs."""
    drawing = Drawing(560, 190, "Pixel (0, 0) is the centre of the top left pixel")
    side, x0, y0 = 44, 90, 40
    for k in range(4):
        drawing.path([[x0 + k * side, y0], [x0 + k * side, y0 + 3 * side]], "thin")
        drawing.path([[x0, y0 + k * side], [x0 + 3 * side, y0 + k * side]], "thin")
    origin = np.array([x0 + side / 2, y0 + side / 2])
    drawing.path([origin, origin + [3 * side, 0]], "axis x", tip="x")
    drawing.path([origin, origin + [0, 2.7 * side]], "axis y", tip="y")
    drawing.text(origin + [3 * side + 8, 5], "u", "x")
    drawing.text(origin + [6, 2.7 * side + 8], "v", "y")
    drawing.dot(origin, 4)
    drawing.text([x0 - 4, 24], "(-0.5, -0.5)", "small", "middle")
    drawing.dot([x0, y0], 3)
    notes = (
        (
            "(0, 0): the centre of the first pixel",
            "rigcal, OpenCV, Kalibr, ROS, mrcal, Anipose",
        ),
        ("its corner is (0, 0): subtract 0.5", "AprilTag, COLMAP, nerfstudio"),
        ("its centre is (1, 1): subtract 1", "MATLAB"),
    )
    for k, (what, who) in enumerate(notes):
        drawing.text([290, 42 + k * 54], what)
        drawing.text([290, 60 + k * 54], who, "small")
    drawing.write(path)


# ---- targets -----------------------------------------------------------------------


def on_paper(target: Any, points: Any, scale: float, at: Any) -> Any:
    """Pixels of points in the drawing, as seen from the printed side."""
    flip = 1 if target.front[2] < 0 else -1  # y down where z goes into the board
    return np.asarray(points)[..., :2] * [scale, flip * scale] + at


def axes_of(drawing: Drawing, target: Any, scale: float, at: Any, length: float) -> None:
    for k, name in enumerate("xy"):
        tip = np.eye(3)[k] * length
        ends = on_paper(target, [np.zeros(3), tip], scale, at)
        drawing.path(ends, f"axis {name}", tip=name)
        drawing.text(on_paper(target, tip * 1.14, scale, at) + [-4, 5], name, name)
    into = target.front[2] < 0
    drawing.text(np.array(at) + [-14, 16 if not into else -8],
                 "z in" if into else "z out", "z small", "end")  # fmt: skip


def squares_of(
    drawing: Drawing, target: Any, scale: float, at: Any, first: Any, n: Any
) -> None:
    """Draws the dark squares. The one at `first` is dark."""
    for i in range(n[0]):
        for j in range(n[1]):
            if (i + j) % 2 == 0:
                corner = np.array([first[0] + i, first[1] + j])
                square = corner + [[0, 0], [1, 0], [1, 1], [0, 1]]
                drawing.path(on_paper(target, square, scale, at), "dark", closed=True)


def numbered(drawing: Drawing, target: Any, names: Any, scale: float, at: Any) -> None:
    for name in names:
        pixel = on_paper(target, target.points[name], scale, at)
        drawing.dot(pixel)
        drawing.text(pixel + [5, -5], name, "small")


def targets(path: pathlib.Path) -> None:
    """Draws each target from the front, with its axes and its first points."""
    drawing = Drawing(760, 520, "Targets, their axes, and the order of their points")
    board = rigcal.Chessboard(5, 4, 1.0)
    at: Any = np.array([110, 110])
    drawing.text([30, 30], "Chessboard(5, 4, square)")
    squares_of(drawing, board, 36, at, (-1, -1), (6, 5))
    axes_of(drawing, board, 36, at, 2.4)
    numbered(drawing, board, ("0", "1", "4", "5", "19"), 36, at)

    charuco = rigcal.Charuco(5, 4, 1.0, 0.75)
    at = np.array([450, 80])
    drawing.text([400, 30], "Charuco(5, 4, square, marker)")
    squares_of(drawing, charuco, 40, at, (0, 0), (5, 4))
    for i in range(5):
        for j in range(4):
            if (i + j) % 2:
                marker = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * 0.75 + [
                    i + 0.125,
                    j + 0.125,
                ]
                drawing.path(on_paper(charuco, marker, 40, at), "line", closed=True)
    axes_of(drawing, charuco, 40, at, 2.6)
    numbered(drawing, charuco, ("0", "1", "4", "11"), 40, at)

    grid = rigcal.AprilGrid(3, 2, 1.0, 0.3)
    at = np.array([90, 480])
    drawing.text([30, 300], "AprilGrid(3, 2, tag, spacing)")
    for number, corners in grid.tags.items():
        drawing.path(on_paper(grid, corners, 66, at), "line", closed=True)
        middle = on_paper(grid, corners.mean(axis=0), 66, at)
        drawing.text(middle + [0, 5], f"tag {number}", "small", "middle")
    axes_of(drawing, grid, 66, at, 1.5)
    numbered(drawing, grid, ("0_0", "0_1", "0_2", "0_3", "5_0", "5_1"), 66, at)

    tag = rigcal.Tag(1.0, id=7)
    at = np.array([560, 410])
    drawing.text([400, 300], "Tag(size, id=7)")
    drawing.path(on_paper(tag, tag.tags[7], 130, at), "line", closed=True)
    axes_of(drawing, tag, 130, at, 0.3)
    numbered(drawing, tag, ("7_0", "7_1", "7_2", "7_3"), 130, at)
    drawing.write(path)


# ---- the rig of the quick start ------------------------------------------------------


def rig(folder: pathlib.Path) -> None:
    import matplotlib

    matplotlib.use("agg")
    sources = {
        name: sorted(glob.glob(f"{IMAGES}/{name}[01]*.jpg")) for name in ("left", "right")
    }
    found = rigcal.detect(sources, rigcal.Chessboard(9, 6, 0.025), progress=False)
    made = rigcal.calibrate(STEREO / "cameras.csv", found, progress=False)
    for name, dark in (("rig", False), ("rig_dark", True)):
        made.plot(dark=dark).savefig(folder / f"{name}.png", dpi=90)


if __name__ == "__main__":
    source = pathlib.Path(sys.argv[1])
    (source / "pictures").mkdir()
    frames(source / "pictures/frames.svg")
    pixels(source / "pictures/pixels.svg")
    targets(source / "pictures/targets.svg")
    rig(source / "pictures")
