"""Colours, figures and small things that the pictures have in common."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import Error
from ..transform import Array

# Colours that differ for colour-blind eyes too, of a name each; cameras have c0 to c5 and a
# marker besides. In a page each name is a variable of CSS: no two names share a colour.
LIGHT = {
    "paper": "#ffffff", "panel": "#f5f6f8", "ink": "#1f2430", "faint": "#5d6675",
    "line": "#ccd1d9", "bad": "#c7390a", "c0": "#0072b2", "c1": "#c98000", "c2": "#009e73",
    "c3": "#c9609f", "c4": "#45a3dd", "c5": "#4f4a45",
}  # fmt: skip
DARK = {
    "paper": "#14171c", "panel": "#1d2229", "ink": "#e8ebf0", "faint": "#9aa4b3",
    "line": "#3c4450", "bad": "#ff8052", "c0": "#4fb0ea", "c1": "#f2b233", "c2": "#35cfa2",
    "c3": "#d9669a", "c4": "#b4dcff", "c5": "#857f6e",
}  # fmt: skip
N_COLOURS = 6
MARKERS = "osD^vPX"


class Theme:
    """The colours of one picture: theme.ink, and theme.of(k) of camera k."""

    def __init__(self, dark: bool = False) -> None:
        self.colours = DARK if dark else LIGHT

    def __getattr__(self, name: str) -> str:
        try:
            return self.__dict__["colours"][name]  # type: ignore[no-any-return]
        except KeyError:
            raise AttributeError(name) from None

    def of(self, k: int) -> str:
        return self.colours[f"c{k % N_COLOURS}"]

    @property
    def rc(self) -> dict[str, Any]:
        c = self.colours
        return {
            "figure.facecolor": c["paper"], "axes.facecolor": c["paper"],
            "savefig.facecolor": "auto", "text.color": c["ink"],
            "axes.edgecolor": c["line"], "axes.labelcolor": c["faint"],
            "axes.titlecolor": c["ink"],
            "xtick.color": c["line"], "ytick.color": c["line"],
            "xtick.labelcolor": c["faint"], "ytick.labelcolor": c["faint"],
            "font.size": 9, "axes.titlesize": 9.5, "axes.titlelocation": "left",
            "axes.spines.top": False, "axes.spines.right": False,
            "legend.frameon": False, "figure.titlesize": 11, "axes.linewidth": 0.8,
            "svg.fonttype": "none",
        }  # fmt: skip


def marker(k: int) -> str:
    """The marker of camera k. Cameras with the same colour have different ones."""
    return MARKERS[(k % N_COLOURS + k // N_COLOURS) % len(MARKERS)]


def need() -> Any:
    """Matplotlib, or an Error that says how to install it."""
    try:
        import matplotlib
    except ImportError:
        raise Error(
            "pictures need Matplotlib, which is not installed: pip install rigcal[plot]"
        ) from None
    return matplotlib


def new_figure(size: tuple[float, float]) -> Any:
    """A figure that pyplot.show() shows, and that a notebook shows once."""
    mpl = need()
    if "inline" in mpl.get_backend():
        from matplotlib.figure import Figure

        return Figure(figsize=size, layout="constrained")
    from matplotlib import pyplot

    return pyplot.figure(figsize=size, layout="constrained")


@contextlib.contextmanager
def themed(dark: bool) -> Iterator[Theme]:
    """The rc parameters of a picture while it is made."""
    theme = Theme(dark)
    with need().rc_context(theme.rc):
        yield theme


def make_axes(ax: Any, size: tuple[float, float], figure: Any = None, **how: Any) -> Any:
    """The axes given, or those of a new figure."""
    if ax is not None:
        return ax
    return (figure or new_figure(size)).add_subplot(**how)


def clean(text: object, most: int | None = None) -> str:
    """A user's text without control characters and halves of characters, shortened."""
    shown = str(text).encode("utf-8", "replace").decode("utf-8")
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown)
    if most is not None and len(shown) > most:
        shown = shown[: most - 1] + "\N{HORIZONTAL ELLIPSIS}"
    return shown


def plain(text: object, most: int = 40) -> str:
    """A user's text in a picture, unchanged: Matplotlib's mathematics is off."""
    return clean(text, most).replace("$", r"\$")


def say(ax: Any, text: str, theme: Theme) -> None:
    """Says why there is nothing to draw."""
    ax.text(
        0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center", wrap=True,
        color=theme.faint,
    )  # fmt: skip
    ax.set_axis_off()


def round_125(x: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is at most x."""
    if not (x > 0 and math.isfinite(x)):
        return 1.0
    power = 10.0 ** math.floor(math.log10(x))
    return max(m * power for m in (1, 2, 5) if m * power <= x * (1 + 1e-9))


def number(x: float) -> str:
    """Three digits: 0.205, 83.4, 12300."""
    if not math.isfinite(x):
        return "?"
    return f"{x:.0f}" if 100 <= abs(x) < 1e6 else f"{x:.3g}"


def count(n: int, what: str) -> str:
    return f"{n} {what}" + ("" if n == 1 else "s")


def rms(values: Array) -> float:
    """The root mean square of the values that are numbers; NaN if none is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else math.nan


def in_order(names: Sequence[str]) -> list[str]:
    """Names of frames as a reader sorts them: 2 before 10."""

    def key(name: str) -> tuple[bool, float, str]:
        try:
            return False, float(name), name
        except ValueError:
            return True, 0.0, name

    return sorted(dict.fromkeys(names), key=key)


def segments(starts: Array, *ends: Array) -> Any:
    """One Path of as many broken lines as there are starts (n, 2), through the ends."""
    from matplotlib.path import Path

    points = np.stack([starts, *ends], axis=1)
    codes = np.full(points.shape[:2], Path.LINETO, np.uint8)
    codes[:, 0] = Path.MOVETO
    return Path(points.reshape(-1, 2), codes.ravel())


def stroke(ax: Any, path: Any, colour: str, width: float = 1.0, **how: Any) -> Any:
    """A Path of lines as one artist."""
    from matplotlib.patches import PathPatch

    patch = PathPatch(path, facecolor="none", edgecolor=colour, linewidth=width, **how)
    ax.add_patch(patch)
    return patch


def arrows(starts: Array, ends: Array, head: float) -> Any:
    """A Path of arrows, five places each: start, end, and the two strokes of the head."""
    along = ends - starts
    length = np.hypot(*along.T)[:, None]
    size = np.minimum(0.4 * length, head)
    back = along / np.where(length > 0, length, 1) * size
    across = np.column_stack([-back[:, 1], back[:, 0]]) * 0.5
    return segments(starts, ends, ends - back + across, ends, ends - back - across)
