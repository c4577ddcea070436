"""Scenes for the tests of calibrate, the rig and the command: written without rigcal."""

from __future__ import annotations

import csv
import pathlib
from typing import Any

import numpy as np
import pytest

import rigcal

ROOT = pathlib.Path(__file__).resolve().parents[3]
DATA = ROOT / "examples" / "data"
SETS = ("opencv_stereo", "openptv_cavity", "myptv_stepped")
STEREO = DATA / "opencv_stereo"
NAMES = "abcd"
FPS = 30

if not STEREO.is_dir():
    pytest.skip("examples/data is in a checkout only", allow_module_level=True)


def rows_of(path: pathlib.Path) -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def table_of(path: pathlib.Path) -> dict[str, Any]:
    """Columns, numbers as float64."""
    rows = rows_of(path)
    return {
        name: np.array(
            [float(r[name]) if name in "XYZuv" else r[name] for r in rows],
            dtype=float if name in "XYZuv" else str,
        )
        for name in rows[0]
    }


def rotation(x: float, y: float, z: float) -> Any:
    w = np.array([x, y, z], float)
    angle = np.linalg.norm(w)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float) / max(angle, 1e-9)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


POSES = {
    "a": (np.eye(3), np.zeros(3)),
    "b": (rotation(0, 0.3, 0.05), np.array([-0.3, 0.02, 0.05])),
    "c": (rotation(0.1, -0.4, 0), np.array([0.4, 0.1, 0.1])),
    "d": (rotation(-0.3, 0.1, 0.1), np.array([-0.1, -0.3, 0.1])),
}
BOARD = np.array([[j * 0.05, i * 0.05, 0.0] for i in range(4) for j in range(5)])


def camera(**fields: Any) -> rigcal.Camera:
    numbers = dict(fx=900.5, fy=905.25, cx=640.0, cy=470.0, size=(1280, 960))
    return rigcal.Camera(**{**numbers, **fields})  # type: ignore[arg-type]


def project(X: Any, name: str) -> Any:
    """Pixels of points in the rig's frame, in the pinhole that `camera` makes."""
    R, t = POSES[name]
    X = X @ R.T + t
    return np.array([900.5, 905.25]) * X[:, :2] / X[:, 2:] + [640.0, 470.0]


class Recording:
    """Four cameras, eight bursts of three frames of a board that moves."""

    def __init__(
        self, late: dict[str, float] | None = None, noise: float = 0.3, seed: int = 3
    ) -> None:
        rng = np.random.default_rng(seed)
        self.cameras = {name: camera() for name in NAMES}
        self.rows: list[list[Any]] = []
        self.times: dict[tuple[str, str], float] = {}
        for burst in range(8):
            R0 = rotation(*rng.uniform(-0.4, 0.4, 3))
            t0 = np.array([*rng.uniform(-0.1, 0.1, 2), rng.uniform(0.8, 1.1)])
            turn, speed = rng.normal(0, 0.6, 3), rng.normal(0, 0.25, 3)
            for i in range(3):
                time, frame = i / FPS, str(100 * burst + i)
                for name in NAMES:
                    at = time + (late or {}).get(name, 0.0)
                    R = rotation(*(at * turn)) @ R0
                    t = t0 + at * speed - R @ BOARD.mean(0)
                    uv = project(BOARD @ R.T + t, name)
                    uv += rng.normal(0, noise, uv.shape) if noise else 0
                    self.rows += [
                        [frame, name, f"p{k}", *x, *p]
                        for k, (x, p) in enumerate(zip(BOARD.tolist(), uv.tolist()))
                    ]
                    self.times[frame, name] = 10.0 * burst + time + 5

    def of(self, frame: str, name: str) -> list[list[Any]]:
        return [row for row in self.rows if row[:2] == [frame, name]]

    def spoil(self, frame: str, name: str) -> None:
        """Gives a view the pixels of another place."""
        for row in self.of(frame, name):
            row[6], row[7] = row[6] + 60, 960 - row[7]


def off_by(rig: rigcal.Rig) -> tuple[float, float]:
    """The largest error of a camera's pose: rotation [rad], translation."""
    turn = shift = 0.0
    for name in rig:
        T = rig.cam_from_rig(name)
        R, t = POSES[name]
        turn = max(turn, float(np.linalg.norm(T.R - R)) / np.sqrt(2))
        shift = max(shift, float(np.linalg.norm(T.t - t)))
    return turn, shift
