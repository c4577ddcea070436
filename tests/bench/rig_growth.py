#!/usr/bin/env python3
"""How the instructions of rigcal_rig_adjust and rigcal_rig_join grow with cameras, placements
and points: Markdown tables, and tests/bench/figures/rig_growth.png. Run by hand; wants
valgrind, gcc, CMake and matplotlib; takes some minutes.

    python3 tests/bench/rig_growth.py

Built by gcc -O2 in build/instructions, double. The rigs are those of bench_rigs.h: all seen,
started from composed poses. One number varies at a time. Exit status 1 if the join's
instructions a view and evaluation grow by more than 20 % over its range.
"""
import io
import pathlib
import re
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end
from matplotlib.ticker import (  # noqa: E402
    FixedLocator, FuncFormatter, LogLocator, NullLocator)
from PIL import Image  # noqa: E402 -- matplotlib brings it

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/instructions"
PICTURE = ROOT / "tests/bench/figures/rig_growth.png"
LINEAR = 1.2

# The number that varies, and the rigs: cameras, placements, points.
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
    """The instructions, and the evaluations of each view."""
    counts = BUILD / "callgrind.out"
    printed = run("valgrind", "--tool=callgrind", f"--toggle-collect=bench_{what}",
                  f"--callgrind-out-file={counts}", BUILD / "tests/bench_rig", what, *rig)
    total = int(re.search(r"^totals: *(\d+)", counts.read_text(), re.M)[1])
    return total, int(re.search(r"^evaluations (\d+)", printed)[1])


def print_table(name, rows, is_join=False):
    print(f"\n| {name} | evaluations | 1000 instructions | a {'view' if is_join else 'point'} "
          "and evaluation |\n| --- | ---: | ---: | ---: |")
    for (C, F, n), total, evaluations in rows:
        parts = C * F * (1 if is_join else n)
        print(f"| {C} x {F} x {n} | {evaluations} | {total / 1000:.0f} | "
              f"{total / (parts * evaluations):.0f} |")


def plain(axis, ticks=None):
    """Writes numbers in full, not as powers of ten; at 1, 2 and 5, or at `ticks`."""
    if ticks:
        axis.set_major_locator(FixedLocator(ticks))
    else:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def draw_panel(axes, x, rows, parts, colour):
    """Above: millions of instructions in all and for each evaluation. Below: for each
    evaluation and part, which is a point or a view."""
    top, below = axes
    once = [total / evaluations for _, total, evaluations in rows]
    top.loglog(x, [total / 1e6 for _, total, _ in rows], "o", color=colour, mfc="none",
               label="until it ends")
    top.loglog(x, [n / 1e6 for n in once], "o-", color=colour, label="an evaluation")
    top.loglog(x, [once[-1] / 1e6 * v / x[-1] for v in x], "--", color="#777777", lw=1,
               label="proportional")
    each = [n / part for n, part in zip(once, parts)]
    below.semilogx(x, each, "o-", color=colour)
    below.set_ylim(0, 1.2 * max(each))
    for panel in axes:
        plain(panel.xaxis, x)
        panel.tick_params(axis="x", labelsize=7.5)
    plain(top.yaxis)


def draw(adjusted, joined):
    plt.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 8.5, "axes.grid": True,
        "grid.color": "#dddddd", "grid.linewidth": 0.6, "axes.axisbelow": True,
        "lines.linewidth": 1.6, "lines.markersize": 4, "legend.fontsize": 8})
    figure, axes = plt.subplots(2, 4, figsize=(9.3, 5.2), sharex="col",
                                gridspec_kw={"height_ratios": [3, 2]})
    for k, (name, rows) in enumerate(adjusted.items()):
        draw_panel(axes[:, k], [rig[k] for rig, _, _ in rows], rows,
                   [C * F * n for (C, F, n), _, _ in rows], "#0072b2")
        axes[0, k].set_title(f"adjustment\n{FIXED[name]}")
        axes[1, k].set_xlabel(f"number of {name}")
    draw_panel(axes[:, 3], [F for (_, F, _), _, _ in joined], joined,
               [C * F for (C, F, _), _, _ in joined], "#d55e00")
    axes[0, 3].set_title("join\n8 cameras x 12 points")
    axes[1, 3].set_xlabel("number of placements")
    axes[0, 0].set_ylabel("million instructions")
    axes[1, 0].set_ylabel("instructions a point\nand evaluation")
    axes[1, 3].set_ylabel("instructions a view\nand evaluation")
    figure.align_ylabels(axes[:, 0])
    figure.tight_layout(rect=(0, 0.05, 1, 1), w_pad=0.3)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncol=3)
    PICTURE.parent.mkdir(exist_ok=True)
    pixels = io.BytesIO()
    figure.savefig(pixels, format="png", dpi=180)
    # 64 colours are enough, and halve the bytes.
    Image.open(pixels).convert("RGB").quantize(
        64, method=Image.MEDIANCUT, dither=Image.NONE).save(PICTURE, optimize=True)


def main():
    build()
    print(run("gcc", "--version").splitlines()[0] + ", -O2, double, callgrind")
    print("commit " + run("git", "log", "-1", "--format=%h").strip())
    adjusted = {name: [(rig, *count("adjust", rig)) for rig in rigs]
                for name, rigs in ADJUSTED.items()}
    joined = [(rig, *count("join", rig)) for rig in JOINED]
    for name, rows in adjusted.items():
        print_table(f"adjusted, {name} vary", rows)
    print_table("joined, placements vary", joined, is_join=True)
    draw(adjusted, joined)
    each = [total / (C * F * evaluations) for (C, F, _), total, evaluations in joined]
    if max(each) > LINEAR * each[0]:
        sys.exit(f"rig_growth: the join is not linear in the views: {each[0]:.0f} to "
                 f"{max(each):.0f} instructions a view and evaluation")


if __name__ == "__main__":
    main()
