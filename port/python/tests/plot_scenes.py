"""Rigs for the tests of pictures and pages, made by NumPy, and functions that look at what
was drawn."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

import rigcal
from rigcal import rig as module

SIZE = (1280, 720)


def ring(
    n: int = 4,
    frames: int = 6,
    *,
    names: Any = None,
    points: int = 12,
    left_out: int = 0,
    size: Any = SIZE,
    seed: int = 0,
) -> rigcal.Rig:
    """n cameras on a ring that look at its middle, as if they were calibrated. There is no
    covariance."""
    rng = np.random.default_rng(seed)
    names = list(names or [f"cam{k}" for k in range(n)])
    cameras = []
    for k, name in enumerate(names):
        a = 2 * np.pi * k / len(names)
        ahead = np.array([-np.sin(a), 0.25, np.cos(a)])
        ahead /= np.linalg.norm(ahead)
        right = np.cross([0, 1, 0], ahead)
        right /= np.linalg.norm(right)
        R = np.array([right, np.cross(ahead, right), ahead])
        pose = rigcal.Transform(R, -R @ (np.array([0, 0, 2.5]) - 2.5 * ahead), name, "rig")
        cameras.append(
            rigcal.Camera(900, 900, 640, 360, size=size, name=name, cam_from_rig=pose)
        )
    calibrated = rigcal.CalibratedRig.from_cameras(cameras)
    if not frames:
        return rigcal.Rig(calibrated, calibrated.cameras)
    keys = [
        (name, str(f))
        for name in names
        for f in range(frames)
        if (f, name) != (1, names[-1])
    ]
    views = np.zeros(
        len(keys), module._views_dtype([c for c, _ in keys], [f for _, f in keys])
    )
    views["camera"], views["frame"] = zip(*keys)
    views["n"], views["rms_px"], views["verdict"] = points, 0.2, "fits"
    out = rng.choice(len(keys), left_out, replace=False)
    views["verdict"][out] = "contradicts"
    m = len(keys) * points
    r = np.zeros(m, module._residuals_dtype(names, [str(frames)], ["p000"]))
    r["view"] = np.repeat(np.arange(len(keys)), points)
    r["camera"], r["frame"] = views["camera"][r["view"]], views["frame"][r["view"]]
    r["point"] = np.tile([f"p{k}" for k in range(points)], len(keys))
    board = np.array([[k % 4 * 0.1, k // 4 * 0.1, 0.0] for k in range(points)])
    r["X"], r["Y"], r["Z"] = np.tile(board, (len(keys), 1)).T
    r["u"], r["v"] = rng.uniform(40, 1200, m), rng.uniform(40, 680, m)
    d = rng.normal(0, 0.3, (m, 2))
    r["du"], r["dv"], r["error_px"] = d[:, 0], d[:, 1], np.hypot(*d.T)
    r["left_out"] = np.isin(r["view"], out)
    targets = {
        str(f): rigcal.Transform.from_rvec(
            rng.uniform(-0.5, 0.5, 3), [*rng.uniform(-0.4, 0.4, 2), 2.5], "rig", "target"
        )
        for f in range(frames)
    }
    lost = [
        rigcal.LeftOut(str(v["camera"]), str(v["frame"]), "it contradicts", "look at it")
        for v in views[out]
    ]
    return rigcal.Rig(
        calibrated, calibrated.cameras, views=views, residuals=r, targets=targets,
        left_out=lost, verdict="agrees", F=1.1, sqrt_f=1.05, sigma_px=0.3, noise_px=0.3,
    )  # fmt: skip


def stored() -> rigcal.Rig:
    """Two cameras from a file, without recording and covariance."""
    return ring(2, 0)


def pixels(figure: Any, dpi: int = 45) -> Any:
    """(h, w, 3) of a figure as it is saved."""
    from matplotlib.image import imread

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    buffer.seek(0)
    return (imread(buffer)[..., :3] * 255).astype(int)


def ink(image: Any, box: Any = None) -> float:
    """The share of pixels that differ from the most frequent one, in the box (left, top,
    right, bottom), in parts of the image."""
    h, w = image.shape[:2]
    left, top, right, bottom = box if box is not None else (0, 0, 1, 1)
    part = image[int(top * h) : int(bottom * h), int(left * w) : int(right * w)]
    flat = part.reshape(-1, 3) @ [65536, 256, 1]
    values, counts = np.unique(flat, return_counts=True)
    common = values[counts.argmax()]
    return float((flat != common).mean())


def panels(figure: Any, image: Any = None) -> list[float]:
    """The ink in each axes of a figure that shows something."""
    image = pixels(figure) if image is None else image
    found = []
    for ax in figure.axes:
        if ax.axison or ax.texts or ax.lines or ax.collections or ax.patches:
            box = ax.get_position()
            found.append(ink(image, (box.x0, 1 - box.y1, box.x1, 1 - box.y0)))
    return found


def labelled(ax: Any, label: str) -> list[Any]:
    """The artists with a label, or with one that begins with it and a blank."""
    return [
        child
        for child in ax.get_children()
        if str(child.get_label()) == label or str(child.get_label()).startswith(label + " ")
    ]


def texts(figure: Any) -> str:
    """All that is written in a figure."""
    from matplotlib.text import Text

    return "\n".join(t.get_text() for t in figure.findobj(Text) if t.get_visible())
