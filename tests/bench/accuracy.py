#!/usr/bin/env python3
"""The poses of real cameras beside maximum-likelihood references: a Markdown table of
BENCHMARKS.md, which README.md quotes.

    python3 tests/bench/accuracy.py                 presets gcc-double and gcc-float
    python3 tests/bench/accuracy.py DOUBLE FLOAT    two builds of the command line

Runs `rigcal calibrate`, also with the published procedure, on the sets that have
reference_poses.csv (made with OpenCV and SciPy), and prints the largest difference of any
view. The limits of tests/cli/test_cli.py hold each view of them.
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SETS = ["examples/data/opencv_stereo", "examples/data/myptv_stepped",
        "examples/data/openptv_cavity", "tests/data/pose2sim_scene"]
PICKED = "tests/data/pose2sim_scene"  # points picked by hand in a room
R_NAMES = [f"R{i}{j}" for i in "123" for j in "123"]


def read(path):
    with open(path, newline="", encoding="utf-8-sig") as file:
        return {(row["camera"], row["frame"]): row for row in csv.DictReader(file)}


def difference(row, known):
    """Compares with the reference: degrees, and percent of the distance."""
    R, S = ([float(r[k]) for k in R_NAMES] for r in (row, known))
    t, u = ([float(r[k]) for k in ("tx", "ty", "tz")] for r in (row, known))
    chord = math.sqrt(sum((a - b) ** 2 for a, b in zip(R, S)))
    angle = 2 * math.asin(min(1, chord / math.sqrt(8)))
    return math.degrees(angle), 100 * math.dist(t, u) / math.hypot(*u)


def differences(program, folder, *more):
    """The errors of every view against its reference."""
    with tempfile.TemporaryDirectory() as work:
        out = pathlib.Path(work) / "out"
        subprocess.run([program, "calibrate", "--cameras", ROOT / folder / "cameras.csv",
                        "--observations", ROOT / folder / "observations.csv", "--out", out,
                        *more], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        found, known = read(out / "poses.csv"), read(ROOT / folder / "reference_poses.csv")
    if found.keys() != known.keys():
        sys.exit(f"accuracy.py: {folder}: other views than the reference has")
    return [difference(found[key], known[key]) for key in known]


def worst(columns, k, sets):
    return [max(d[k] for name in sets for d in column[name]) for column in columns]


def main():
    double, single = sys.argv[1:] or (ROOT / "build/gcc-double/rigcal",
                                      ROOT / "build/gcc-float/rigcal")
    columns = [{name: differences(program, name, *more) for name in SETS} for program, more in
               ((double, ()), (single, ()), (double, ("--method", "paper")))]
    views = sum(len(columns[0][name]) for name in SETS)
    others = [name for name in SETS if name != PICKED]
    print(f"| {views} views | `rigcal_pose_solve` | in float | published procedure |")
    print("| --- | ---: | ---: | ---: |")
    for k, what, unit in ((0, "rotation", "deg"), (1, "translation, of the distance", "%")):
        for sets, which in ((SETS, "worst of all views"), (others, "without the room")):
            print(f"| {what}: {which} | " + " | ".join(
                f"{x:.1g} {unit}" if x < 1e-3 else f"{x:.2f} {unit}"
                for x in worst(columns, k, sets)) + " |")


if __name__ == "__main__":
    main()
