"""The files that the snippets of the pages read, and checks of what they write."""

from __future__ import annotations

import csv
import glob
import pathlib
import shutil
import sys
from dataclasses import replace
from typing import Any

import numpy as np

import rigcal

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
IMAGES = "/usr/share/doc/opencv-doc/examples/data"
STEREO = ROOT / "examples/data/opencv_stereo"
sys.path[:0] = [str(HERE.parent / "tests"), str(ROOT / "examples/fleet")]


# ---- what is there before ------------------------------------------------------


def stereo_table() -> None:
    """cameras.csv and observations.csv of a pair of real cameras."""
    for name in ("cameras.csv", "observations.csv"):
        shutil.copy(STEREO / name, name)


def opencv_files() -> None:
    """Intrinsics as cv2.FileStorage writes them, in one file and in two."""
    stereo_table()
    cameras = rigcal.load_cameras("cameras.csv")
    posed = rigcal.calibrate(cameras, "observations.csv").cameras
    rigcal.save_cameras("intrinsics.yml", posed, "opencv")
    for name, camera in cameras.items():
        rigcal.save_cameras(f"{name}.yml", [camera], "opencv")


def other_programs() -> None:
    stereo_table()
    found = rigcal.calibrate("cameras.csv", "observations.csv").cameras
    # Kalibr has no k3.
    cameras = {
        name: replace(camera, dist=camera.dist[:4]) for name, camera in found.items()
    }
    for path in ("camchain.yaml", "calibration.toml", "{name}.cameramodel"):
        rigcal.save_cameras(path, cameras)
    grid = rigcal.Target("aprilgrid", 6, 6, 0.088, 0.3)
    rigcal.save_target("aprilgrid.yaml", grid)


def chain() -> tuple[Any, Any]:
    """Three cameras. cam0 and cam2 never saw the target in the same place."""
    import make_sample

    rng = np.random.default_rng(5)
    rig = make_sample.make_rig(rng, 3)
    seen_by = ({"cam0", "cam1"}, {"cam1", "cam2"})
    rows = [
        row
        for row in make_sample.record(rig, 10, rng)
        if row["camera"] in seen_by[int(row["frame"]) % 2]
    ]
    cameras = {
        name: rigcal.Camera(
            c["fx"], c["fy"], c["cx"], c["cy"], (1280, 960),
            (c["k1"], c["k2"], c["p1"], c["p2"]),
        )
        for name, c in rig.items()
    }  # fmt: skip
    chain.truth = rig  # type: ignore[attr-defined]
    return rows, cameras


def check_chain(rig: rigcal.Rig) -> None:
    """The error of cam2 from cam0 must agree with its sigma."""
    true = chain.truth  # type: ignore[attr-defined]
    R = true["cam2"]["R"] @ true["cam0"]["R"].T
    off = rig.between("cam2", "cam0").t - (true["cam2"]["t"] - R @ true["cam0"]["t"])
    covariance = rig.pair("cam0", "cam2").covariance
    assert covariance is not None
    assert np.linalg.norm(off) < 4 * np.sqrt(np.trace(covariance[3:, 3:]))


def bad_view() -> tuple[Any, Any]:
    """Four cameras. One view has the pixels of another place."""
    from cli_scenes import Recording

    recording = Recording()
    recording.spoil("101", "c")
    return recording.cameras, recording.rows


def late() -> tuple[Any, Any, Any]:
    """Four cameras see a board that somebody moves. Camera b is 12 ms late."""
    from cli_scenes import Recording

    recording = Recording(late={"b": 0.012})
    return recording.cameras, recording.rows, recording.times


def poses() -> tuple[Any, ...]:
    """A camera, a target, its pixels in one view, and in 50."""
    rng = np.random.default_rng(2)
    camera = rigcal.Camera(800, 800, 320, 240, (640, 480), (-0.1, 0.01, 1e-3, -5e-4))
    X = rng.uniform(-0.3, 0.3, (12, 3)) * [1, 1, 0.5]
    many = []
    for _ in range(50):
        t = [*rng.uniform(-0.2, 0.2, 2), 1.5]
        pose = rigcal.Transform.from_rvec(rng.uniform(-0.5, 0.5, 3), t, "cam", "world")
        many.append(rigcal.project(camera, X, pose).uv + rng.normal(0, 0.2, (12, 2)))
    return camera, X, many[0], np.array(many)


def pixels_of_frame(frame: str) -> Any:
    """(n, 2) pixels of left and of right, by point."""
    with open("observations.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["frame"] == frame]
    for camera in ("left", "right"):
        yield np.array(
            [[float(row["u"]), float(row["v"])] for row in rows if row["camera"] == camera]
        )


def everything() -> None:
    """Makes the files that the snippets of README.md, DETECT.md and FORMATS.md read."""
    stereo_table()
    cameras = rigcal.load_cameras("cameras.csv")
    rigcal.save_cameras(
        "camchain.yaml", [replace(c, dist=c.dist[:4]) for c in posed(cameras)]
    )
    rigcal.save_cameras("stereo.yml", posed(cameras), "opencv")
    for name, camera in cameras.items():
        rigcal.save_cameras(f"{name}.yaml", [camera], "ros")
        pathlib.Path(name).mkdir()
        for path in glob.glob(f"{IMAGES}/{name}[01]*.jpg"):
            shutil.copy(path, ".")
            shutil.copy(path, name)


def posed(cameras: Any) -> list[rigcal.Camera]:
    return list(rigcal.calibrate(cameras, "observations.csv").cameras.values())


def matches(rig: rigcal.Rig, quiet: int, moved: int) -> Any:
    """Frames of 20 matches. After those at rest the right camera is turned by 0.3 deg."""
    rng = np.random.default_rng(7)
    for k in range(quiet + moved):
        X = rng.uniform(-0.12, 0.12, (20, 3)) * [1, 1, 2] + [0, 0, 0.6]
        right = rig.cam_from_rig("right")
        if k >= quiet:
            right = (
                rigcal.Transform.from_rvec([0.005, 0, 0], [0, 0, 0], "right", "right")
                @ right
            )
        poses = {"left": rig.cam_from_rig("left"), "right": right}
        yield [
            rigcal.project(rig[name], pose.apply(X)).uv + rng.normal(0, 0.2, (20, 2))
            for name, pose in poses.items()
        ]


def rows() -> Any:
    """What the program prints for a table that it refuses."""

    def said(table: Any) -> str:
        try:
            rigcal.calibrate("cameras.csv", table)
        except rigcal.Error as problem:
            return str(problem)
        return ""

    return said


# ---- what came out ---------------------------------------------------------------


def is_picture(path: str) -> None:
    """Checks that a PNG shows something: it has more than one colour."""
    import matplotlib.image

    image = matplotlib.image.imread(path)
    height, width = image.shape[:2]
    assert min(height, width) > 200, f"{path} is small: {image.shape}"
    assert len(np.unique(image[..., :3].reshape(-1, 3), axis=0)) > 10, f"{path} is empty"


def is_page(path: str) -> None:
    """Checks that a page needs no other file."""
    text = pathlib.Path(path).read_text("utf-8")
    assert len(text) > 50_000
    assert "<svg" in text
    assert 'src="http' not in text
