"""Scenes with known truth, made by NumPy alone."""

from __future__ import annotations

import pathlib
import subprocess

import numpy as np
import pytest

import rigcal
from rigcal._library import program

ROOT = pathlib.Path(__file__).resolve().parents[3]


def numpy_project(camera, X_c):
    """Pixels of points in the camera's frame, by the formulas of rigcal.h, "camera"."""
    c = camera.coefficients
    x, y = X_c[:, 0] / X_c[:, 2], X_c[:, 1] / X_c[:, 2]
    r2 = x * x + y * y
    if camera.lens == "fisheye":
        r = np.sqrt(r2)
        a = np.arctan2(np.hypot(X_c[:, 0], X_c[:, 1]), X_c[:, 2])
        bent = a * (1 + c["k1"] * a**2 + c["k2"] * a**4 + c["k3"] * a**6 + c["k4"] * a**8)
        xd, yd = x / r * bent, y / r * bent
    else:
        d = (1 + r2 * (c["k1"] + r2 * (c["k2"] + r2 * c["k3"]))) / (
            1 + r2 * (c["k4"] + r2 * (c["k5"] + r2 * c["k6"]))
        )
        xd = x * d + 2 * c["p1"] * x * y + c["p2"] * (r2 + 2 * x * x)
        yd = y * d + c["p1"] * (r2 + 2 * y * y) + 2 * c["p2"] * x * y
    return np.column_stack([camera.fx * xd + camera.cx, camera.fy * yd + camera.cy])


def seen(camera, transform, X, noise=0.0, rng=None):
    uv = numpy_project(camera, X @ transform.R.T + transform.t)
    return uv if rng is None else uv + rng.normal(0, noise, uv.shape)


def angle(Ra, Rb):
    return 2 * np.arcsin(min(1.0, np.linalg.norm(Ra - Rb) / np.sqrt(8)))


@pytest.fixture
def rng():
    return np.random.default_rng(1)


@pytest.fixture
def camera():
    return rigcal.Camera(
        800,
        790,
        320,
        240,
        size=(640, 480),
        dist=(-0.1, 0.01, 1e-3, -5e-4, 2e-3),
        name="left",
    )


@pytest.fixture
def fisheye():
    return rigcal.Camera(
        300, 301, 320, 240, size=(640, 480), dist=(0.02, -0.01, 1e-3, 0), lens="fisheye"
    )


@pytest.fixture
def target(rng):
    """(12, 3) points of a target with depth."""
    return rng.uniform(-0.3, 0.3, (12, 3)) * [1, 1, 0.5]


@pytest.fixture
def truth():
    return rigcal.Transform.from_rvec([0.3, -0.2, 0.1], [0.05, 0.02, 1.5], "left", "world")


def transforms(rng, count):
    """Poses with the target in front of the camera."""
    for _ in range(count):
        yield rigcal.Transform.from_rvec(
            rng.uniform(-0.6, 0.6, 3),
            [*rng.uniform(-0.2, 0.2, 2), rng.uniform(1.2, 2)],
            "left",
            "world",
        )


@pytest.fixture(scope="session")
def stereo_bytes(tmp_path_factory):
    """rig.bin of examples/data/opencv_stereo, as the C program writes it."""
    data, out = ROOT / "examples/data/opencv_stereo", tmp_path_factory.mktemp("stereo")
    files = [f"{data}/cameras.csv", "--observations", f"{data}/observations.csv"]
    subprocess.run(
        [program(), "calibrate", "--cameras", *files, "--out", out],
        check=True,
        capture_output=True,
    )
    return (out / "rig.bin").read_bytes()


@pytest.fixture
def stereo(stereo_bytes):
    """A rig with a joint covariance."""
    return rigcal.CalibratedRig.from_bytes(stereo_bytes, ["left", "right"])


def exact_rig(n=3):
    """n cameras side by side, whose poses count as exact."""
    return rigcal.CalibratedRig.from_cameras(
        [
            rigcal.Camera(
                800,
                800,
                320,
                240,
                size=(640, 480),
                dist=(-0.2, 0.01, 1e-3, -5e-4),
                name=f"c{k}",
                cam_from_rig=rigcal.Transform.from_rvec(
                    [0.02 * k, -0.12 * k, 0.01],
                    [-0.3 * k, 0.02 * k, 0.01 * k],
                    f"c{k}",
                    "rig",
                ),
            )
            for k in range(n)
        ]
    )
