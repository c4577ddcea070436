#!/usr/bin/env python3
"""Draws what rigcal_matching wrote: draw.py CORNERS_AND_BANDS_FOLDER PNG.

Corners of the left image; the band of each in the right image, with all the corners there;
and one place of a band magnified.
"""
import csv
import pathlib
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end

# Okabe and Ito's colours, which the colour-blind can tell apart.
COLOURS = ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#000000"]
WIDTH, HEIGHT = 640, 480
PLACE = 3
MAGNIFIED = 3  # which of the bands
REACH = 9      # pixels on each side of what is magnified

plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 10,
                     "savefig.facecolor": "white"})


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def band_of(bands, corner):
    mine = bands["corner"] == corner
    middle = np.stack([bands["u"][mine], bands["v"][mine]], 1)
    across = np.stack([bands["across_u"][mine], bands["across_v"][mine]], 1)
    half = bands["half_width"][mine][:, None]
    return middle, np.concatenate([middle - half * across, (middle + half * across)[::-1]])


def draw_bands(axes, corners, bands, chosen, size):
    for colour, corner in zip(COLOURS, chosen):
        middle, outline = band_of(bands, corner)
        axes.fill(*outline.T, color=colour, alpha=0.35, lw=0)
        axes.plot(*middle.T, color=colour, lw=0.6)
    axes.plot(corners["u_true"], corners["v_true"], "+", color="#444444", ms=size, mew=0.8)
    for colour, corner in zip(COLOURS, chosen):
        mine = corners["corner"] == corner
        axes.plot(corners["u_true"][mine], corners["v_true"][mine], "o", mec=colour,
                  mfc="none", ms=1.5 * size, mew=1.3)


def main():
    folder, png = map(pathlib.Path, sys.argv[1:])
    corners, bands = read(folder / "corners.csv"), read(folder / "bands.csv")
    corners = {name: values[corners["place"] == PLACE] for name, values in corners.items()}
    chosen = sorted(set(bands["corner"].astype(int)))[:len(COLOURS)]
    figure, (left, right, near) = plt.subplots(
        1, 3, figsize=(9.6, 2.95), layout="constrained",
        gridspec_kw={"width_ratios": [1, 1, 0.75]})

    left.plot(corners["u"], corners["v"], "+", color="#444444", ms=5, mew=0.8)
    for colour, corner in zip(COLOURS, chosen):
        mine = corners["corner"] == corner
        left.plot(corners["u"][mine], corners["v"][mine], "o", mec=colour, mfc="none", ms=8,
                  mew=1.3)
    left.set_title("left image: seven of its 54 corners")
    draw_bands(right, corners, bands, chosen, 5)
    right.set_title("right image: the band of each")
    for axes in (left, right):
        axes.set(xlim=(-0.5, WIDTH - 0.5), ylim=(HEIGHT - 0.5, -0.5), aspect="equal",
                 xticks=[0, 200, 400, 600], yticks=[0, 200, 400])

    mine = corners["corner"] == chosen[MAGNIFIED]
    u, v = corners["u_true"][mine][0], corners["v_true"][mine][0]
    draw_bands(near, corners, bands, chosen, 9)
    near.set(xlim=(u - REACH, u + REACH), ylim=(v + REACH, v - REACH), aspect="equal")
    near.set_title(f"one of them: {2 * REACH} x {2 * REACH} pixels")
    right.indicate_inset([u - REACH, v - REACH, 2 * REACH, 2 * REACH], edgecolor="black")
    figure.savefig(png, dpi=100)


if __name__ == "__main__":
    main()
