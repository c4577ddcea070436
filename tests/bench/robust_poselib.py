#!/usr/bin/env python3
"""The robust pose beside PoseLib's RANSAC on the same scenes: a Markdown table of
BENCHMARKS.md.

    python3 tests/bench/robust_poselib.py [COUNT] [PROGRAM]      1000 scenes a line, gcc-double

It makes the environment of beside_poselib.py, with PyPI's poselib. Each line is run by both at once, one after the other; times are
of one processor. PoseLib: estimate_absolute_pose with its defaults, except a threshold of 3
px.
"""
import math
import pathlib
import subprocess
import sys
import tempfile
import time

from beside_poselib import enter_environment

if __name__ == "__main__":
    enter_environment()

import numpy as np  # noqa: E402 -- of that environment
import poselib  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
CAMERA = {"model": "PINHOLE", "width": 640, "height": 480, "params": [800, 800, 319.5, 239.5]}
LINES = [(n, percent, where) for n in (20, 100, 500) for percent in (30, 50, 70, 80, 90)
         for where in ("image", "near") if n > 20 or percent <= 70]


def by_rigcal(program, line, count, file):
    said = subprocess.run([program, *map(str, line), str(count), file], check=True,
                          stdout=subprocess.PIPE, text=True).stdout.split()
    return [int(word) for word in said[:4]], float(said[4])


def is_right(pose, R, t, most):
    chord = np.linalg.norm(pose.R - R)
    angle = 2 * math.asin(min(1, chord / math.sqrt(8)))
    return (angle <= most[0]
            and np.linalg.norm(pose.t - t) <= most[1] * np.linalg.norm(t))


def by_poselib(line, count, file):
    n, right, spent = line[0], 0, 0.0
    for scene in np.fromfile(file).reshape(count, 5 * n + 14):
        points = scene[:5 * n].reshape(n, 5)
        X, uv = np.ascontiguousarray(points[:, :3]), np.ascontiguousarray(points[:, 3:])
        spent -= time.process_time()
        pose, _ = poselib.estimate_absolute_pose(uv, X, CAMERA,
                                                 {"max_reproj_error": 3.0}, {})
        spent += time.process_time()
        R, t, most = scene[5 * n:5 * n + 9].reshape(3, 3), scene[-5:-2], scene[-2:]
        right += is_right(pose, R, t, most)
    return right, spent


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    program = sys.argv[2] if len(sys.argv) > 2 else ROOT / "build/gcc-double/tests/bench_beside"
    print(f"{count} scenes a line, PoseLib {poselib.__version__}.\n")
    print("| points | wrong | where | right | few agree | refused | wrong yet believed | "
          "PoseLib right | ms | PoseLib ms | ratio |")
    print("| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for line in LINES:
        with tempfile.NamedTemporaryFile() as file:
            (right, believed, refused, few), ours = by_rigcal(program, line, count, file.name)
            theirs_right, theirs = by_poselib(line, count, file.name)
        print(f"| {line[0]} | {line[1]} % | {line[2]} | {right} | {few} | {refused} | "
              f"{believed} | {theirs_right} | {1e3 * ours / count:.3g} | "
              f"{1e3 * theirs / count:.3g} | {ours / theirs:.2f} |", flush=True)


if __name__ == "__main__":
    main()
