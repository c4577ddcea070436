#!/usr/bin/env python3
"""Draws what rigcal monitor prints, and what a monitor can see.

    draw.py FRAMES.csv OUT.png     evidence and poses over time
    draw.py --sees OUT.png         what it can and cannot see, and why
"""
import csv
import sys

import numpy as np
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 -- after the choice of back end

# Okabe and Ito's colours, which the colour-blind can tell apart.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999")
SEEN, UNSEEN, GREY = "#009e73", "#d55e00", "#555555"

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 10, "axes.grid": True,
    "grid.color": "#dddddd", "grid.linewidth": 0.6, "axes.axisbelow": True,
    "legend.frameon": False, "savefig.facecolor": "white",
})


# ---- evidence and poses over time ------------------------------------------------

def read(path):
    """Columns as arrays: NaN where a cell is empty; text stays text."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows or "evidence" not in rows[0]:
        sys.exit(f"draw.py: {path} is not what rigcal monitor prints")

    def column(name):
        cells = [row[name] for row in rows]
        return cells if name == "camera" else np.array([float(c) if c else np.nan for c in cells])
    return {name: column(name) for name in rows[0]}


def poses(frames, camera):
    R = np.stack([frames[f"{camera}.R{i}{j}"] for i in "123" for j in "123"], -1).reshape(-1, 3, 3)
    t = np.stack([frames[f"{camera}.t{k}"] for k in "xyz"], -1)
    return R, t


def changes(frames, camera):
    """The angle in degrees and the length by which a camera has turned and moved since the
    first frame."""
    R, t = poses(frames, camera)
    D = R @ R[0].T
    w = np.stack([D[:, 2, 1] - D[:, 1, 2], D[:, 0, 2] - D[:, 2, 0], D[:, 1, 0] - D[:, 0, 1]], -1)
    centre = -np.einsum("nji,nj->ni", R, t)
    return (np.degrees(np.arcsin(np.clip(np.linalg.norm(w, axis=1) / 2, 0, 1))),
            np.linalg.norm(centre - centre[0], axis=1))


def spans(alarm):
    """First and last frame of each alarm."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], alarm, [0]])))
    return [(a, b - 1) for a, b in zip(edges[::2], edges[1::2])]


def draw_frames(path, out):
    frames = read(path)
    time = frames["time_s"] - frames["time_s"][0]
    cameras = [name[:-4] for name in frames if name.endswith(".R11")]
    figure, (evidence, turn, shift) = plt.subplots(3, 1, figsize=(8, 7), sharex=True,
                                                   gridspec_kw={"height_ratios": (3, 3, 2)})
    evidence.plot(time, np.clip(frames["evidence"], -12, 2), color=GREY, lw=1.2)
    evidence.axhline(0, color=UNSEEN, ls="--", lw=1)
    evidence.text(0.005, -0.3, "alarm", color=UNSEEN, va="top", transform=evidence.get_yaxis_transform())
    evidence.set_ylim(-12.5, 3)
    evidence.set_ylabel("evidence of a move\n(log, over its limit)")
    for first, last in spans(frames["alarm"]):
        for axis in (evidence, turn, shift):
            axis.axvspan(time[first], time[last], color=UNSEEN, alpha=0.15, lw=0)
        sure = frames["probability"][last]
        evidence.annotate(f"{frames['camera'][last]}, probability {sure:.3f}",
                          (time[last], 1.6), (4, 0), textcoords="offset points", va="center")
    for camera, colour in zip(cameras, COLOURS * len(cameras)):
        deg, length = changes(frames, camera)
        turn.plot(time, deg, color=colour, lw=1.4, label=camera)
        sigma = frames[f"{camera}.sigma_rot_deg"]
        turn.fill_between(time, np.maximum(deg - sigma, 0), deg + sigma, color=colour, alpha=0.15, lw=0)
        shift.plot(time, length, color=colour, lw=1.4)
    turn.set_ylabel("turned since the\nfirst frame [degrees]")
    turn.legend(loc="upper left", ncols=min(len(cameras), 4), title="camera")
    turn.set_ylim(bottom=0)
    shift.set_ylim(bottom=0)
    shift.set_ylabel("centre shifted\n[length]")
    shift.set_xlabel("time since the first frame [s]")
    figure.align_ylabels()
    figure.tight_layout()
    figure.savefig(out, dpi=110)


# ---- what it can and cannot see -----------------------------------------------------

def camera(axis, x, y, towards, name):
    """Draws a camera as a triangle that looks at a point."""
    d = np.subtract(towards, (x, y)) / np.linalg.norm(np.subtract(towards, (x, y)))
    side = np.array([-d[1], d[0]])
    p = np.array([x, y])
    corners = [p, p + 0.42 * d + 0.24 * side, p + 0.42 * d - 0.24 * side]
    axis.add_patch(plt.Polygon(corners, fc="#e4e4e4", ec=GREY, lw=1.2, zorder=3))
    axis.text(*(p - 0.32 * d), name, ha="center", va="center", fontsize=9, zorder=4)


def arrow(axis, start, end, colour, style="-|>"):
    axis.annotate("", end, start, arrowprops=dict(arrowstyle=style, color=colour, lw=1.8,
                                                  shrinkA=0, shrinkB=0))


def rays(axis, cameras, points):
    for p in points:
        for c in cameras:
            axis.plot(*zip(c, p), color="#bbbbbb", lw=0.6, zorder=1)
        axis.plot(*p, "o", color=GREY, ms=4, zorder=2)


def panel(axis, title, seen, unseen):
    axis.set_title(title, loc="left", fontweight="bold")
    axis.set(xlim=(-2.3, 2.3), ylim=(-2.25, 2.6), aspect="equal")
    axis.axis("off")
    axis.text(-2.25, -1.15, "seen: " + seen, color=SEEN, fontsize=9, va="top")
    axis.text(-2.25, -1.75, "not seen: " + unseen, color=UNSEEN, fontsize=9, va="top")


def draw_sees(out):
    figure, axes = plt.subplots(2, 2, figsize=(9, 8.2))
    near = [(-0.7, 1.9), (0.1, 2.2), (0.8, 1.8)]

    axis = axes[0, 0]
    panel(axis, "Two cameras, matched points", "turns, and shifts across the baseline",
          "the length of the baseline;\nwhich of the two moved, unless it turned far")
    rays(axis, [(-0.9, 0), (0.9, 0)], near)
    camera(axis, -0.9, 0, (0, 2), "a")
    camera(axis, 0.9, 0, (0, 2), "b")
    arrow(axis, (-1.5, -0.65), (1.5, -0.65), UNSEEN, "<|-|>")

    axis = axes[0, 1]
    panel(axis, "Three cameras or more, matched points", "which camera moved, and how",
          "the size of the whole rig;\na move of the whole rig")
    places = [(-1.3, 0.3), (0, -0.1), (1.3, 0.3)]
    rays(axis, places, near)
    for place, name in zip(places, "abc"):
        camera(axis, *place, (0, 2), name)
    for place in places:
        arrow(axis, np.array(place) + [0, 0.5],
              np.array(place) + [0, 0.5] + 0.32 * np.subtract(place, (0, 1.6)), UNSEEN)

    axis = axes[1, 0]
    panel(axis, "All points far away", "turns of one camera against the other",
          "shifts; a turn of a parallel pair about\nits vertical is seen far worse than a nod")
    for x in (-0.7, 0.0, 0.7):
        for c in (-0.5, 0.5):
            axis.plot((c, c + x), (0, 1.9), color="#bbbbbb", lw=0.6, zorder=1)
    axis.text(0, 2.05, "… to points far away …", ha="center", color=GREY)
    camera(axis, -0.5, 0, (-0.5, 2), "a")
    camera(axis, 0.5, 0, (0.5, 2), "b")
    arrow(axis, (0.5, -0.65), (1.4, -0.65), UNSEEN, "<|-|>")

    axis = axes[1, 1]
    panel(axis, "A target that stays", "all of it: each camera alone, the\nlength of the baseline, the target's own move",
          "")
    axis.texts[-1].remove()
    rays(axis, [(-0.9, 0), (0.9, 0)], [(-0.25, 2.0), (0.25, 2.0)])
    axis.add_patch(plt.Rectangle((-0.35, 1.9), 0.7, 0.22, fc="white", ec="black", lw=1.4, zorder=2))
    axis.text(0, 2.3, "tag on the wall", ha="center", fontsize=9)
    axis.plot((-2.1, 2.1), (2.13, 2.13), color=GREY, lw=2, zorder=0)
    camera(axis, -0.9, 0, (0, 2), "a")
    camera(axis, 0.9, 0, (0, 2), "b")
    arrow(axis, (-1.5, -0.65), (1.5, -0.65), SEEN, "<|-|>")

    figure.tight_layout()
    figure.savefig(out, dpi=100)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__.strip())
    if sys.argv[1] == "--sees":
        draw_sees(sys.argv[2])
    else:
        draw_frames(sys.argv[1], sys.argv[2])
