"""The reports of a monitor over time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import Error
from ._style import Theme, count, new_figure, number, plain, say, themed

if TYPE_CHECKING:
    from ..monitor import MonitorReport

BODIES_MOST = 24  # lines of the lower panel
ALARMS_NAMED = 6
FLOOR = -25.0  # of the evidence's axis: less is as good as none


def plot_monitor(
    reports: Sequence[MonitorReport],
    seconds: Any = None,
    *,
    ax: Any = None,
    dark: bool = False,
    figure: Any = None,
) -> Any:
    """A monitor's evidence over time, and whom it suspects.

    reports  of Monitor.end_frame, one a frame
    seconds  when each was made; None: their frames are the axis
    ax       axes of Matplotlib: the evidence alone is drawn on it

    At 0, the dashed line, the alarm is raised. Returns the figure.
    """
    if not isinstance(reports, Iterable):
        raise Error(f"reports: several are expected, not {type(reports).__name__}")
    reports = list(reports)
    for report in reports:
        if not hasattr(report, "evidence"):
            raise Error(
                f"reports: a MonitorReport is expected, not {type(report).__name__}"
            )
    x = np.array([r.frames for r in reports], float)
    if seconds is not None:
        x = np.asarray(seconds, float)
        if x.shape != (len(reports),):
            raise Error(f"seconds: {len(reports)} numbers are expected, not {x.shape}")
    bodies = list(dict.fromkeys(r.body for r in reports))
    with themed(dark) as theme:
        if ax is None:
            high = 3.0 + 0.22 * min(len(bodies), BODIES_MOST) + 0.6
            figure = figure or new_figure((8.2, high))
            ratio = [2.6, 0.5 + 0.22 * min(len(bodies), BODIES_MOST)]
            ax, low = figure.subplots(
                2, 1, sharex=True, gridspec_kw={"height_ratios": ratio}
            )
        else:
            low = None
        if reports:
            _evidence(ax, x, reports, theme)
        else:
            for panel in (ax, low):
                if panel is not None:
                    say(panel, "no reports yet", theme)
            return ax.figure
        last = low if low is not None else ax
        last.set_xlabel("frame" if seconds is None else "time [s]")
        if low is not None:
            _blame(low, x, reports, bodies, theme)
    return ax.figure


def _alarms(reports: list[MonitorReport]) -> list[tuple[int, int]]:
    """First and last report of each alarm."""
    found: list[tuple[int, int]] = []
    for k, report in enumerate(reports):
        if report.alarm:
            if found and found[-1][1] == k - 1:
                found[-1] = found[-1][0], k
            else:
                found.append((k, k))
    return found


def _evidence(ax: Any, x: Any, reports: list[MonitorReport], theme: Theme) -> None:
    y = np.array([r.evidence for r in reports], float)
    known = y[np.isfinite(y)]
    alarms = _alarms(reports)
    for first, last in alarms:
        end = x[last + 1] if last + 1 < len(x) else x[last]
        ax.axvspan(x[first], end, color=theme.bad, alpha=0.16, lw=0, label="alarm")
    y = np.where(np.isfinite(y), y, np.nan)
    ax.plot(x, y, color=theme.c0, lw=1.4, label="evidence")
    ax.axhline(0, color=theme.bad, lw=1, ls=(0, (4, 3)), label="limit")
    top = max(float(known.max()) if known.size else 0.0, 0.0)
    low = min(max(float(known.min()) if known.size else -1.0, FLOOR), -1.0)
    room = (top - low) * 0.12
    ax.set_ylim(low - room, top + 2.4 * room)
    for k, (first, _) in enumerate(alarms[:ALARMS_NAMED]):
        r = reports[first]
        right = x[first] > x[0] + 0.7 * (x[-1] - x[0])
        ax.annotate(
            f"alarm: {plain(r.body, 16)}, {100 * r.confidence:.3g} %", (x[first], 0),
            xytext=(-5 if right else 5, 3), textcoords="offset points", fontsize=8,
            va="bottom", ha="right" if right else "left", color=theme.ink, weight="bold",
        )  # fmt: skip
        if k == 0:
            ax.plot(x[first], y[first], "o", color=theme.bad, ms=5, label="first alarm")
    ax.set_ylabel("evidence [log]")
    title = "evidence that something moved: alarm at 0"
    title += f"; {count(len(alarms), 'alarm')}" if alarms else "; no alarm"
    lost = len(y) - known.size
    if lost:
        title += f"; {count(lost, 'report')} without a number"
    ax.set_title(title)
    noise = [r.noise for r in reports if np.isfinite(r.noise) and r.noise > 0]
    blind = max(r.n_blind for r in reports)
    note = f"noise: {number(noise[-1])} times that stated" if noise else "no rows yet"
    if blind:
        note += f"; up to {count(blind, 'body').replace('bodys', 'bodies')} seen too little"
    ax.text(1, 1.02, note, transform=ax.transAxes, ha="right", va="bottom", fontsize=8,
            color=theme.faint)  # fmt: skip


def _blame(
    ax: Any, x: Any, reports: list[MonitorReport], bodies: list[str], theme: Theme
) -> None:
    """The likeliest body of each report: a dot, filled while there is an alarm."""
    shown = bodies[:BODIES_MOST]
    for k, name in enumerate(shown):
        mine = np.array([r.body == name for r in reports])
        alarm = np.array([r.alarm for r in reports])
        for which, label, how in (
            (
                mine & ~alarm,
                "most evidence",
                {"color": theme.faint, "alpha": 0.5, "ms": 2.5},
            ),
            (mine & alarm, "blamed", {"color": theme.bad, "ms": 5}),
        ):
            if which.any():
                ax.plot(
                    x[which], np.full(int(which.sum()), k), "s", mew=0, label=label, **how
                )
    ax.set_yticks(range(len(shown)), [plain(name, 16) for name in shown])
    ax.set_ylim(max(len(shown), 1) - 0.5, -0.5)
    ax.tick_params(length=0)
    more = (
        f"; {len(bodies) - len(shown)} more are not drawn"
        if len(bodies) > len(shown)
        else ""
    )
    ax.set_title("likeliest to have moved; large: blamed in an alarm" + more)
