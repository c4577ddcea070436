"""Makes a fleet with known truth: what it recorded on two evenings, and its intrinsics.

    python make_sample.py FOLDER [--rigs 24] [--places 8] [--seed 1]

writes FOLDER/evening1 and evening2 (Parquet: rig, frame, camera, point, X, Y, Z, u, v),
cameras.parquet and truth.parquet. Between the evenings some cameras get a knock. Some rigs
have wrong data on the second evening, each with one kind of error.
"""

from __future__ import annotations

import argparse
import pathlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

NOISE = 0.1  # px, of one coordinate
TURN, SHIFT = 0.4, 0.004  # degrees, metres: a knock
BOARD = np.array([[j * 0.05, i * 0.05, 0.0] for i in range(5) for j in range(6)])
INTRINSICS = {"width": 1280, "height": 960, "k1": -0.1, "k2": 0.02, "p1": 1e-3, "p2": -5e-4}
KNOCKED = 4  # every 4th rig
BROKEN = {1: "nan", 6: "unknown camera", 9: "one camera", 14: "no intrinsics",
          17: "text", 21: "garbage"}  # by number, modulo 24  # fmt: skip


def rotation(w: Any) -> Any:
    """3x3 of a rotation vector [rad] (Rodrigues)."""
    angle = max(float(np.linalg.norm(w)), 1e-12)
    K = np.cross(np.eye(3), np.asarray(w) / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def project(camera: dict[str, Any], X: Any) -> Any:
    """Pixels of points in the camera's frame: OpenCV's standard model."""
    x, y = X[:, 0] / X[:, 2], X[:, 1] / X[:, 2]
    r2 = x * x + y * y
    d = 1 + r2 * (camera["k1"] + r2 * camera["k2"])
    xd = x * d + 2 * camera["p1"] * x * y + camera["p2"] * (r2 + 2 * x * x)
    yd = y * d + camera["p1"] * (r2 + 2 * y * y) + 2 * camera["p2"] * x * y
    u, v = camera["fx"] * xd + camera["cx"], camera["fy"] * yd + camera["cy"]
    return np.column_stack([u, v])


def make_rig(rng: np.random.Generator, n: int) -> dict[str, dict[str, Any]]:
    """n cameras on an arc of 1.2 m around the target, which look at it."""
    rig = {}
    for k in range(n):
        focal = rng.uniform(880, 920)
        rig[f"cam{k}"] = {
            **INTRINSICS,
            "fx": focal,
            "fy": focal * 1.005,
            "cx": rng.uniform(630, 650),
            "cy": rng.uniform(470, 490),
            "R": rotation([*rng.normal(0, 0.05, 2), rng.normal(0, 0.1)])
            @ rotation([0, 0.35 * (k - (n - 1) / 2), 0]),
            "t": np.array([*rng.normal(0, 0.02, 2), 1.2]),
        }
    return rig


def knock(camera: dict[str, Any], rng: np.random.Generator) -> None:
    """Turns a camera about its centre, and shifts the centre."""
    axis, way = rng.normal(size=3), rng.normal(size=3)
    R = rotation(axis / np.linalg.norm(axis) * np.radians(TURN)) @ camera["R"]
    centre = -camera["R"].T @ camera["t"] + way / np.linalg.norm(way) * SHIFT
    camera["R"], camera["t"] = R, -R @ centre


def record(
    rig: dict[str, dict[str, Any]], places: int, rng: np.random.Generator
) -> Iterator[dict[str, Any]]:
    """What the cameras see of a board that somebody carries around."""
    for frame in range(places):
        R = rotation(rng.normal(0, 0.25, 3))
        X = (BOARD - BOARD.mean(axis=0)) @ R.T + rng.normal(0, 0.08, 3)
        for name, camera in rig.items():
            uv = project(camera, X @ camera["R"].T + camera["t"])
            uv += rng.normal(0, NOISE, uv.shape)
            inside = (uv >= 0).all(axis=1) & (uv <= [1279, 959]).all(axis=1)
            for k in np.flatnonzero(inside):
                x, y, z = BOARD[k]
                row = dict(frame=f"{frame:03}", camera=name, point=str(k), X=x, Y=y, Z=z)
                yield {**row, "u": uv[k, 0], "v": uv[k, 1]}


def broken(rows: pd.DataFrame, kind: str, rng: np.random.Generator) -> pd.DataFrame:
    """The rows of a rig with one thing wrong."""
    rows = rows.copy()
    if kind == "nan":
        rows.loc[rows.index[7], "u"] = np.nan
    elif kind == "unknown camera":
        rows.loc[rows.camera == "cam1", "camera"] = "webcam"
    elif kind == "one camera":
        rows = rows[rows.camera == "cam0"]
    elif kind == "text":
        rows.loc[rows.index[0], "camera"] = "cam 0, left"
    elif kind == "garbage":
        rows["u"] = rng.uniform(0, 1279, len(rows))
        rows["v"] = rng.uniform(0, 959, len(rows))
    return rows


def write(folder: pathlib.Path, rows: list[pd.DataFrame], rigs_a_file: int) -> None:
    """Writes several rigs into each file. The last rows of a file are of the first rig of
    the next file."""
    folder.mkdir(parents=True)
    table = pd.concat(rows, ignore_index=True)
    starts = list(range(0, len(rows), rigs_a_file))
    ends = np.cumsum([0, *map(len, rows)])
    for k, start in enumerate(starts):
        first = ends[start] + (5 if k else 0)
        stop = start + rigs_a_file
        last = ends[stop] + 5 if stop < len(rows) else len(table)
        part = table[first:last]
        # Spark can read gzip without a library of the operating system
        part.to_parquet(folder / f"part-{k:03}.parquet", index=False, compression="gzip")


def make(folder: pathlib.Path, rigs: int, places: int, seed: int) -> None:
    """Makes the whole fleet. A rig does not depend on the number of rigs."""
    evenings: list[list[pd.DataFrame]] = [[], []]
    cameras, truth = [], []
    for number in range(rigs):
        rng = np.random.default_rng([seed, number])
        name = f"rig{number:05}"
        rig = make_rig(rng, 2 + number % 3)
        kind = BROKEN.get(number % 24, "")
        knocked = f"cam{len(rig) - 1}" if number % KNOCKED == 3 else ""
        for evening, tables in enumerate(evenings):
            if evening and knocked:
                knock(rig[knocked], rng)
            rows = pd.DataFrame(record(rig, places, rng))
            rows.insert(0, "rig", name)
            tables.append(broken(rows, kind, rng) if evening and kind else rows)
        for camera, numbers in rig.items():
            intrinsics = {k: v for k, v in numbers.items() if k not in "Rt"}
            cameras.append({"rig": name, "camera": camera, **intrinsics})
            moved = {"moved": camera == knocked, "broken": kind}
            pose = {"R": numbers["R"].ravel(), "t": numbers["t"]}
            truth.append({"rig": name, "camera": camera, **pose, **moved})
    for k, tables in enumerate(evenings):
        write(folder / f"evening{k + 1}", tables, 6)
    table = pd.DataFrame(cameras)
    left_out = [
        name for name in table.rig if BROKEN.get(int(name[3:]) % 24) == "no intrinsics"
    ]
    table[~table.rig.isin(left_out)].to_parquet(folder / "cameras.parquet", index=False)
    pd.DataFrame(truth).to_parquet(folder / "truth.parquet", index=False)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--rigs", type=int, default=24)
    parser.add_argument("--places", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    make(**vars(parser.parse_args()))
