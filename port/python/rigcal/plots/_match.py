"""Where the matches of a pixel must be, on a pair of images."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from .._names import Status
from ..errors import Error, FileError
from ..transform import Array
from ._style import Theme, count, need, new_figure, number, plain, themed
from ._views import _border, image_shape

if TYPE_CHECKING:
    from ..rig import Rig

PLACES = 96  # of a curve
NAMED_MOST = 12  # pixels whose depths are written


def read_image(given: Any) -> Array:
    """(h, w) or (h, w, 3) of an image: an array, a path, or a video and a number."""
    if isinstance(given, (str, os.PathLike)):
        need()
        from matplotlib.image import imread

        try:
            image = np.asarray(imread(os.fspath(given)))
        except FileNotFoundError:
            raise FileError(given, "there is no such file") from None
        except Exception as problem:
            raise FileError(given, f"this is no image: {problem}") from None
    elif isinstance(given, tuple) and len(given) == 2:
        from ..detect import read_picture

        image = np.asarray(read_picture(given))
        image = image[..., ::-1] if image.ndim == 3 else image
    else:
        image = np.asarray(given)
    if image.ndim not in (2, 3) or image.dtype.kind not in "uifb" or 0 in image.shape:
        raise Error(f"images: (h, w) or (h, w, 3) is expected, not shape {image.shape}")
    image = image[..., 0] if image.ndim == 3 and image.shape[2] < 3 else image
    image = image[..., :3] if image.ndim == 3 else image
    return _bytes(image)


def _bytes(image: Array) -> Array:
    """uint8, of 16 bits and of real numbers by their range."""
    if image.dtype == np.uint8:
        return image
    numbers = np.nan_to_num(image.astype(float), posinf=0, neginf=0)
    top = float(numbers.max())
    full = 1.0 if image.dtype.kind == "f" and top <= 1 else max(top, 1e-12)
    shown: Array = np.clip(numbers / full * 255, 0, 255).astype(np.uint8)
    return shown


def plot_match(
    rig: Rig,
    a: str,
    uv: Any,
    b: str,
    *,
    images: Any = None,
    candidates: Any = None,
    depth: tuple[float, float | None] = (0.0, None),
    probability: float = 0.99,
    sigma_px: Any = None,
    dark: bool = False,
    figure: Any = None,
) -> Any:
    """See Rig.plot_match."""
    pixels = np.atleast_2d(np.asarray(uv, float))
    bands = rig.band(a, pixels, b, depth=depth, probability=probability, sigma_px=sigma_px)
    if images is not None and (isinstance(images, (str, bytes)) or len(images) != 2):
        raise Error(f"images: a pair, of {a} and of {b}, is expected")
    pictures = [None, None] if images is None else [read_image(x) for x in images]
    found = None
    if candidates is not None:
        candidates = np.atleast_2d(np.asarray(candidates, float))
        found = bands.search(candidates, most=max(len(candidates), 1))
    with themed(dark) as theme:
        figure = figure or new_figure((9.4, 4.6 * image_shape(rig, [a, b]) + 0.9))
        left, right = figure.subplots(1, 2)
        for ax, name, picture in ((left, a, pictures[0]), (right, b, pictures[1])):
            _ground(ax, rig, name, picture, theme)
        left.set_title(f"{plain(a)}: {count(len(pixels), 'pixel')}")
        for k, (u, v) in enumerate(pixels):
            left.plot(
                u, v, "o", ms=7, mfc="none", mew=1.8, color=theme.of(k), label="pixel"
            )
            _label(left, u, v, str(k), theme, theme.of(k))
        notes = _draw_bands(right, rig, b, bands.curve(PLACES), theme)
        title = (
            f"{plain(b)}: band of {100 * probability:g} %, with distances from {plain(a)}"
        )
        right.set_title("\n".join([title, *notes]))
        if candidates is not None:
            _candidates(right, candidates, found, theme)
        if images is None:
            say_blank = "no images given: the true sizes"
            figure.supxlabel(say_blank, fontsize=8, color=theme.faint)
    return figure


def _ground(ax: Any, rig: Rig, name: str, picture: Any, theme: Theme) -> None:
    camera = rig[name]
    size: tuple[float, float] = camera.size or (2 * camera.cx, 2 * camera.cy)
    if picture is not None:
        high, wide = picture.shape[:2]
        if camera.size is not None and (wide, high) != camera.size:
            raise Error(f"images: {name} is {size[0]} x {size[1]}, not {wide} x {high}")
        size = wide, high
    _border(ax, size, theme, camera.size is not None or picture is not None)
    if picture is not None:
        ax.imshow(picture, cmap="gray", zorder=0.5, alpha=0.75, label="image",
                  extent=(-0.5, size[0] - 0.5, size[1] - 0.5, -0.5))  # fmt: skip
        ax.set_xlim(-0.5, size[0] - 0.5)
        ax.set_ylim(size[1] - 0.5, -0.5)


def _label(ax: Any, u: float, v: float, text: str, theme: Theme, colour: str) -> None:
    """Writes a text beside a place, above those that are there already."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    x, y = (u - left) / (right - left), (v - bottom) / (top - bottom)
    taken = ax.__dict__.setdefault("_rigcal_labels", [])
    rise = 0.0
    while any(abs(x - a) < 0.16 and abs(y + rise - b) < 0.055 for a, b in taken):
        rise += 0.06
    taken.append((x, y + rise))
    side, off = ("left", 5) if x < 0.86 else ("right", -5)
    ax.annotate(
        text, (u, v - rise * (bottom - top)), xytext=(off, 5), textcoords="offset points",
        ha=side, fontsize=8, color=theme.ink, weight="bold", annotation_clip=True, zorder=6,
        bbox={"facecolor": theme.paper, "edgecolor": colour, "pad": 1, "alpha": 0.85,
              "lw": 0.7},
    )  # fmt: skip


def _depth(z: float) -> str:
    return number(z) if z > 0 and math.isfinite(z) else "infinity"


def _draw_bands(ax: Any, rig: Rig, b: str, curves: Any, theme: Theme) -> list[str]:
    """Each band, its line, and the distances of its ends."""
    from matplotlib.patches import Polygon

    notes = []
    width, height = rig[b].size or (2 * rig[b].cx, 2 * rig[b].cy)
    for k, n in enumerate(curves.n_places.tolist()):
        if curves.status[k] < 0 or n < 2:
            why = Status(int(curves.status[k])).name if curves.status[k] < 0 else "outside"
            notes.append(f"pixel {k}: no match in this image ({why})")
            continue
        line, half = curves.uv[k, :n], curves.half_width[k, :n, None]
        side = half * curves.across[k, :n]
        colour = theme.of(k)
        ax.add_patch(
            Polygon(
                np.vstack([line - side, (line + side)[::-1]]), facecolor=colour, alpha=0.3,
                edgecolor="none", label="band", zorder=2,
            )
        )  # fmt: skip
        ax.plot(*line.T, color=colour, lw=1.1, label="line", zorder=3)
        inside = np.flatnonzero(
            (line[:, 0] > 0)
            & (line[:, 0] < width)
            & (line[:, 1] > 0)
            & (line[:, 1] < height)
        )
        if k < NAMED_MOST and inside.size:
            for i in dict.fromkeys((int(inside[0]), int(inside[-1]))):
                text = _depth(curves.depth[k, i])
                ax.plot(*line[i], "|", color=colour, ms=8, mew=1.5, zorder=4, label="end")
                text = f"{k}: {text}" if len(curves.n_places) > 1 else text
                _label(ax, line[i, 0], line[i, 1], text, theme, colour)
    return notes


def _candidates(ax: Any, candidates: Array, found: Any, theme: Theme) -> None:
    """All candidates as dots; those in a band as rings, the best of each as a star."""
    known = candidates[np.isfinite(candidates).all(1)]
    ax.plot(*known.T, ".", color=theme.bad, ms=4, label="candidates", zorder=5)
    index = found.index.reshape(len(found.n_inside), -1)
    inside = np.unique(index[(index >= 0) & found.is_inside.reshape(index.shape)])
    if inside.size:
        ax.plot(*candidates[inside].T, "o", ms=8, mfc="none", mew=1.2, color=theme.ink,
                label="in a band", zorder=5)  # fmt: skip
    best = index[:, 0][(index[:, 0] >= 0) & found.is_inside.reshape(index.shape)[:, 0]]
    if best.size:
        ax.plot(*candidates[best].T, "*", ms=9, color=theme.ink, label="best", zorder=6)
    note = f"{count(len(known), 'candidate')} (dots), {inside.size} in a band (rings)"
    ax.set_xlabel(note + ", best: stars", fontsize=8)
