#!/usr/bin/env python3
"""The time of poses from Python against C, by hand on an idle machine.

    python3 port/python/bench/poses.py [--views N] [--repeats N]

rigcal must be installed in this Python; gcc compiles the program in C, once with the
package's own library and once with the sources at -O3. Views of 8 points through a
distorted lens. Prints a table for README.md: seconds of a processor; with threads, seconds
of the clock. The least of the repeats counts.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import platform
import subprocess
import tempfile
import time
import warnings

import numpy as np

import rigcal
from rigcal._library import FOLDER

ROOT = pathlib.Path(__file__).resolve().parents[3]
POINTS = 8


def scene(views: int) -> tuple[rigcal.Camera, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    camera = rigcal.Camera(
        800, 800, 320, 240, size=(640, 480), dist=(-0.1, 0.01, 1e-3, 1e-3, 0)
    )
    X = rng.uniform(-0.3, 0.3, (views, POINTS, 3))
    uv = np.empty((views, POINTS, 2))
    for k in range(views):
        pose = rigcal.Transform.from_rvec(rng.uniform(-0.6, 0.6, 3), [0.05, 0.02, 1.5])
        uv[k] = rigcal.project(camera, X[k], pose).uv + rng.normal(0, 0.3, (POINTS, 2))
    return camera, X, uv


def in_c(camera, X, uv, repeats: int) -> list[float]:
    """Microseconds for a pose: with the package's library, and with the sources at -O3."""
    numbers = [camera.fx, camera.fy, camera.cx, camera.cy, *camera.coefficients.values()]
    flags = ["-std=c99", "-D_DEFAULT_SOURCE", "-ffp-contract=off", "-DNDEBUG", "-O3"]
    sources = sorted((ROOT / "src").glob("*.c"))
    library = [FOLDER / "librigcal.so", f"-Wl,-rpath,{FOLDER}"]
    took = []
    with tempfile.TemporaryDirectory() as work:
        data = pathlib.Path(work, "views")
        data.write_bytes(
            np.array(numbers).tobytes() + np.concatenate([X, uv], axis=2).tobytes()
        )
        for rest in (library, sources):
            command = [
                "gcc",
                *flags,
                f"-I{ROOT / 'include'}",
                ROOT / "port/python/bench/poses.c",
            ]
            subprocess.run([*command, *rest, "-lm", "-o", f"{work}/bench"], check=True)
            said = subprocess.run(
                [f"{work}/bench", data, str(POINTS), str(repeats)],
                check=True, capture_output=True, text=True,
            )  # fmt: skip
            took.append(float(said.stdout.split()[0]))
    return took


def least(repeats: int, clock, work) -> float:
    times = []
    for _ in range(repeats):
        begin = clock()
        work()
        times.append(clock() - begin)
    return min(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--views", type=int, default=10000)
    parser.add_argument("--repeats", type=int, default=20)
    arguments = parser.parse_args()
    views, repeats = arguments.views, arguments.repeats
    camera, X, uv = scene(views)
    own, fast = in_c(camera, X, uv, repeats)
    us = 1e6 / views

    def batch(threads):
        return rigcal.solve_poses(camera, X, uv, threads=threads)

    def one_by_one():
        for k in range(views):
            rigcal.solve_pose(camera, X[k], uv[k])

    warnings.simplefilter("ignore", rigcal.Caveat)
    cpu = time.process_time
    rows = [
        ("C, a loop over rigcal_pose_solve of this library", own),
        ("C, the same, sources compiled by gcc -O3", fast),
        ("solve_poses, one thread", us * least(repeats, cpu, lambda: batch(1))),
        ("solve_pose, view by view, with covariance", us * least(5, cpu, one_by_one)),
    ]
    walls = [least(repeats, time.perf_counter, lambda n=n: batch(n)) * us for n in (1, 2)]
    rows += [(f"solve_poses, {n} of the clock", wall) for n, wall in
             zip(("one thread", "two threads"), walls)]  # fmt: skip
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    print(
        f"Made by bench/poses.py: {views} views of {POINTS} points, {platform.machine()}, "
        f"{os.cpu_count()} cores, load {load:.1f}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, rigcal {rigcal.__version__}.\n"
    )
    print("| | us a pose | of C |\n| --- | --- | --- |")
    for name, took in rows:
        print(f"| {name} | {took:.1f} | {took / own:.2f} |")
    print(f"\nTwo threads are {walls[0] / walls[1]:.2f} times as fast as one.")


if __name__ == "__main__":
    main()
