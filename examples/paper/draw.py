#!/usr/bin/env python3
"""Draws the figures of the experiments: draw.py DATA FIGURES.

Reads the CSV files that rigcal_paper wrote into DATA, writes a PNG and an SVG a
figure into FIGURES. The same numbers give the same SVG.
"""
import csv
import io
import pathlib
import sys

import claims
import numpy as np
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end
from matplotlib.colors import ListedColormap  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch, Rectangle  # noqa: E402
from PIL import Image  # noqa: E402 -- matplotlib brings it

# Okabe and Ito's colours, which the colour-blind can tell apart.
GREY, PINK, GREEN = "#e4e4e4", "#cc79a7", "#009e73"
OUTCOMES = {"no solution": GREY, "false": PINK, "correct": GREEN}
STYLES = {
    "published3": dict(color="#e69f00", marker="^", ls="-",
                       label="published, three points"),
    "published": dict(color="#d55e00", marker="s", ls="-",
                      label="published, four points"),
    "no_guess": dict(color="#0072b2", marker="o", ls="-",
                     label="the library's solver, no guess"),
    "shape": dict(color="#56b4e9", marker="D", ls="-",
                  label="the same, using the target's shape"),
    "bound": dict(color="black", marker="", ls="--", label="Cramér-Rao bound"),
}
OPEN_DOCUMENTED = Line2D([], [], color="#555555", marker="o", mfc="none", ms=6,
                         ls="", label="open: the documented scene")
DEPTHS = ("50", "100", "200")
LINES = (":", "-", "--")  # of the depths
DRAWN_FROM = ""  # identifies the numbers, in each SVG

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 10,
    "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6,
    "axes.axisbelow": True, "lines.linewidth": 1.6, "lines.markersize": 3.8,
    "legend.frameon": False, "svg.hashsalt": "rigcal", "figure.dpi": 100,
    "savefig.facecolor": "white",
})


def read(data, name):
    with open(data / f"{name}.csv", newline="") as file:
        return list(csv.DictReader(file))


def save(figure, folder, name):
    figure.savefig(folder / f"{name}.svg",
                   metadata={"Date": None, "Description": DRAWN_FROM})
    pixels = io.BytesIO()
    figure.savefig(pixels, format="png", dpi=140)
    plt.close(figure)
    # 200 colours are enough for these maps, and halve the bytes
    Image.open(pixels).convert("RGB").quantize(
        200, method=Image.MEDIANCUT, dither=Image.NONE).save(
            folder / f"{name}.png", optimize=True)


def legend_below(figure, handles, columns, y=0.0):
    figure.legend(handles=handles, ncol=columns, loc="lower center",
                  bbox_to_anchor=(0.5, y), columnspacing=1.6,
                  handlelength=2.6)


def style(name, **change):
    return {**STYLES[name], **change}


def handle(name, **change):
    return Line2D([], [], **style(name, **change))


# ---- maps ------------------------------------------------------------------

OUTCOME_HANDLES = [Patch(facecolor=color, edgecolor="#888888", label=name)
                   for name, color in OUTCOMES.items()]
TRUTH = dict(marker="+", color="black", ms=11, mew=1.6, ls="")
OPEN = dict(marker="o", ms=8, mec="#0072b2", mew=2, ls="", color="white")
DOT = dict(marker="o", ms=10, mec="white", mew=1.5, ls="", color="#0072b2")


def draw_map(axes, rows, title, dot=None):
    """A map: one cell for each guess, coloured by what the guess led to."""
    cells = np.array([[int(c) for c in row["outcomes_over_roll"]]
                      for row in rows])
    axes.imshow(cells, origin="lower", extent=(-180, 180, -90, 90),
                cmap=ListedColormap(list(OUTCOMES.values())), vmin=0, vmax=2,
                interpolation="nearest", aspect="equal")
    axes.grid(False)
    axes.set_xticks(range(-180, 181, 90))
    axes.set_yticks(range(-90, 91, 45))
    truth = float(rows[0]["true_roll_deg"]), float(rows[0]["true_pitch_deg"])
    axes.plot(*truth, **(DOT if dot == "correct" else TRUTH))
    axes.set_title(f"{title}\n{100 * np.mean(cells == 2):.1f} % correct, "
                   f"{100 * np.mean(cells == 1):.1f} % false")


MAPS = (("3", "2", "three points, published"),
        ("4", "2", "four points, published"),
        ("4", "0", "four points, all pairs eliminate"))


def map_figure(data, out, name, what):
    rows, exact = read(data, name), read(data, "three_points")
    digital = "1" if name == "fig08" else "0"
    cameras = sorted({row["camera"] for row in rows})
    figure, axes = plt.subplots(len(cameras), 3, squeeze=False,
                                figsize=(11, 2.2 * len(cameras) + 0.9),
                                sharex=True, sharey=True)
    for k, camera in enumerate(cameras):
        for column, (points, pairs, title) in enumerate(MAPS):
            these = [row for row in rows
                     if (row["camera"], row["points"], row["pairs_used"])
                     == (camera, points, pairs)]
            draw_map(axes[k, column], these, f"camera {camera}: {title}",
                     these[0]["no_guess"] if points == "4" else None)
        for pose in exact:
            if (pose["digital"], pose["camera"]) == (digital, camera):
                axes[k, 0].plot(float(pose["roll_deg"]),
                                float(pose["pitch_deg"]),
                                **(DOT if pose["outcome"] == "correct"
                                   else OPEN))
        axes[k, 0].set_ylabel("guess of pitch [deg]")
    for ax in axes[-1]:
        ax.set_xlabel("guess of roll [deg]")
    legend_below(figure, OUTCOME_HANDLES + [
        Line2D([], [], label="truth, found by the library's solver without a "
               "guess", **DOT),
        Line2D([], [], label="its other poses", **OPEN)], 5)
    figure.suptitle(what, fontsize=11, y=0.985)
    figure.tight_layout(rect=(0, 0.11 / len(cameras), 1, 1.02))
    save(figure, out, name)


def figure_5(data, out):
    rows, maps = read(data, "fig05"), read(data, "fig05_map")
    figure = plt.figure(figsize=(11, 5.2))
    grid = figure.add_gridspec(2, 3, width_ratios=(1, 1, 0.95))
    titles = {("two_angles", 0): "two angles, published",
              ("two_angles_all", 0): "two angles, all pairs eliminate",
              ("three_angles", 5): "three angles, yaw off by 5°",
              ("three_angles", 120): "three angles, yaw off by 120°"}
    for k, ((method, off), title) in enumerate(titles.items()):
        axes = figure.add_subplot(grid[k // 2, k % 2])
        draw_map(axes, [row for row in maps if row["method"] == method and
                        float(row["yaw_error_deg"]) == off], title)
        if k >= 2:
            axes.set_xlabel("guess of roll [deg]")
        else:
            axes.tick_params(labelbottom=False)
        if k % 2 == 0:
            axes.set_ylabel("guess of pitch [deg]")
        else:
            axes.tick_params(labelleft=False)
    styles = {"three_angles": dict(color="#56b4e9", marker="o",
                                   label="three angles searched"),
              "two_angles": dict(color="#d55e00", marker="",
                                 label="two, published"),
              "two_angles_all": dict(color="#555555", marker="", ls="-.",
                                     label="two, all pairs")}
    shares = figure.add_subplot(grid[0, 2])
    evals = figure.add_subplot(grid[1, 2], sharex=shares)
    for method, look in styles.items():
        these = [row for row in rows if row["method"] == method]
        x = [float(row["yaw_error_deg"]) for row in these]
        y = [100 * int(row["correct"]) / int(row["tried"]) for row in these]
        used = [float(row["evals_median"]) for row in these]
        if len(x) == 1:  # it does not use the guess
            x, y, used = [0, 180], y * 2, used * 2
        shares.plot(x, y, **look)
        evals.plot(x, used, **look)
    shares.set_ylim(0, 60)
    shares.set_ylabel("correct [%]")
    shares.set_title("1000 random placements")
    shares.legend(fontsize=8, labelspacing=0.25)
    evals.set_ylim(0, 800)
    evals.set_ylabel("evaluations, median")
    evals.set_xlabel("error of the guess of yaw [deg]")
    evals.set_xticks(range(0, 181, 45))
    figure.suptitle("Figure 5: three angles against two, four points, "
                    "perfect images", fontsize=11)
    legend_below(figure, OUTCOME_HANDLES +
                 [Line2D([], [], label="truth", **TRUTH)], 4)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    save(figure, out, "fig05")


# ---- curves ----------------------------------------------------------------

def figure_6(data, out):
    rows, shares = read(data, "fig06"), read(data, "fig06_share")
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.9))
    for name, points, method in (("published3", "3", "published"),
                                 ("published", "4", "published"),
                                 ("no_guess", "4", "no_guess")):
        these = [row for row in rows
                 if (row["points"], row["method"]) == (points, method)]
        x = [float(row["depth_cm"]) for row in these]
        for ax, quantity in zip(axes[1:], ("residual", "rotation_deg")):
            low, middle, high = ([float(row[f"{quantity}_{q}"]) for row in these]
                                 for q in ("q25", "median", "q75"))
            ax.plot(x, middle, **style(name))
            ax.fill_between(x, low, high, color=STYLES[name]["color"],
                            alpha=0.15, lw=0)
        for scenes in ("random", "documented"):
            these = [row for row in shares if (row["points"], row["method"],
                                               row["scenes"])
                     == (points, method, scenes)]
            y = [100 * (int(row["correct"]) + int(row["false"])) /
                 int(row["tried"]) for row in these]
            look = style(name) if scenes == "random" else style(
                name, ls="", mfc="none", ms=6, mew=0.8)
            if scenes == "random" or method == "published":
                axes[0].plot(x, y, clip_on=False, **look)
        if points == "3":
            axes[0].plot(x, [100 * int(row["correct"]) / int(row["tried"])
                             for row in shares if row["points"] == points and
                             row["scenes"] == "random"],
                         **style(name, marker="", ls=":"))
    axes[0].set_ylim(0, 100)
    axes[0].set_ylabel("guesses that converge [%]")
    for ax, label, top in zip(axes[1:], ("residual: the published objective",
                                         "rotation error [deg]"), (1e-8, 1e-6)):
        ax.set_yscale("log")
        ax.set_ylim(1e-16, top)
        ax.set_ylabel(label)
    for ax, title in zip(axes, ("guesses of all directions",
                                "searches that are correct",
                                "searches that are correct")):
        ax.set_xlim(0, 330)
        ax.set_xticks((20, 80, 160, 240, 320))
        ax.set_xlabel("depth of the target [cm]")
        ax.set_title(title)
    legend_below(figure, [handle("published3"),
                          Line2D([], [], color=STYLES["published3"]["color"],
                                 ls=":", label="of these, the correct ones"),
                          handle("published"), handle("no_guess"),
                          OPEN_DOCUMENTED], 3)
    figure.suptitle("Figure 6: perfect images, any depth", fontsize=11)
    figure.tight_layout(rect=(0, 0.12, 1, 1))
    save(figure, out, "fig06")


def by_depth(n_rows, height, title):
    figure, axes = plt.subplots(n_rows, 3, figsize=(11, height), sharex=True,
                                sharey="row", squeeze=False)
    for column, depth in enumerate(DEPTHS):
        axes[0, column].set_title(f"target at {depth} cm")
        axes[-1, column].set_xlabel("image width = height [px]")
        axes[-1, column].set_xscale("log", base=2)
        axes[-1, column].set_xticks((32, 64, 128, 256, 512, 1024))
        axes[-1, column].set_xticklabels(("32", "64", "128", "256", "512",
                                          "1024"))
    figure.suptitle(title, fontsize=11)
    return figure, axes


def figure_9(data, out):
    rows = read(data, "fig09")
    figure, axes = by_depth(2, 5.0, "Figure 9: correct and false against "
                            "resolution, one random guess a placement")
    for column, depth in enumerate(DEPTHS):
        for name, points, method in (("published3", "3", "published"),
                                     ("published", "4", "published"),
                                     ("no_guess", "4", "no_guess")):
            for scenes in ("random", "documented"):
                these = [row for row in rows if
                         (row["depth_cm"], row["points"], row["method"],
                          row["scenes"]) == (depth, points, method, scenes)]
                x = [int(row["width_px"]) for row in these]
                for k, share in enumerate(("correct", "false")):
                    y = [100 * int(row[share]) / int(row["tried"])
                         for row in these]
                    look = style(name) if scenes == "random" else style(
                        name, ls="", mfc="none", ms=6, mew=0.8)
                    axes[k, column].plot(x, y, clip_on=False, **look)
    for row, label in zip(axes, ("correct [%]", "false [%]")):
        row[0].set_ylabel(label)
        row[0].set_ylim(0, 100)
    legend_below(figure, [handle(n) for n in
                          ("published3", "published", "no_guess")] +
                 [OPEN_DOCUMENTED], 4)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    save(figure, out, "fig09")


def quartile_curves(data, out, name, title, quantities, methods, height,
                    twins=None):
    """Rows of quantities, columns of depths: medians with quartiles, the
    documented scene as dots."""
    rows = read(data, name)
    figure, axes = by_depth(len(quantities), height, title)
    for k, (quantity, label) in enumerate(quantities):
        for column, depth in enumerate(DEPTHS):
            ax = axes[k, column]
            for method in methods:
                these = [row for row in rows if
                         (row["depth_cm"], row["quantity"], row["method"])
                         == (depth, quantity, method)]
                if not these:
                    continue
                x = [int(row["width_px"]) for row in these]
                low, middle, high = ([float(row[q]) for row in these]
                                     for q in ("q25", "median", "q75"))
                ax.plot(x, middle, zorder=5 if method == "bound" else 3,
                        **style(method))
                if method in ("published", "no_guess"):
                    ax.fill_between(x, low, high, alpha=0.15, lw=0,
                                    color=STYLES[method]["color"])
                if method == "published" and not twins:
                    ax.plot(x, [float(row["documented"]) for row in these],
                            **style(method, ls="", mfc="none", mew=0.7,
                                    alpha=0.8))
                if twins and method != "bound":
                    other = [float(row["median"]) for row in rows if
                             (row["depth_cm"], row["quantity"], row["method"])
                             == (depth, twins[quantity], method)]
                    ax.plot(x, other, **style(method, ls="", mfc="none",
                                              marker="o", ms=6.5, mew=0.8))
            ax.set_yscale("log")
        axes[k, 0].set_ylabel(label)
    notes = [Line2D([], [], color="#555555", marker="o", mfc="none", ms=6.5,
                    ls="", label="open: camera 2")] if twins else [
        Line2D([], [], color="#d55e00", marker="s", mfc="none", ls="",
               label="open: published, the documented scene")]
    handles = [handle(m) for m in methods if m in {r["method"] for r in rows}]
    legend_below(figure, handles + notes, 3 if len(handles) > 3 else 4)
    figure.tight_layout(rect=(0, 0.09 if len(handles) > 3 else 0.05, 1, 1))
    save(figure, out, name)


def figures_10_to_13(data, out):
    three = ("published", "no_guess", "bound")
    quartile_curves(
        data, out, "fig10", "Figure 10: camera to target, against resolution",
        (("residual", "residual (published)"),
         ("rotation_deg", "rotation error [deg]"),
         ("translation_cm", "translation error [cm]")), three, 6.9)
    quartile_curves(
        data, out, "fig11", "Figure 11: camera to camera, against resolution",
        (("match_px", "matches from lines [px]"),
         ("rotation_deg", "rotation error [deg]"),
         ("translation_cm", "translation error [cm]")), three, 6.9)
    quartile_curves(
        data, out, "fig12", "Figure 12: the four points in space, against "
        "resolution", (("depth_1_cm", "depth error [cm]"),
                       ("position_1_cm", "position error [cm]")),
        ("published", "no_guess", "shape", "bound"), 5.4,
        {"depth_1_cm": "depth_2_cm", "position_1_cm": "position_2_cm"})
    quartile_curves(
        data, out, "fig13", "Figure 13: spectral norm of the difference of "
        "rotations, against resolution",
        (("target", "camera to target"), ("camera", "camera to camera")),
        three, 5.0)


def figure_stable(data, out):
    """One quantity on linear axes, a part of them enlarged, and on log axes."""
    rows = [row for row in read(data, "fig10")
            if row["quantity"] == "rotation_deg"]
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.0))
    for ax in axes:
        for method in ("published", "no_guess"):
            for depth, ls in zip(DEPTHS, LINES):
                these = [row for row in rows if (row["depth_cm"], row["method"])
                         == (depth, method)]
                ax.plot([int(row["width_px"]) for row in these],
                        [float(row["median"]) for row in these],
                        **style(method, ls=ls))
        ax.axvline(500, color="#555555", lw=1, ls=(0, (1, 1)))
        ax.set_xlabel("image width = height [px]")
    top = 1.05 * max(float(row["median"]) for row in rows
                     if row["method"] == "published")
    left, zoomed, logs = axes
    left.set_xlim(0, 1060)
    left.set_ylim(0, top)
    left.set_xticks((32, 256, 512, 768, 1024))
    left.set_ylabel("rotation error [deg]")
    left.set_title("linear axes: it looks stable")
    zoomed.set_xlim(480, 1060)
    zoomed.set_ylim(0, top / 10)
    zoomed.set_xticks((512, 640, 768, 896, 1024))
    zoomed.set_title("the black frame, enlarged: it is not")
    left.add_patch(Rectangle((480, 0), 580, top / 10, fill=False, lw=1.2,
                             clip_on=False, zorder=6))
    logs.set_xscale("log", base=2)
    logs.set_yscale("log")
    logs.set_xticks((32, 64, 128, 256, 512, 1024))
    logs.set_xticklabels(("32", "64", "128", "256", "512", "1024"))
    logs.set_yticks((0.1, 1, 10))
    logs.set_yticklabels(("0.1", "1", "10"))
    logs.plot((32, 1024), (1.6, 0.05), color="black", lw=1)
    logs.text(36, 0.06, "slope: half the pixel,\nhalf the error")
    logs.set_title("log axes: it halves with the pixel")
    legend_below(figure, [handle("published"), handle("no_guess")] +
                 [Line2D([], [], color="#555555", ls=ls, label=f"{d} cm")
                  for d, ls in zip(DEPTHS, LINES)] +
                 [Line2D([], [], color="#555555", lw=1, ls=(0, (1, 1)),
                         label="500 px")], 6)
    figure.suptitle("Does the error stop falling at 500 px? Rotation, camera to "
                    "target, the same medians three times", fontsize=11)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    save(figure, out, "stable")


def figure_14_settling(data, out):
    lines, rows = read(data, "fig14_settling"), read(data, "fig14_unsettled")
    widths = ("32", "64", "128", "256", "512", "1024")
    shades = plt.get_cmap("viridis")(np.linspace(0.88, 0, len(widths)))
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.4))
    for ax, method, title in zip(axes, ("published", "no_guess"), (
            "published", "the library's solver")):
        for row in lines[:1] + [r for r in lines if r["point"] == "2"][:1]:
            ax.plot(float(row["match_u"]), float(row["match_v"]), "o",
                    color="black", ms=5, zorder=6)
        # Enlarges the left end of one line, where the image is empty.
        inset = ax.inset_axes((0.05, 0.04, 0.28, 0.40))
        for part in (ax, inset):
            for row in lines:
                if row["method"] not in (method, "true"):
                    continue
                if row["method"] == "true":
                    if row["width_px"] != widths[-1]:
                        continue  # it is the same at every resolution
                    look = dict(color="black", lw=1, ls=(0, (2, 2)), zorder=5)
                elif row["width_px"] in widths:
                    k = widths.index(row["width_px"])
                    look = dict(color=shades[k], lw=2.6 - 0.3 * k)
                else:
                    continue
                part.plot([float(row["u1"]), float(row["u2"])],
                          [float(row["v1"]), float(row["v2"])], **look)
            part.set_aspect("equal", adjustable="box")
            part.grid(False)
        ax.set_xlim(-0.5, 0.5)
        ax.set_ylim(0.5, -0.5)
        ax.set_title(f"image 1, {title}")
        ax.set_xlabel("u [inch]")
        inset.set_xlim(-0.5, -0.4)
        inset.set_ylim(-0.08, -0.225)
        inset.set_xticks(())
        inset.set_yticks(())
        ax.indicate_inset_zoom(inset, edgecolor="#555555")
    axes[0].set_ylabel("v [inch]")
    ax = axes[2]
    for method in ("published", "no_guess"):
        these = [row for row in rows if (row["depth_cm"], row["method"])
                 == ("100", method)]
        x = [int(row["width_px"]) for row in these]
        low, middle, high = ([float(row[f"off_inch_{q}"]) for row in these]
                             for q in ("q25", "median", "q75"))
        ax.plot(x, middle, **style(method))
        ax.fill_between(x, low, high, color=STYLES[method]["color"], alpha=0.15,
                        lw=0)
        ax.plot(x, [np.mean([float(row["off_inch"]) for row in lines if
                             (row["width_px"], row["method"]) == (str(w), method)])
                    for w in x], **style(method, ls="", mfc="none", ms=6,
                                         mew=0.8))
    ax.set_xscale("log", base=2)
    ax.set_yscale("log")
    ax.set_xticks((32, 64, 128, 256, 512, 1024))
    ax.set_xticklabels(("32", "64", "128", "256", "512", "1024"))
    ax.set_xlabel("image width = height [px]")
    ax.set_ylabel("farthest from the true line [inch]")
    ax.set_title("how far the line is off within image 1")
    legend_below(figure, [
        *(Line2D([], [], color=shades[k], lw=2.6 - 0.3 * k, label=f"{w} px")
          for k, w in enumerate(widths)),
        Line2D([], [], color="black", lw=1, ls=(0, (2, 2)), label="true line"),
        Line2D([], [], color="black", marker="o", ls="", ms=5,
               label="true match"),
        handle("published", label="published"),
        handle("no_guess", label="library's solver"), OPEN_DOCUMENTED], 6)
    figure.suptitle("Figure 14: matching lines on camera 1 of two points of "
                    "image 2, from 32 to 1024 px", fontsize=11)
    figure.tight_layout(rect=(0, 0.11, 1, 1))
    save(figure, out, "fig14_settling")


def figure_14(data, out):
    lines, rows = read(data, "fig14_lines"), read(data, "fig14")
    widths = ("32", "64", "128", "256")
    figure = plt.figure(figsize=(11, 6.0))
    grid = figure.add_gridspec(2, 4, height_ratios=(1.25, 1))
    for k, width in enumerate(widths):
        ax = figure.add_subplot(grid[0, k])
        for point in ("1", "2"):
            these = [row for row in lines if
                     (row["width_px"], row["point"]) == (width, point)]
            u, truth, published, found, sigma = (
                np.array([float(row[c]) for row in these]) for c in
                ("u", "true_v", "published_v", "no_guess_v", "sigma_v"))
            ax.fill_between(u, found - 1.96 * sigma, found + 1.96 * sigma,
                            color="#0072b2", alpha=0.2, lw=0)
            ax.plot(u, published, color="#d55e00", lw=1.2)
            ax.plot(u, found, color="#0072b2", lw=1.2)
            ax.plot(u, truth, color="black", lw=1, ls=":")
            ax.plot(float(these[0]["match_u"]), float(these[0]["match_v"]),
                    "o", color="black", ms=4)
        ax.set_xlim(-0.5, 0.5)
        ax.set_ylim(0.38, -0.38)
        ax.set_xticks((-0.4, 0, 0.4))
        ax.set_title(f"{width} x {width} px")
        ax.set_xlabel("u in image 2 [inch]")
        if k == 0:
            ax.set_ylabel("v [inch]")
    for k, (ylabel, depth) in enumerate((("match from line [px]", None),
                                         ("matches within band [%]", "all"))):
        ax = figure.add_subplot(grid[1, 2 * k:2 * k + 2])
        for d, ls in zip(DEPTHS, LINES):
            for method in ("published", "no_guess"):
                these = [row for row in rows if
                         (row["depth_cm"], row["method"]) == (d, method)]
                x = [int(row["width_px"]) for row in these]
                if depth is None:
                    ax.plot(x, [float(r["off_px_median"]) for r in these],
                            **style(method, ls=ls, label=None))
                elif method == "no_guess":
                    ax.plot(x, [100 * float(r["within_95"]) for r in these],
                            **style(method, ls=ls, label=f"target at {d} cm"))
            if depth is None:
                # median of |normal| is 0.6745 sigma
                ax.plot(x, [0.6745 * float(r["sigma_px_median"])
                            for r in these], color="black", lw=1, ls=ls)
        ax.set_xscale("log", base=2)
        ax.set_xticks((32, 64, 128, 256, 512, 1024))
        ax.set_xticklabels(("32", "64", "128", "256", "512", "1024"))
        ax.set_xlabel("image width = height [px]")
        ax.set_ylabel(ylabel)
        if depth is None:
            ax.set_ylim(0, 0.85)
            ax.set_title("1000 random placements, two points each: medians")
        else:
            ax.axhline(95, color="black", lw=1)
            ax.set_ylim(85, 100)
            ax.set_title("how often the predicted 95 % band holds the match")
            ax.legend(loc="lower right", ncol=3, fontsize=8)
    legend_below(figure, [
        Line2D([], [], color="#d55e00", label="published"),
        Line2D([], [], color="#0072b2", label="the library's solver"),
        Patch(facecolor="#0072b2", alpha=0.2, label="its predicted 95 % band"),
        Line2D([], [], color="black", ls=":", label="true line (top)"),
        Line2D([], [], color="black", marker="o", ls="", ms=4,
               label="true match"),
        Line2D([], [], color="black", lw=1, label="predicted (bottom)")], 6)
    figure.suptitle("Figure 14, ours: matching lines on camera 2 and how far to "
                    "trust them", fontsize=11)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    save(figure, out, "fig14")


# ---- our own ---------------------------------------------------------------

def figure_choices(data, out):
    choices, bins = read(data, "choices"), read(data, "conditions")
    names = ("yaw", "pitch", "roll", "best")
    labels = ("yaw", "pitch", "roll", "the best\nconditioned")
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.1))
    looks = {"2": dict(color="#d55e00", marker="s", label="by two pairs, as published"),
             "all": dict(color="#555555", marker="v", label="by all six pairs")}
    for pairs, look in looks.items():
        these = [next(row for row in choices if row["choice"] == f"{n}_{pairs}")
                 for n in names]
        x = np.arange(4) + (-0.15 if pairs == "2" else 0.15)
        axes[0].bar(x, [100 * int(row["correct_from_anywhere"]) /
                        int(row["placements"]) for row in these], 0.28,
                    color=look["color"])
        low, middle, high = (np.array([float(row[f"over_sigma_{q}"])
                                       for row in these])
                             for q in ("q25", "median", "q75"))
        axes[1].errorbar(x, middle, (middle - low, high - middle), ls="",
                         capsize=4, ms=5.5, marker=look["marker"],
                         color=look["color"])
    for ax in axes[:2]:
        ax.set_xticks(range(4))
        ax.set_xticklabels(labels)
        ax.set_xlabel("angle eliminated")
        ax.set_ylim(bottom=0)
        ax.grid(axis="x", visible=False)
    axes[0].set_ylabel("correct from one random guess [%]")
    axes[1].set_ylabel("rotation error / 1-sigma of the bound")
    axes[1].axhline(1, color="black", lw=1, ls="--")
    these = [row for row in bins if int(row["n"]) >= 30]
    x = [(float(row["condition_from"]) * float(row["condition_to"])) ** 0.5
         for row in these]
    low, middle, high = ([float(row[f"over_sigma_{q}"]) for row in these]
                         for q in ("q25", "median", "q75"))
    axes[2].plot(x, middle, marker="s", color="#d55e00")
    axes[2].fill_between(x, low, high, color="#d55e00", alpha=0.15, lw=0)
    axes[2].axhline(1, color="black", lw=1, ls="--")
    axes[2].set_xscale("log")
    axes[2].set_yscale("log")
    axes[2].set_yticks((0.5, 1, 2, 5, 10, 20))
    axes[2].set_yticklabels(("0.5", "1", "2", "5", "10", "20"))
    axes[2].minorticks_off()
    axes[2].set_xlabel("cond(A): yaw, every choice of two pairs")
    axes[2].set_ylabel("rotation error / 1-sigma of the bound")
    figure.suptitle("Which angle, which pairs: 512 x 512 px, 100 cm, 1000 "
                    "random placements, medians and quartiles", fontsize=11)
    legend_below(figure, [Patch(facecolor=look["color"], label=look["label"])
                          for look in looks.values()] +
                 [Line2D([], [], color="black", lw=1, ls="--",
                         label="1-sigma of the Cramér-Rao bound")], 3)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    save(figure, out, "choices")


def figure_bound(data, out):
    rows = read(data, "over_bound")
    figure, axes = plt.subplots(1, 2, figsize=(11, 3.6), sharey=True)
    for ax, quantity in zip(axes, ("rotation", "translation")):
        ax.axhspan(0.95, 1.05, color="#dddddd", lw=0)
        ax.axhline(1, color="black", lw=1, ls="--")
        for depth, ls in zip(DEPTHS, LINES):
            full = {row["width_px"] for row in rows if row["depth_cm"] == depth
                    and row["method"] == "no_guess"
                    and row["tried"] == row["correct"]}
            for method in ("published", "no_guess"):
                these = [row for row in rows if
                         (row["depth_cm"], row["method"]) == (depth, method)
                         and row["width_px"] in full]
                ax.plot([int(row["width_px"]) for row in these],
                        [float(row[quantity]) for row in these],
                        **style(method, ls=ls))
        ax.set_xscale("log", base=2)
        ax.set_xticks((64, 128, 256, 512, 1024))
        ax.set_xticklabels(("64", "128", "256", "512", "1024"))
        ax.set_ylim(0.8, 3)
        ax.set_xlabel("image width = height [px]")
        ax.set_title(f"{quantity}, camera to target")
    axes[0].set_ylabel("rms error / Cramér-Rao bound")
    legend_below(figure, [handle("published", label="published, of its correct solutions"),
                          handle("no_guess")] +
                 [Line2D([], [], color="#555555", ls=ls, label=f"{d} cm")
                  for d, ls in zip(DEPTHS, LINES)] +
                 [Patch(facecolor="#dddddd", label="within 5 %")], 6)
    figure.suptitle("How near each comes to the best there is: 1000 random "
                    "placements", fontsize=11)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    save(figure, out, "bound")


def main():
    global DRAWN_FROM
    data, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    DRAWN_FROM = f"numbers {claims.digest(data)}"
    out.mkdir(parents=True, exist_ok=True)
    for name, what in (("fig03", "Figure 3: where a guess leads, camera 1, "
                        "perfect image"),
                       ("fig04", "Figure 4: where a guess leads, camera 2, "
                        "perfect image"),
                       ("fig08", "Figure 8: four points against three, digital "
                        "images, 512 x 512 px")):
        map_figure(data, out, name, what)
    for figure in (figure_5, figure_6, figure_9, figures_10_to_13,
                   figure_stable, figure_14_settling, figure_14, figure_choices, figure_bound):
        figure(data, out)


if __name__ == "__main__":
    main()
