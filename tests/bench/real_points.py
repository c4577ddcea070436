#!/usr/bin/env python3
"""Points of real rigs through `rigcal calibrate` and `rigcal triangulate`: a Markdown table of
BENCHMARKS.md.

    python3 tests/bench/real_points.py               the sets of the repository
    python3 tests/bench/real_points.py FOLDER...     other sets, files as examples/data/FORMAT.md

Build the preset gcc-double first, or name another build by --build.

Points are measured from the observations of a set, and from its checkpoints where it has some,
and compared with where they are known to be in the target's frame. The rms error stands beside
that of reference_triangulation.csv and reference_checkpoints.csv. The squared error, in units
of the covariance that is stated, is 3 on average where the covariance is right.

Exit status: 1 if the rms is above the reference's by more than 0.5 %, or if, for a rig with a
loop closure, the mean squared error over 3 is not within 0.5 to 2.
"""
import argparse
import csv
import io
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
SETS = ["examples/data/opencv_stereo", "examples/data/myptv_stepped",
        "examples/data/openptv_cavity", "tests/data/pose2sim_scene"]
WORSE, LEAST, MOST = 1.005, 0.5, 2.0
SOURCES = [("observations.csv", "reference_triangulation.csv"),
           ("checkpoints.csv", "reference_checkpoints.csv")]


def table(text):
    return list(csv.DictReader(io.StringIO(text)))


def numbers(row, names):
    return np.array([float(row[name]) for name in names])


def covariance(row):
    S = np.zeros((3, 3))
    S[np.tril_indices(3)] = numbers(row, ["S11", "S21", "S22", "S31", "S32", "S33"])
    return S + np.tril(S, -1).T


def calibrate(binary, folder, out):
    """sqrt(F); 0: the rig has no loop closure."""
    run = subprocess.run([binary, "calibrate", "--cameras", folder / "cameras.csv",
                          "--observations", folder / "observations.csv", "--out", out],
                         capture_output=True, text=True)
    found = re.search(r"^sqrt\(F\) ([\d.e+]+):", run.stdout, re.M)
    if not (out / "rig.csv").exists():
        raise ValueError(run.stderr.splitlines()[0] if run.stderr else "no rig")
    return float(found[1]) if found else 0


def triangulate(binary, folder, out, observations):
    run = subprocess.run([binary, "triangulate", "--cameras", folder / "cameras.csv", "--rig",
                          out / "rig.csv", "--observations", folder / observations,
                          "--targets", out / "targets.csv"], capture_output=True, text=True)
    return {(row["frame"], row["point"]): row for row in table(run.stdout)}


def compare(rows, reference):
    """Compares the points that are in both. Returns: their number; rms; rms of the
    reference; mean squared error over 3; its median over the median of chi square; number
    of points with a view left out."""
    squares, known, over = [], [], []
    for row in reference:
        found = rows.get((row["frame"], row["point"]))
        if found is None:
            continue
        d = numbers(found, "XYZ") - numbers(row, "XYZ")
        squares.append(d @ d)
        known.append(float(row["err"])**2)
        over.append(d @ np.linalg.solve(covariance(found), d))
    left_out = sum(row["left_out"] != "" for row in rows.values())
    return (len(squares), np.sqrt(np.mean(squares)), np.sqrt(np.mean(known)), np.mean(over) / 3,
            np.median(over) / 2.366, left_out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="*", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/gcc-double")
    arguments = parser.parse_args()
    folders = arguments.folders or [ROOT / name for name in SETS]
    missed = []
    print("| set | points | rms error | over the reference's | sqrt(F) | squared error over "
          "its covariance / 3 | its median, over chi square's | points with a view left out |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for folder in folders:
        folder = folder.resolve()
        with tempfile.TemporaryDirectory() as place:
            out = pathlib.Path(place) / "out"
            try:
                root_F = calibrate(arguments.build / "rigcal", folder, out)
            except ValueError as error:
                print(f"{folder.name}: {error}", file=sys.stderr)
                continue
            for observations, reference in SOURCES:
                if not (folder / reference).exists():
                    continue
                name = folder.name + (", checkpoints" if "check" in reference else "")
                rows = triangulate(arguments.build / "rigcal", folder, out, observations)
                n, rms, known, mean, median, left_out = compare(
                    rows, table((folder / reference).read_text(encoding="utf-8-sig")))
                told = f"{root_F:.1f}" if root_F > 0 else ""
                print(f"| {name} | {n} | {rms:.4g} | {rms / known:.4f} | {told} | {mean:.2f} | "
                      f"{median:.2f} | {left_out} |")
                if rms > WORSE * known:
                    missed.append(f"{name}: the rms error is {rms / known:.4f} of the reference's")
                if root_F > 0 and not LEAST <= mean <= MOST:
                    missed.append(f"{name}: the squared error over 3 is {mean:.2f}")
    print("\n".join(missed), file=sys.stderr, end="\n" if missed else "")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
