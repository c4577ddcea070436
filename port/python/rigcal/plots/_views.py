"""Residuals of the rig, a panel a camera, and how well each view fits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import Error
from ..transform import Array
from ._style import (
    Theme,
    arrows,
    count,
    in_order,
    make_axes,
    marker,
    new_figure,
    number,
    plain,
    rms,
    round_125,
    say,
    segments,
    stroke,
    themed,
)

if TYPE_CHECKING:
    from ..rig import Rig

SHARE_OF_ARROW = 0.06  # of an image's width: the arrow that 90 % are shorter than
HEAD = 0.012  # of an arrow, of the image's width
PANELS_WIDE = 9.4  # inches, all together
LINES = 0.55  # inches of a panel that are text
ARROWS_DENSE = 150  # a square inch of an image, at most
ARROWS_LEAST = 200  # a camera, if it has so many
WORST = 5  # views that are named
STEMS_MOST = 120  # views; of more only dots are drawn
LOGARITHMIC = 30.0  # times the median, from which the axis is logarithmic


def plot_residuals(
    rig: Rig,
    *,
    cameras: Any = None,
    scale: float | None = None,
    most: int | None = None,
    ax: Any = None,
    dark: bool = False,
    figure: Any = None,
) -> Any:
    """See Rig.plot_residuals."""
    names = [cameras] if isinstance(cameras, str) else list(cameras or rig)
    for name in names:
        rig.calibrated.number(name)
    if ax is not None and len(names) != 1:
        raise Error(f"ax: one camera is drawn on it, not {len(names)}: give cameras=")
    r = rig.residuals
    if scale is None:
        scale = arrow_scale(rig)
    with themed(dark) as theme:
        wide = len(names) if len(names) <= 3 else math.ceil(math.sqrt(len(names)))
        high = math.ceil(len(names) / wide)
        side = PANELS_WIDE / max(wide, 2)
        if ax is None:
            tall = high * (side * image_shape(rig, names) + LINES) + 0.3
            figure = figure or new_figure((side * wide, tall))
            figure.set_size_inches(side * wide, tall)
            axes = figure.subplots(high, wide, squeeze=False).ravel().tolist()
        else:
            figure, axes = ax.figure, [ax]
        if most is None:
            area = side * side * image_shape(rig, names)
            most = max(ARROWS_LEAST, int(ARROWS_DENSE * area))
        for spare in axes[len(names) :]:
            spare.set_axis_off()
        drawn = 0
        for panel, name in zip(axes, names):
            drawn += _panel(panel, rig, name, r[r["camera"] == name], scale, most, theme)
        if ax is None and len(r):
            text = f"residuals of the rig, {number(scale)} times as long as they are"
            n = int(np.isin(r["camera"], names).sum())
            if drawn < n:
                text += f"; {drawn} of {n} points: the largest, and others evenly"
            figure.suptitle(text, x=0.01, ha="left", fontsize=10)
    return figure


def image_shape(rig: Rig, names: list[str]) -> float:
    """Height by width of most images."""
    sizes = [rig[n].size or (2 * rig[n].cx, 2 * rig[n].cy) for n in names]
    shapes = [h / w if w > 0 else 0.75 for w, h in sizes]
    return min(max(float(np.median(shapes)), 0.4), 1.6)


def arrow_scale(rig: Rig) -> float:
    """How many times as long as they are residuals are drawn: one number for all."""
    r = rig.residuals
    error = r["error_px"][np.isfinite(r["error_px"]) & ~r["left_out"]]
    if not error.size:
        error = r["error_px"][np.isfinite(r["error_px"])]
    widths = [(c.size or (2 * c.cx, 0))[0] for c in rig.cameras.values()]
    large = float(np.quantile(error, 0.9)) if error.size else 0.0
    return (
        round_125(SHARE_OF_ARROW * float(np.median(widths)) / large) if large > 0 else 1.0
    )


def _chosen(error: Array, most: int) -> npt.NDArray[np.int64]:
    """Rows to draw, at most `most`: a third are the largest, the others are spread."""
    n = len(error)
    if n <= most:
        return np.arange(n)
    rank = np.argsort(-np.nan_to_num(error, nan=-1.0), kind="stable")
    worst, rest = rank[: most // 3], np.sort(rank[most // 3 :])
    even = rest[np.linspace(0, len(rest) - 1, most - len(worst)).astype(int)]
    return np.unique(np.concatenate([worst, even]))


def _border(ax: Any, size: tuple[float, float], theme: Theme, known: bool) -> None:
    """The image's border, and just room for it."""
    from matplotlib.patches import Rectangle

    width, height = size
    ax.add_patch(
        Rectangle(
            (-0.5, -0.5), width, height, facecolor=theme.panel, edgecolor=theme.faint,
            linewidth=0.8, linestyle="-" if known else "--", zorder=0, label="border",
        )
    )  # fmt: skip
    room = 0.03 * max(width, height)
    ax.set(xlim=(-0.5 - room, width - 0.5 + room), ylim=(height - 0.5 + room, -0.5 - room))
    ax.set_aspect("equal")
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.set_xticks([0, width - 1])
    ax.set_yticks([0, height - 1])
    ax.set_xticklabels(["0", f"{width - 1:.0f}"])
    ax.set_yticklabels(["0", f"{height - 1:.0f}"])
    ax.tick_params(length=0, labelsize=7)


def _panel(
    ax: Any, rig: Rig, name: str, rows: Any, scale: float, most: int, theme: Theme
) -> int:
    """One camera: returns how many points are drawn."""
    colour = theme.of(list(rig).index(name))
    camera = rig[name]
    uv, d = (
        np.column_stack([rows["u"], rows["v"]]),
        np.column_stack([rows["du"], rows["dv"]]),
    )
    placed = np.isfinite(uv).all(1)
    size: tuple[float, float] = camera.size or (2 * camera.cx, 2 * camera.cy)
    if camera.size is None and placed.any():
        size = tuple(np.maximum(uv[placed].max(0) + 1, size).tolist())
    _border(ax, size, theme, camera.size is not None)
    counts = ~rows["left_out"]
    error = rms(rows["error_px"][counts])
    title = plain(name, 28) + (f": {number(error)} px rms" if counts.any() else "")
    title += "" if camera.size else "; image size not known"
    ax.set_title(title)
    if not placed.any():
        reason = "no point counts" if len(rows) else "no residuals: no recording"
        if len(rows):
            reason = "the pixels of its points\nare not known"
        ax.text(
            size[0] / 2, size[1] / 2, reason, ha="center", va="center", color=theme.faint
        )
        return 0
    there = placed & np.isfinite(d).all(1)
    keep = np.flatnonzero(there)[_chosen(rows["error_px"][there], most)]
    for which, ink, what, z in (
        (keep[counts[keep]], colour, "residuals", 3),
        (keep[~counts[keep]], theme.bad, "left out", 4),
    ):
        if which.size:
            start = uv[which] - d[which]
            path = arrows(start, start + scale * d[which], HEAD * size[0])
            stroke(ax, path, ink, 0.7, label=what, zorder=z, clip_on=True)
    wrong = placed & ~counts
    if wrong.any():
        ax.plot(*uv[wrong].T, "x", color=theme.bad, ms=4, mew=0.9, label="left-out points",
                zorder=5)  # fmt: skip
    unseen = placed & ~there & counts
    if unseen.any():
        ax.plot(*uv[unseen].T, "+", color=theme.bad, ms=5, label="no residual", zorder=5)
    n = count(int(counts.sum()), "point")
    note = n + (f", {int((~counts).sum())} left out (x)" if (~counts).any() else "")
    ax.set_xlabel(note, fontsize=8, labelpad=-6 if size[0] > 0 else 0)
    return int(keep.size + (unseen | (wrong & ~there)).sum())


# ---- views ------------------------------------------------------------------------


def view_rms(rig: Rig) -> Array:
    """(n,) rms of the rig's residuals of each view, per point; of a view that is left out
    of its own pose; NaN: not known."""
    r, n = rig.residuals, len(rig.views)
    out = is_left_out(rig)
    counted = np.isfinite(r["error_px"]) & (~r["left_out"] | out[r["view"]])
    rows = r[counted]
    squares = np.bincount(rows["view"], rows["error_px"] ** 2, n)
    number_of = np.bincount(rows["view"], minlength=n)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(squares / number_of)


def is_left_out(rig: Rig) -> npt.NDArray[np.bool_]:
    """(n,) whether a view does not count in the rig."""
    found: npt.NDArray[np.bool_] = np.isin(
        rig.views["verdict"], ["contradicts", "one_of_two"]
    )
    return found


def worst_views(rig: Rig, most: int = WORST) -> list[int]:
    """Numbers of the views that fit worst, of those that count."""
    error = np.where(is_left_out(rig), np.nan, view_rms(rig))
    order = np.argsort(-np.nan_to_num(error, nan=-1.0), kind="stable")
    return [int(k) for k in order[:most] if np.isfinite(error[k])]


def plot_views(
    rig: Rig, *, worst: int = WORST, ax: Any = None, dark: bool = False, figure: Any = None
) -> Any:
    """See Rig.plot_views."""
    with themed(dark) as theme:
        ax = make_axes(ax, (8.2, 3.8), figure)
        if not len(rig.views):
            ax.set_title("rms of each view")
            say(ax, "no views: the rig does not come from a recording", theme)
            return ax.figure
        _draw_views(ax, rig, worst, theme)
    return ax.figure


def _draw_views(ax: Any, rig: Rig, worst: int, theme: Theme) -> None:
    views, error, out = rig.views, view_rms(rig), is_left_out(rig)
    frames = in_order(views["frame"].tolist())
    place = {frame: k for k, frame in enumerate(frames)}
    names = in_order(views["camera"].tolist())
    names = [*(n for n in rig if n in names), *(n for n in names if n not in rig)]
    wide = 0.5 / max(len(names), 1) if len(frames) <= STEMS_MOST else 0.0
    shift = {n: (k - (len(names) - 1) / 2) * wide for k, n in enumerate(names)}
    keys = zip(views["camera"].tolist(), views["frame"].tolist())
    at = np.array([place[frame] + shift[camera] for camera, frame in keys])
    own = views["rms_px"]
    if len(views) <= STEMS_MOST:
        both = np.isfinite(error) & np.isfinite(own)
        if both.any():
            low, high = (np.column_stack([at, y])[both] for y in (own, error))
            stroke(
                ax, segments(low, high), theme.line, 1.2, label="from own to rig", zorder=1
            )
    for k, name in enumerate(names):
        mine = (views["camera"] == name) & np.isfinite(error) & ~out
        ax.plot(
            at[mine], error[mine], marker(k), color=theme.of(k), ms=4.5, mew=0,
            label=plain(name, 18), zorder=3,
        )  # fmt: skip
    if (out & np.isfinite(error)).any():
        which = out & np.isfinite(error)
        ax.plot(
            at[which], error[which], "x", color=theme.bad, ms=6, label="left out", zorder=4
        )
    mean = rms(rig.residuals["error_px"][~rig.residuals["left_out"]])
    if math.isfinite(mean):
        ax.axhline(mean, color=theme.faint, lw=0.8, ls=(0, (4, 3)), zorder=0)
    _scale(ax, error)
    _name_worst(ax, rig, worst_views(rig, worst), at, error, theme)
    ax.set_xlim(-0.8, len(frames) - 0.2)
    step = max(1, math.ceil(len(frames) / max(4, 90 // (max(map(len, frames)) + 2))))
    ax.set_xticks(range(0, len(frames), step))
    ax.set_xticklabels([plain(f, 12) for f in frames[::step]])
    ax.set_xlabel("frame")
    ax.set_ylabel("rms per point [px]")
    title = f"rms of each view in the rig; dashed: of all, {number(mean)} px"
    if len(views) <= STEMS_MOST:
        title += "; line: down to its own pose"
    missing = int((~np.isfinite(error)).sum())
    if missing:
        title += f"\n{count(missing, 'view')} without a residual: not drawn"
    ax.set_title(title)
    columns = math.ceil((len(names) + bool(out.any())) / 16)
    dots = [line for line in ax.get_lines() if line.get_label()[0] != "_"]
    ax.legend(handles=dots, loc="upper left", bbox_to_anchor=(1.0, 1.02), fontsize=8,
              ncol=columns, handletextpad=0.2, borderaxespad=0.3)  # fmt: skip


def _scale(ax: Any, error: Array) -> None:
    known = error[np.isfinite(error)]
    if known.size and known.min() > 0 and known.max() > LOGARITHMIC * np.median(known):
        ax.set_yscale("log")
    elif known.size:
        ax.set_ylim(0, 1.15 * known.max() or 1.0)
    ax.yaxis.set_major_formatter(lambda y, _: number(y))


def _name_worst(
    ax: Any, rig: Rig, worst: list[int], at: Array, error: Array, theme: Theme
) -> None:
    """Numbers at the worst views, and their names beneath the axis."""
    lines = []
    for rank, k in enumerate(worst, 1):
        ax.annotate(
            str(rank), (at[k], error[k]), xytext=(0, 4), textcoords="offset points",
            ha="center", va="bottom", fontsize=8, weight="bold", color=theme.ink,
        )  # fmt: skip
        row = rig.views[k]
        camera, frame = plain(row["camera"], 16), plain(row["frame"], 16)
        lines.append(f"{rank}: {camera} in {frame}, {number(error[k])} px")
    if lines:
        halves = [lines[:3], lines[3:]] if len(lines) > 3 else [lines]
        text = "worst  " + "\n            ".join(
            "   ".join(part) for part in halves if part
        )
        ax.text(
            0, -0.24, text, transform=ax.transAxes, fontsize=8, color=theme.ink, va="top"
        )
