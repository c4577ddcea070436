#!/usr/bin/env python3
"""How the instructions of a pose grow with its points: a Markdown table of BENCHMARKS.md, and
tests/bench/figures/growth.svg. Run by hand; wants valgrind, gcc, CMake and matplotlib; takes
some minutes.

    growth.py

Built by gcc -O2 in build/instructions, double. Scenes of tests/bench/bench_growth.c; the
mean of 64 solves of few points, of fewer where there are many. The slope is that of
instructions against points, both in logarithms, from 100 points on: 1 is linear.
"""
import math
import pathlib
import re
import subprocess
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/instructions"
PICTURE = ROOT / "tests/bench/figures/growth.svg"
POINTS = (3, 4, 5, 8, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
LENSES = ("pinhole", "brown", "fisheye")
WAYS = ("cold", "warm", "robust")
ROBUST_LEAST = 10
GREY = "#808080"  # is read on white and on black
COLOURS = {"pinhole": "#2f80c8", "brown": "#d9822b", "fisheye": "#3a9a4a"}


def run(*command):
    done = subprocess.run([str(c) for c in command], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"growth: {' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def count(lens, n, way):
    """Mean instructions of one solve."""
    solves = max(4, min(64, 6400 // n))
    counts = BUILD / "callgrind.out"
    solver = "rigcal_robust_solve" if way == "robust" else "rigcal_pose_solve"
    said = run("valgrind", "--tool=callgrind", f"--toggle-collect={solver}", f"--callgrind-out-file={counts}",
               BUILD / "tests/bench_growth", lens, n, way, solves)
    if not said.startswith("0 of "):
        sys.exit(f"growth: {lens}, {n} points, {way}: {said}")
    return int(re.search(r"^totals: (\d+)", counts.read_text(), re.MULTILINE)[1]) / solves


def slope(line):
    """The slope of log instructions against log points, by least squares, from 100 points
    on."""
    xy = [(math.log(n), math.log(y)) for n, y in line if n >= 100]
    mx, my = (sum(c) / len(xy) for c in zip(*xy))
    return sum((x - mx) * (y - my) for x, y in xy) / sum((x - mx) ** 2 for x, _ in xy)


def draw(lines):
    plt.rcParams.update({"svg.hashsalt": "rigcal", "svg.fonttype": "none", "text.color": GREY, "axes.edgecolor": GREY,
                         "axes.labelcolor": GREY, "xtick.color": GREY, "ytick.color": GREY, "font.size": 12})
    figure, panels = plt.subplots(1, 3, figsize=(11, 4), sharey=True)
    for panel, way in zip(panels, WAYS):
        for lens in LENSES:
            panel.loglog(*zip(*lines[lens, way]), marker="o", markersize=3.5, color=COLOURS[lens], label=lens)
        panel.set_title(way)
        panel.set_xlabel("points")
        panel.grid(color=GREY, alpha=0.3)
        for side in ("top", "right"):
            panel.spines[side].set_visible(False)
    panels[0].set_ylabel("instructions of a solve")
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncol=3, frameon=False)
    figure.savefig(PICTURE, transparent=True, metadata={"Date": None})


def main():
    run("cmake", "-S", ".", "-B", BUILD, "-DCMAKE_C_COMPILER=gcc", "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_C_FLAGS_RELEASE=-O2", "-DRIGCAL_REAL=double", "-DRIGCAL_BUILD_TESTS=ON", "-DRIGCAL_BUILD_EXAMPLES=OFF")
    run("cmake", "--build", BUILD, "--target", "bench_growth")
    lines = {}
    for lens in LENSES:
        for way in WAYS:
            lines[lens, way] = [(n, count(lens, n, way)) for n in POINTS if way != "robust" or n >= ROBUST_LEAST]
            print(f"{lens}, {way}", file=sys.stderr, flush=True)
    draw(lines)
    heads = [f"{lens}, {way}" for lens in LENSES for way in WAYS]
    print("Thousands of instructions of a solve, and the slope from 100 points on:\n")
    print("| points | " + " | ".join(heads) + " |\n| ---: |" + " ---: |" * len(heads))
    for n in POINTS:
        cells = [dict(lines[lens, way]).get(n) for lens in LENSES for way in WAYS]
        print(f"| {n} | " + " | ".join("" if c is None else f"{c / 1000:.1f}" for c in cells) + " |")
    print("| slope | " + " | ".join(f"{slope(lines[lens, way]):.2f}" for lens in LENSES for way in WAYS) + " |")


if __name__ == "__main__":
    main()
