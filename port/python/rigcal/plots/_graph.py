"""Which cameras saw the target together, and who saw it when."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..transform import Array
from ._style import Theme, count, in_order, new_figure, plain, say, segments, stroke, themed
from ._views import is_left_out

if TYPE_CHECKING:
    from ..rig import Rig

EDGES_MOST = 10  # that are drawn as lines: 5 cameras; of more there is a table
TABLE_WIDTH = 165.0  # points
TICKS_MOST = 14
NONE, COUNTS, LEFT_OUT = 0, 1, 2


def seen(rig: Rig) -> tuple[list[str], list[str], npt.NDArray[np.int8]]:
    """Names of cameras and frames, and (cameras, frames): whether it saw the target, and
    whether that view is left out."""
    views = rig.views
    cameras = [*rig, *(n for n in dict.fromkeys(views["camera"].tolist()) if n not in rig)]
    lost = [(v.camera, v.frame) for v in rig.left_out]
    frames = in_order([*views["frame"].tolist(), *(frame for _, frame in lost if frame)])
    row = {name: k for k, name in enumerate(cameras)}
    column = {name: k for k, name in enumerate(frames)}
    table = np.zeros((len(cameras), len(frames)), np.int8)
    keys = zip(views["camera"].tolist(), views["frame"].tolist())
    for (camera, frame), out in zip(keys, is_left_out(rig).tolist()):
        table[row[camera], column[frame]] = LEFT_OUT if out else COUNTS
    for camera, frame in lost:
        if camera in row and frame in column:
            table[row[camera], column[frame]] = LEFT_OUT
    return cameras, frames, table


def plot_graph(rig: Rig, *, ax: Any = None, dark: bool = False, figure: Any = None) -> Any:
    """See Rig.plot_graph."""
    cameras, frames, table = seen(rig)
    with themed(dark) as theme:
        if ax is not None:
            left, right = ax, None
        else:
            high = max(2.6 if len(cameras) <= 2 else 3.6, 1.2 + 0.17 * len(cameras))
            figure = figure or new_figure((9.2, high))
            left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1, 1.5]})
        if not len(rig.views):
            for panel in (left, right):
                if panel is not None:
                    say(panel, "no views: the rig does not\ncome from a recording", theme)
            return left.figure
        common = (table == COUNTS).astype(int) @ (table == COUNTS).T
        any_common = (table != NONE).astype(int) @ (table != NONE).T
        lost = any_common - common
        n_edges = int((np.triu(any_common, 1) > 0).sum())
        draw = _network if n_edges <= EDGES_MOST else _numbers
        draw(left, cameras, common, lost, theme)
        out = "; +: left out" if lost.any() else ""
        left.set_title("frames that two cameras share" + out + _groups(rig))
        if right is not None:
            _calendar(right, cameras, frames, table, theme)
    return left.figure


def _groups(rig: Rig) -> str:
    n = len(set(rig.calibrated.group.tolist()))
    return f"\n{n} groups of cameras have no frame in common" if n > 1 else ""


def _network(ax: Any, cameras: list[str], common: Array, lost: Array, theme: Theme) -> None:
    n = len(cameras)
    angle = np.pi / 2 + (np.pi / n if n in (2, 4) else 0) - 2 * np.pi * np.arange(n) / n
    if n == 2:
        angle = np.array([np.pi, 0])
    at = np.column_stack([np.cos(angle), np.sin(angle)]) * (n > 1)
    most = max(int(np.triu(common, 1).max()) if n > 1 else 0, 1)
    for i in range(n):
        for j in range(i):
            if not common[i, j] and not lost[i, j]:
                continue
            a, b = at[j], at[i]
            only_lost = not common[i, j]
            ax.plot(
                *np.array([a, b]).T, ls=(0, (3, 2)) if only_lost else "-", zorder=1,
                color=theme.bad if only_lost else theme.faint, solid_capstyle="butt",
                lw=1.2 if only_lost else 1 + 4 * common[i, j] / most,
                label=f"edge {cameras[j]} {cameras[i]}",
            )  # fmt: skip
            text = str(common[i, j]) if common[i, j] else ""
            text += f" +{lost[i, j]}" if lost[i, j] else ""
            # not in the middle, where edges cross
            x, y = a + (0.5 if n <= 3 else 0.36) * (b - a)
            ax.text(x, y, text.strip(), ha="center", va="center", fontsize=8, zorder=2,
                    color=theme.ink, bbox={"facecolor": theme.paper, "edgecolor": "none",
                                           "pad": 1.2})  # fmt: skip
    for k, (name, (x, y)) in enumerate(zip(cameras, at)):
        ax.plot(x, y, "o", ms=11, color=theme.of(k), zorder=3, label=f"camera {name}")
        ax.text(
            1.16 * x, 1.16 * y - (0.16 if n <= 2 else 0), plain(name, 14), zorder=4,
            ha="center" if abs(x) < 0.2 or n <= 2 else "left" if x > 0 else "right",
            va="top" if n <= 2 or y < -0.8 else "bottom" if y > 0.8 else "center",
            weight="bold", color=theme.ink,
        )  # fmt: skip
    ax.set(xlim=(-1.9, 1.9), ylim=(-0.8, 0.8) if n <= 2 else (-1.45, 1.45))
    ax.set_axis_off()


def _numbers(ax: Any, cameras: list[str], common: Array, lost: Array, theme: Theme) -> None:
    """The same as a table, of many cameras."""
    n = len(cameras)
    most = max(int(np.triu(common, 1).max()), 1)
    size = min(8.0, TABLE_WIDTH / n / (0.7 * max(len(str(most)), 2)))
    places = np.array([(j, i) for i in range(n) for j in range(i) if common[i, j]]).reshape(
        -1, 2
    )
    if len(places):
        from matplotlib.collections import PatchCollection
        from matplotlib.patches import Rectangle

        for level in (0.25, 0.5, 0.75, 1.0):  # few colours, of one name: shades by alpha
            part = [
                Rectangle((j - 0.5, i - 0.5), 1, 1)
                for j, i in places
                if level - 0.25 < common[i, j] / most <= level
            ]
            ax.add_collection(
                PatchCollection(
                    part, facecolor=theme.c0, alpha=0.5 * level, edgecolor="none"
                )
            )
    for i in range(n):
        for j in range(i):
            if lost[i, j] or common[i, j]:
                text = str(common[i, j]) if common[i, j] else f"+{lost[i, j]}"
                ax.text(j, i, text, ha="center", va="center", fontsize=size,
                        color=theme.ink if common[i, j] else theme.bad)  # fmt: skip
    ax.set(xlim=(-0.5, n - 0.5), ylim=(n - 0.5, -0.5), aspect="equal")
    names = [plain(name, 12) for name in cameras]
    ax.set_xticks(range(n), names, rotation=90)
    ax.set_yticks(range(n), names)
    ax.tick_params(length=0, labelsize=min(8.0, TABLE_WIDTH / n))


def _calendar(
    ax: Any,
    cameras: list[str],
    frames: list[str],
    table: npt.NDArray[np.int8],
    theme: Theme,
) -> None:
    """A line for each camera, a stroke for each frame in which it saw the target."""
    width = max(1.0, min(9.0, 330 / max(len(frames), 1)))
    tall = 0.34 if len(cameras) > 2 else 0.2
    for k in range(len(cameras)):
        at = np.flatnonzero(table[k] == COUNTS)
        if at.size:
            low, high = (
                np.column_stack([at, np.full(at.size, k + s)]) for s in (-tall, tall)
            )
            stroke(ax, segments(low, high), theme.of(k), width * 0.8, label="views",
                   capstyle="butt")  # fmt: skip
        at = np.flatnonzero(table[k] == LEFT_OUT)
        if at.size:
            low, high = (
                np.column_stack([at, np.full(at.size, k + s)]) for s in (-tall, tall)
            )
            stroke(ax, segments(low, high), theme.bad, min(width * 0.8, 1.6),
                   label="left out", linestyle=(0, (2, 1.2)), capstyle="butt")  # fmt: skip
    n_out = int((table == LEFT_OUT).sum())
    ax.set(xlim=(-0.7, len(frames) - 0.3), ylim=(len(cameras) - 0.4, -0.6))
    size = max(min(9.0, 200 / len(cameras)), 5.0)
    ax.set_yticks(range(len(cameras)), [plain(name, 14) for name in cameras], fontsize=size)
    longest = max(map(len, frames))
    step = max(1, math.ceil(len(frames) / max(3, min(TICKS_MOST, 60 // (longest + 2)))))
    ax.set_xticks(range(0, len(frames), step), [plain(f, 12) for f in frames[::step]])
    ax.tick_params(length=0)
    ax.spines["left"].set_visible(False)
    ax.set_xlabel("frame")
    n = int((table == COUNTS).sum())
    title = f"who saw the target: {count(n, 'view')} count{'s' if n == 1 else ''}"
    ax.set_title(title + (f", {n_out} left out (dashed)" if n_out else ""))
