#!/usr/bin/env python3
"""How the instructions of rigcal_rig_adjust and rigcal_rig_join grow with cameras, placements
and points: Markdown tables, and tests/bench/figures/rig_growth.png. Run by hand; wants
valgrind, gcc, CMake and matplotlib; takes some minutes.

    python3 tests/bench/rig_growth.py

Built by gcc -O2 in build/instructions, double. The rigs are those of bench_rigs.h: all seen,
started from composed poses. One number varies at a time. Exit status 1 if the join's
instructions a view grow by more than 20 % over its range.
"""
import pathlib
import re
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end
from matplotlib.ticker import NullFormatter, ScalarFormatter  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/instructions"
PICTURE = ROOT / "tests/bench/figures/rig_growth.png"
LINEAR = 1.2

# What varies, and the rigs: cameras, placements, points.
ADJUSTED = {
    "cameras": [(C, 20, 20) for C in (2, 3, 4, 6, 8, 12, 16)],
    "placements": [(4, F, 20) for F in (5, 10, 20, 50, 100)],
    "points": [(4, 20, n) for n in (4, 10, 20, 50, 100, 200)],
}
JOINED = [(8, F, 12) for F in (12, 25, 50, 100, 200, 400)]
FIXED = {"cameras": "20 placements x 20 points", "placements": "4 cameras x 20 points",
         "points": "4 cameras x 20 placements"}


def run(*command):
    done = subprocess.run([str(c) for c in command], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"rig_growth: {' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def build():
    run("cmake", "-S", ".", "-B", BUILD, "-DCMAKE_C_COMPILER=gcc", "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_C_FLAGS_RELEASE=-O2", "-DRIGCAL_REAL=double", "-DRIGCAL_BUILD_TESTS=ON",
        "-DRIGCAL_BUILD_EXAMPLES=OFF")
    run("cmake", "--build", BUILD, "--target", "bench_rig")


def count(what, rig):
    """Instructions, and evaluations of each view."""
    counts = BUILD / "callgrind.out"
    printed = run("valgrind", "--tool=callgrind", f"--toggle-collect=bench_{what}",
                  f"--callgrind-out-file={counts}", BUILD / "tests/bench_rig", what, *rig)
    total = int(re.search(r"^totals: *(\d+)", counts.read_text(), re.M)[1])
    evaluations = re.search(r"^evaluations (\d+)", printed)
    return total, int(evaluations[1]) if evaluations else 0


def print_table(name, rows):
    print(f"\n| {name} | evaluations | 1000 instructions | a point and evaluation |\n"
          "| --- | ---: | ---: | ---: |")
    for (C, F, n), total, evaluations in rows:
        print(f"| {C} x {F} x {n} | {evaluations} | {total / 1000:.0f} | "
              f"{total / (C * F * n * evaluations):.0f} |")


def draw_panel(top, below, x, totals, each, colour):
    top.loglog(x, totals, "o-", color=colour)
    middle = len(x) // 2
    top.loglog(x, [totals[middle] * v / x[middle] for v in x], "--", color="#999999", lw=1,
               label="proportional")
    below.semilogx(x, each, "o-", color=colour)
    below.set_ylim(0, 1.25 * max(each))
    for axes in (top, below):
        axes.set_xticks(x)
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.minorticks_off()


def draw(adjusted, joined):
    plt.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 9, "axes.grid": True,
        "grid.color": "#dddddd", "grid.linewidth": 0.6, "axes.axisbelow": True,
        "lines.linewidth": 1.6, "lines.markersize": 4, "legend.frameon": False})
    figure, axes = plt.subplots(2, 4, figsize=(11, 5.2), sharex="col",
                                gridspec_kw={"height_ratios": [3, 2]})
    for k, (name, rows) in enumerate(adjusted.items()):
        x = [rig[list(adjusted).index(name)] for rig, _, _ in rows]
        draw_panel(axes[0, k], axes[1, k], x, [total for _, total, _ in rows],
                   [total / (C * F * n * evals) for (C, F, n), total, evals in rows], "#0072b2")
        axes[0, k].set_title(f"adjustment\n{FIXED[name]}")
        axes[1, k].set_xlabel(f"number of {name}")
    draw_panel(axes[0, 3], axes[1, 3], [F for (_, F, _), _ in joined],
               [total for _, total in joined],
               [total / (C * F) for (C, F, _), total in joined], "#d55e00")
    axes[0, 3].set_title("join\n8 cameras x 12 points")
    axes[1, 3].set_xlabel("number of placements")
    axes[0, 0].set_ylabel("instructions")
    axes[1, 0].set_ylabel("instructions a point\nand evaluation")
    axes[1, 3].set_ylabel("instructions a view")
    axes[0, 0].legend(loc="upper left")
    figure.align_ylabels(axes[:, 0])
    figure.tight_layout()
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=90, metadata={"Software": None})


def main():
    build()
    print(run("gcc", "--version").splitlines()[0] + ", -O2, double, callgrind")
    print("commit " + run("git", "log", "-1", "--format=%h").strip())
    adjusted = {name: [(rig, *count("adjust", rig)) for rig in rigs]
                for name, rigs in ADJUSTED.items()}
    joined = [(rig, count("join", rig)[0]) for rig in JOINED]
    for name, rows in adjusted.items():
        print_table(f"adjusted, {name} vary", rows)
    print("\n| joined, placements vary | 1000 instructions | a view |\n| --- | ---: | ---: |")
    for (C, F, n), total in joined:
        print(f"| {C} x {F} x {n} | {total / 1000:.0f} | {total / (C * F):.0f} |")
    draw(adjusted, joined)
    each = [total / (C * F) for (C, F, _), total in joined]
    if max(each) > LINEAR * each[0]:
        sys.exit(f"rig_growth: the join is not linear in the views: {each[0]:.0f} to "
                 f"{max(each):.0f} instructions a view")


if __name__ == "__main__":
    main()
