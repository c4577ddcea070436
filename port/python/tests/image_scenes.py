"""Pictures of boards and tags with known truth, drawn by OpenCV's warpPerspective."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from conftest import numpy_project

import rigcal

cv2 = pytest.importorskip("cv2")
pytest.importorskip("pupil_apriltags")
DATA = pathlib.Path("/usr/share/doc/opencv-doc/examples/data")
HTML = pathlib.Path("/usr/share/doc/opencv-doc/opencv4/html")
if not DATA.is_dir():
    pytest.skip("the images of Debian's opencv-doc are not here", allow_module_level=True)
SCALE = 60  # pixels of a drawing per square
OVER = 2  # a picture is drawn so many times larger, and then averaged


def chessboard(columns, rows, inverted=False):
    """A drawing with a margin of one square, and the drawing's pixel of corner 0."""
    y, x = np.mgrid[: rows + 1, : columns + 1]
    squares = np.where((x + y) % 2, 255, 0).astype(np.uint8)
    if inverted:
        squares = 255 - squares
    squares = np.kron(squares, np.ones((SCALE, SCALE), np.uint8))
    margin = 0 if inverted else 255
    drawing = cv2.copyMakeBorder(
        squares, SCALE, SCALE, SCALE, SCALE, cv2.BORDER_CONSTANT, value=margin
    )
    return drawing, (2 * SCALE, 2 * SCALE)


def board_drawing(board):
    """The drawing of a rigcal.Charuco."""
    aruco = cv2.aruco
    name = getattr(aruco, "DICT_" + board.dictionary)
    drawn = aruco.CharucoBoard(
        (board.columns, board.rows), board.square, board.marker,
        aruco.getPredefinedDictionary(name),
    )  # fmt: skip
    drawn.setLegacyPattern(board.legacy)
    image = drawn.generateImage((board.columns * SCALE, board.rows * SCALE))
    if board.inverted:
        image = 255 - image
    margin = 0 if board.inverted else 255
    drawing = cv2.copyMakeBorder(
        image, SCALE, SCALE, SCALE, SCALE, cv2.BORDER_CONSTANT, value=margin
    )
    return drawing, (SCALE, SCALE)


def grid_drawing(grid):
    """The drawing of an upright rigcal.AprilGrid, and the drawing's pixel of its origin, y
    up."""
    pixels = 80  # of a tag's edge
    gap = round(grid.spacing * pixels)
    step = pixels + gap
    height = grid.rows * step + gap
    drawing = np.full((height, grid.columns * step + gap), 255, np.uint8)
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    for number in range(grid.columns * grid.rows):
        row, column = divmod(number, grid.columns)
        tag = cv2.aruco.generateImageMarker(family, grid.first + number, pixels)
        tag = np.rot90(tag, 2)  # OpenCV has AprilTag's pictures upside down
        left, top = gap + column * step, height - gap - row * step - pixels
        drawing[top : top + pixels, left : left + pixels] = tag
    return drawing, (gap, height - gap), pixels


def render(drawing, origin, per_unit, camera, pose, flip=1, noise=1.0, rng=None, back=110):
    """The drawing in the plane z = 0 of the target, as a camera without distortion sees it.

    origin is the drawing's pixel (its top left corner is 0, 0) of the target's origin,
    per_unit its pixels per unit; flip is -1 where y is up.
    """
    K = camera.matrix @ np.column_stack([pose.R[:, :2], pose.t])
    to_target = np.array(
        [
            [1 / per_unit, 0, -(origin[0] - 0.5) / per_unit],
            [0, flip / per_unit, -flip * (origin[1] - 0.5) / per_unit],
            [0, 0, 1],
        ]
    )
    width, height = camera.size
    up = np.array([[OVER, 0, (OVER - 1) / 2], [0, OVER, (OVER - 1) / 2], [0, 0, 1]])
    size = (OVER * width, OVER * height)
    H = up @ K @ to_target
    shown = cv2.warpPerspective(
        drawing, H, size,
        flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=int(back),
    )  # fmt: skip
    image = cv2.resize(shown, (width, height), interpolation=cv2.INTER_AREA).astype(float)
    image = 20 + 0.8 * image
    if rng is not None:
        image = image + rng.normal(0, noise, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def show(target, camera, pose, rng=None):
    """A picture of a rigcal target."""
    if isinstance(target, rigcal.Chessboard):
        drawing, origin = chessboard(target.columns, target.rows, target.inverted)
        return render(drawing, origin, SCALE / target.square, camera, pose, rng=rng)
    if isinstance(target, rigcal.Charuco):
        drawing, origin = board_drawing(target)
        return render(drawing, origin, SCALE / target.square, camera, pose, rng=rng)
    drawing, origin, pixels = grid_drawing(target)
    return render(drawing, origin, pixels / target.tag, camera, pose, flip=-1, rng=rng)


def truth(target, camera, pose):
    """Pixels of the target's points by their names."""
    names = list(target.points)
    X = np.array([target.points[name] for name in names])
    uv = numpy_project(camera, X @ pose.R.T + pose.t)
    return dict(zip(names, uv))


def looking_at(target, rvec, distance, shift=(0.0, 0.0)):
    """cam_from_target, the middle of the target in front of the camera."""
    X = np.array(list(target.points.values()))
    pose = rigcal.Transform.from_rvec(rvec, [0, 0, 0], "cam", "target")
    t = np.array([*shift, distance]) - pose.R @ ((X.min(axis=0) + X.max(axis=0)) / 2)
    return rigcal.Transform(pose.R, t, "cam", "target")


def pinhole(name="cam", size=(480, 360), focal=450.0):
    return rigcal.Camera(
        focal, focal, (size[0] - 1) / 2, (size[1] - 1) / 2, size=size, name=name
    )


def write_video(path, images, fps=30.0):
    height, width = images[0].shape[:2]
    code = cv2.VideoWriter_fourcc(*("mp4v" if str(path).endswith("mp4") else "MJPG"))
    video = cv2.VideoWriter(str(path), code, fps, (width, height))
    video.set(cv2.VIDEOWRITER_PROP_QUALITY, 95)
    for image in images:
        video.write(image if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    video.release()
    return str(path)


def moving_rig(target, count, delays, fps=30.0, seed=1):
    """Cameras side by side that see a moving board, each with its own delay: {name: Camera
    with cam_from_rig} and {name: pictures}."""
    rng = np.random.default_rng(seed)
    cameras, pictures = {}, {}
    for k, delay in enumerate(delays):
        name = f"cam{k}"
        cam_from_rig = rigcal.Transform.from_rvec(
            [0.02 * k, 0.2 * k, 0.01 * k], [-0.2 * k, 0.01 * k, 0.03 * k], name, "rig"
        )
        camera = pinhole(name)
        images = []
        for n in range(count):
            t = n / fps + delay
            rvec = [
                0.35 * np.sin(2.1 * t),
                0.15 + 0.35 * np.cos(1.7 * t),
                0.4 * np.sin(1.3 * t),
            ]
            shift = (0.1 + 0.07 * np.sin(2.6 * t), 0.05 * np.cos(2.2 * t))
            pose = looking_at(target, rvec, 0.85 + 0.1 * np.sin(1.9 * t), shift)
            R, T = cam_from_rig.R @ pose.R, cam_from_rig.R @ pose.t + cam_from_rig.t
            images.append(show(target, camera, rigcal.Transform(R, T, name, "target"), rng))
        cameras[name] = rigcal.Camera(
            camera.fx, camera.fy, camera.cx, camera.cy, camera.size, name=name,
            cam_from_rig=cam_from_rig,
        )  # fmt: skip
        pictures[name] = images
    return cameras, pictures
