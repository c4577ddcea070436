"""One page about a rig: Rig.html."""

from __future__ import annotations

import base64
import contextlib
import html as _html
import io
import json
import math
import os
import pathlib
import re
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import plots
from ._page import SCRIPT, STYLE
from .errors import Error, FileError
from .plots._match import read_image
from .plots._rig import caption
from .plots._scene import Scene, make_scene
from .plots._style import LIGHT, N_COLOURS, clean, count, need, number, rms
from .plots._views import arrow_scale, is_left_out, view_rms, worst_views

if TYPE_CHECKING:
    from .rig import Fault, Rig

BYTES_MOST = 3_000_000  # of a page
ROWS_MOST, FAULTS_MOST = 100, 15  # of a table
TITLE_MOST = 60  # characters of the cameras' names
REPORT_MOST = 100_000  # characters of the program's report
THUMBS_MOST, THUMB_WIDTH, THUMB_QUALITY = 6, 560, 72
SIGMA = 3.0  # half axes of ellipsoids
CLOSE = 3.0  # times more than noise: views that disagree less are a reservation only
WORDS = {"good": "Good", "warn": "Look at this", "bad-one": "Something is wrong",
         "none": "Not judged"}  # fmt: skip


def text(value: object) -> str:
    """A user's text in the page."""
    return _html.escape(clean(value))


FOLDERS = re.compile(
    r"(?<![\w./\\])(?:[A-Za-z]:)?([/\\][^\s/\\:,;'\"]+)[/\\](?:[^\s/\\:,;'\"]+[/\\])*"
)


def no_folders(said: str) -> str:
    """A message with names of files only, as far as folders of this machine are named."""
    return FOLDERS.sub(lambda m: "" if os.path.isdir(m[1]) or ":" in m[0] else m[0], said)


# ---- what is said -----------------------------------------------------------------


def headline(rig: Rig) -> tuple[str, str]:
    """How good the rig is: a key of WORDS, and a sentence."""
    groups = len(set(rig.calibrated.group.tolist()))
    if groups > 1:
        return "bad-one", (
            f"The cameras fall into {groups} groups that have no frame in common: from one "
            "group to another there is no pose."
        )
    if not len(rig.views):
        return "none", (
            "These are the poses of cameras in a file. There is no recording by which they "
            "could be judged."
        )
    if rig.verdict is None and any("not adjusted" in told for told in rig.warnings):
        return "bad-one", (
            "The views could not be adjusted together: the rig is only joined from single "
            "views."
        )
    if rig.verdict is None:
        return "warn", (
            "Nothing contradicts this rig, and nothing could: no two ways lead from one "
            "camera to another."
        )
    n_out = len(rig.left_out)
    if rig.verdict == "agrees":
        if n_out:
            return "warn", (
                "The views agree as well as noise lets them, after "
                f"{count(n_out, 'view')} of {len(rig.views)} had to be left out."
            )
        if rig.warnings:
            return "warn", "The views agree, with the reservations below."
        return "good", "The rig is good: the views agree as well as noise lets them."
    times = (
        f"{number(rig.sqrt_f)} times more than noise" if rig.sqrt_f else "more than noise"
    )
    kind = "warn" if rig.sqrt_f is not None and rig.sqrt_f < CLOSE else "bad-one"
    ends = {
        "explained": "and the reason is found",
        "found": "one fault is certain, and it is not the whole reason",
    }
    end = ends.get(rig.verdict, "and none of the causes that can be tested explains it")
    return kind, f"The views disagree {times}: {end}."


def advice(rig: Rig) -> list[str]:
    """What to do next; of views that are left out too."""
    told = [*rig.advice, *(v.advice for v in rig.left_out if v.advice)]
    if rig.warnings and not told:
        told = [w.partition("; ")[2] for w in rig.warnings if "; " in w]
    if not told:
        told = ["nothing: save the rig, and use it"] if rig.verdict == "agrees" else []
    return [no_folders(one) for one in dict.fromkeys(told)]


def _facts(rig: Rig) -> str:
    counts = ~rig.residuals["left_out"]
    facts = [count(len(rig), "camera")]
    if len(rig.views):
        facts += [count(len(rig.views), "view"), count(int(counts.sum()), "point"),
                  f"{number(rms(rig.residuals['error_px'][counts]))} px rms"]  # fmt: skip
    if rig.sqrt_f is not None:
        facts.append(
            f"disagreement {number(rig.sqrt_f)} times the noise (about 1 is noise)"
        )
    return " &middot; ".join(facts)


# ---- pictures ---------------------------------------------------------------------


def _figure(size: tuple[float, float]) -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained")


def svg(figure: Any, prefix: str, label: str) -> str:
    """A figure as SVG inside a page: its colours are variables of CSS."""
    buffer = io.StringIO()
    rc = {
        "svg.fonttype": "none",
        "svg.hashsalt": prefix,
        "font.sans-serif": ["DejaVu Sans"],
    }
    with need().rc_context(rc), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # glyphs that a font of ours lacks
        figure.savefig(buffer, format="svg", metadata=dict.fromkeys(
            ("Date", "Creator", "Format", "Type")))  # fmt: skip
    drawn = buffer.getvalue()
    drawn = drawn[drawn.index("<svg") :]
    drawn = re.sub(r"<metadata>.*?</metadata>", "", drawn, flags=re.S)
    names = {colour: name for name, colour in LIGHT.items()}
    drawn = re.sub(
        r": (#[0-9a-f]{6})",
        lambda m: f": var(--{names[m[1]]})" if m[1] in names else m[0],
        drawn,
    )
    drawn = re.sub(
        r' (?:d|x|y|points|transform)="[^"]*"',
        lambda m: re.sub(r"(\.\d\d)\d+", r"\1", m[0]).replace(" \n", " "),
        drawn,
    )
    drawn = re.sub(r'id="', f'id="{prefix}-', drawn)
    drawn = re.sub(r'(url\(|href=")#', rf"\1#{prefix}-", drawn)
    head = re.match(r"<svg[^>]*>", drawn)
    assert head
    box = re.search(r'viewBox="[^"]*"', head[0])
    assert box
    open_tag = f'<svg {box[0]} role="img" aria-label="{text(label)}">'
    return open_tag + drawn[head.end() :].replace("xlink:href", "href")


def _picture(rig: Rig, what: str) -> str:
    """One of the pictures, light and dark in one."""
    figure = _figure((9.4, 5.0))
    if what == "views":
        figure.set_size_inches(9.4, 3.9)
        plots.plot_views(rig, figure=figure)
    elif what == "graph":
        figure.set_size_inches(9.4, max(3.2, 1.2 + 0.17 * len(rig)))
        plots.plot_graph(rig, figure=figure)
    else:
        figure = plots.plot_residuals(rig, figure=figure)
    return f'<div class="wide picture">{svg(figure, what, f"{what} of the rig")}</div>'


def _space(rig: Rig) -> str:
    """The rig as a still picture, and as one that can be turned if scripts run."""
    figure = _figure((9.4, 5.6))
    plots.plot_rig(rig, k=SIGMA, figure=figure)
    scene = make_scene(rig, SIGMA)
    still = svg(figure, "space", "the cameras of the rig in space")
    data = json.dumps(_lines(scene), separators=(",", ":"), ensure_ascii=True)
    notes = "; ".join(n for n in (caption(scene, SIGMA), *scene.notes) if n)
    return (
        f'<div id="space"><div class="still wide picture">{still}</div></div>'
        f'<p class="note">{text(notes)}{". " if notes else ""}Lengths are in the unit '
        "of the target. Drag to turn; arrow keys turn, + and - zoom.</p>"
        f'<script type="application/json" id="lines">{data.replace("<", chr(92) + "u003c")}'
        "</script>"
    )


def _lines(scene: Scene) -> dict[str, Any]:
    """The input of the script: lines and names in the box -1..1, z up."""
    A = scene.turn
    lines: list[tuple[str, float, Any]] = []
    lines += [("faint", 0.7, X) for X in scene.boards.values()]
    for k, (name, frustum) in enumerate(scene.frustums.items()):
        colour = f"c{k % N_COLOURS}"
        lines += [(colour, 1.8, X) for X in frustum]
        lines += [(colour, 1.2, X) for X in scene.ellipsoids.get(name, [])]
    points = np.vstack([X for _, _, X in lines]) @ A.T
    low, high = points.min(0), points.max(0)
    middle, half = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0

    def flat(X: Any) -> list[float]:
        found: list[float] = np.round((X @ A.T - middle) / half, 4).ravel().tolist()
        return found

    grid = np.linspace(-1, 1, 9)
    floor = float((low[2] - middle[2]) / half) - 0.04
    lines_out: list[Any] = []
    for s in grid.tolist():
        lines_out.append(["line", 0.6, [s, -1, floor, s, 1, floor]])
        lines_out.append(["line", 0.6, [-1, s, floor, 1, s, floor]])
    lines_out += [[colour, width, flat(X)] for colour, width, X in lines]
    names = [
        [clean(name, 24), flat(of[0].mean(0) + 0.55 * np.ptp(of[0] @ scene.up) * scene.up)]
        for name, of in scene.frustums.items()
    ]
    return {"lines": lines_out, "names": names,
            "label": f"{count(len(names), 'camera')} in space"}  # fmt: skip


# ---- tables -----------------------------------------------------------------------


def _table(
    heads: Iterable[str],
    rows: Iterable[Iterable[Any]],
    texts: Iterable[int] = (),
    longs: Iterable[int] = (),
    most: int = ROWS_MOST,
) -> str:
    """heads and cells are HTML; columns of numbers, of short and of long texts."""
    kinds = {k: " class=text" for k in texts} | {k: " class=long" for k in longs}

    def line(cells: Iterable[Any], tag: str) -> str:
        made = "".join(
            f"<{tag}{kinds.get(k, '')}>{cell}</{tag}>" for k, cell in enumerate(cells)
        )
        return f"<tr>{made}</tr>"

    shown = list(rows)
    more = len(shown) - most
    body = "".join(line(cells, "td") for cells in shown[:most])
    note = f'<p class="note">and {more} more</p>' if more > 0 else ""
    return (
        f'<div class="wide"><table><thead>{line(heads, "th")}</thead>'
        f"<tbody>{body}</tbody></table></div>{note}"
    )


def _known(x: float | None, digits: int = 3) -> str:
    return "?" if x is None or not math.isfinite(x) else f"{x + 0.0:.{digits}g}"


def _cameras(rig: Rig) -> str:
    r, views, out = rig.residuals, rig.views, is_left_out(rig)
    rows = []
    centres = np.array([rig.cam_from_rig(name).center for name in rig])
    centres[np.abs(centres) < 1e-9 * np.abs(centres).max()] = 0  # rounding
    for k, name in enumerate(rig):
        camera, sigma = rig[name], rig.sigmas.get(name)
        own = (r["camera"] == name) & ~r["left_out"]
        mine = views["camera"] == name
        n_out = int((mine & out).sum())
        size = f"{camera.size[0]} &times; {camera.size[1]}" if camera.size else "?"
        rows.append([
            f'<i class="dot" style="background:var(--c{k % N_COLOURS})"></i>{text(name)}',
            size, "fisheye" if camera.lens == "fisheye" else "brown",
            _known(camera.fx, 5), *(_known(x, 5) for x in centres[k].tolist()),
            *(_known(x) for x in ((sigma.position, sigma.rotation_deg, sigma.noise_px)
                                  if sigma else (None,) * 3)),
            _known(rms(r["error_px"][own])) if own.any() else "?",
            f"{int(mine.sum())}" + (f" ({n_out} out)" if n_out else ""),
        ])  # fmt: skip
    heads = ["camera", "image [px]", "lens", "focal", "x", "y", "z", "&plusmn; centre",
             "&plusmn; turn<br>[deg]", "noise<br>[px]", "rms<br>[px]", "views"]  # fmt: skip
    note = "x, y, z: the centre in the rig's frame. &plusmn;: standard deviations."
    if not rig.sigmas:
        note += " They are not known of this rig (?)."
    return _table(heads, rows, [2]) + f'<p class="note">{note}</p>'


def _faults(rig: Rig) -> str:
    seen = [fault for fault in rig.faults if math.isfinite(fault.p)]
    if not rig.faults:
        return ""
    hidden = [fault for fault in rig.faults if not math.isfinite(fault.p)]
    body = _table(
        ["fault", "about", "how large", "by noise alone", "disagreement<br>without it",
         "the reason"],
        ([text(FAULTS.get(f.name, f.name)), text(f"{f.camera} {f.frame}".strip()) or "all",
          _value(f), _known(f.p, 2),
          _known(math.sqrt(f.F_after)) if f.F_after >= 0 else "?",
          "yes" if f.explains else "no"] for f in seen),
        [1, 2], most=FAULTS_MOST,
    ) if seen else ""  # fmt: skip
    if hidden:
        names = "; ".join(dict.fromkeys(FAULTS.get(f.name, f.name) for f in hidden))
        body += f'<p class="note">This recording cannot show: {text(names)}.</p>'
    return body


FAULTS = {
    "clock": "clock is late [s]", "clocks": "clocks are late [s]",
    "drift": "clock drifts [s/s]", "shutter": "rolling shutter [s]",
    "focal": "focal length, part of it", "aspect": "fx / fy, part of it",
    "centre": "principal point [px]", "distortion": "distortion, k1 and k2",
    "moved": "camera moved", "bent": "board is bent", "stretched": "board is stretched",
}  # fmt: skip


def _value(fault: Fault) -> str:
    if fault.name == "moved" and len(fault.values) == 6:
        turn, shift = (float(np.linalg.norm(fault.values[k : k + 3])) for k in (0, 3))
        return f"turn of {math.degrees(turn):.2g} deg, shift of {shift:.3g}"
    return ", ".join(
        f"{v:.3g} &plusmn; {s:.2g}" for v, s in zip(fault.values, fault.sigmas)
    )


def _clocks(rig: Rig) -> str:
    if not rig.clocks:
        return ""
    return _table(
        ["camera", "late by [ms]", "&plusmn;", "drift [ms/s]", "&plusmn;", "clock",
         "paired later by [frames]"],
        ([text(name), f"{1e3 * c.offset:.2f}", _known(1e3 * c.sigma_offset, 2),
          _known(1e3 * c.drift), _known(1e3 * c.sigma_drift, 2), text(c.state),
          f"{c.paired_later}"] for name, c in rig.clocks.items()),
        [5],
    )  # fmt: skip


def _left_out(rig: Rig) -> str:
    if not rig.left_out:
        return ""
    return _table(
        ["camera", "frame", "why", "what to do"],
        (
            [text(v.camera), text(v.frame), text(v.why), text(v.advice)]
            for v in rig.left_out
        ),
        [1],
        [2, 3],
    )


# ---- images -----------------------------------------------------------------------


def _thumbs(rig: Rig) -> str:
    """The worst views with known images, with residuals drawn over them."""
    if not rig.images:
        return ""
    out = np.flatnonzero(is_left_out(rig))[: THUMBS_MOST // 2].tolist()
    chosen = [*out, *worst_views(rig, THUMBS_MOST - len(out))]
    scale = max(1.0, 0.5 * arrow_scale(rig))
    made, missing = [], []
    for k in chosen:
        row = rig.views[k]
        key = str(row["camera"]), str(row["frame"])
        try:
            made.append(_thumb(rig, k, rig.images[key], scale))
        except KeyError:
            missing.append(f"{key[0]} in {key[1]}")
        except Error as problem:
            what = getattr(problem, "what", problem.text)
            missing.append(f"{key[0]} in {key[1]}: {what}")
    body = f'<div class="thumbs">{"".join(made)}</div>' if made else ""
    body += f'<p class="note">Residuals are {number(scale)} times as long as they are.</p>'
    if missing:
        told = text(no_folders("; ".join(missing)))
        body += f'<p class="note">No image of {told}.</p>'
    return body


def _thumb(rig: Rig, k: int, picture: Any, scale: float) -> str:
    image = read_image(picture)
    high, wide = image.shape[:2]
    rows = rig.residuals[rig.residuals["view"] == k]
    marks = []
    for row in rows:
        u, v, du, dv = (float(row[x]) for x in ("u", "v", "du", "dv"))
        if not (math.isfinite(u) and math.isfinite(v)):
            continue
        ring = f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{wide / 160:.1f}"'
        marks.append(f'{ring} class="{"o" if row["left_out"] else "k"}"/>')
        if math.isfinite(du) and math.isfinite(dv):
            marks.append(
                f'<path d="M{u - du:.1f} {v - dv:.1f}l{scale * du:.1f} {scale * dv:.1f}"/>'
            )
    view = rig.views[k]
    lost = (
        "left out" if is_left_out(rig)[k] else f"{number(float(view_rms(rig)[k]))} px rms"
    )
    name = f"{view['camera']} in {view['frame']}: {lost}"
    w = wide / 300
    return (
        f'<figure><svg viewBox="-0.5 -0.5 {wide} {high}" role="img" '
        f'aria-label="{text(name)}"><image href="{_jpeg(image)}" x="-0.5" y="-0.5" '
        f'width="{wide}" height="{high}"/><g fill="none" stroke-width="{w:.2f}">'
        f'<g stroke="#000" stroke-opacity=".55" stroke-width="{2.2 * w:.2f}">'
        f'{"".join(marks)}</g><g stroke="#ffd21f">{"".join(marks)}</g></g></svg>'
        f"<figcaption>{text(name)}</figcaption></figure>"
    )


def _jpeg(image: Any) -> str:
    from PIL import Image

    small = Image.fromarray(np.ascontiguousarray(image))
    if small.width > THUMB_WIDTH:
        height = max(1, round(small.height * THUMB_WIDTH / small.width))
        small = small.resize((THUMB_WIDTH, height))
    buffer = io.BytesIO()
    small.save(buffer, "JPEG", quality=THUMB_QUALITY)
    return "data:image/jpeg;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


# ---- the page ---------------------------------------------------------------------


def _section(title: str, body: str) -> str:
    return f"<section><h2>{title}</h2>{body}</section>" if body else ""


def _listed(items: Iterable[str], tag: str = "ul") -> str:
    made = "".join(f"<li>{text(item)}</li>" for item in items)
    return f"<{tag}>{made}</{tag}>" if made else ""


def _first(rig: Rig) -> str:
    """The verdict, why, and what to do."""
    kind, sentence = headline(rig)
    cause = rig.cause.rpartition("Next: ")[0] or rig.cause
    more = f"<p>{text(no_folders(cause.strip()))}</p>" if cause.strip() else ""
    return (
        f'<div class="verdict {kind}"><b>{WORDS[kind]}</b><p class="main">{sentence}</p>'
        f'{more}</div><p class="facts">{_facts(rig)}</p>'
    )


def _made(rig: Rig) -> str:
    from . import __version__

    rows = [f"rigcal {__version__}"]
    rows += [f"{name}: {value}" for name, value in rig.made.items()]
    return _listed(map(no_folders, rows))


def _report(rig: Rig) -> str:
    if not rig.report:
        return ""
    shown = rig.report
    if len(shown) > REPORT_MOST:
        half = REPORT_MOST // 2
        left = len(shown) - REPORT_MOST
        shown = f"{shown[:half]}\n... {left} characters are left out ...\n{shown[-half:]}"
    lines = "\n".join(text(no_folders(line)) for line in shown.splitlines())
    return f"<details><summary>show it</summary><pre>{lines}</pre></details>"


NEEDED_LEAST = ("The program's report", "The worst views", "Who saw the target together",
                "How well each view fits", "Residuals")  # fmt: skip


def make_page(rig: Rig, title: str | None = None) -> str:
    """The page as text; at most BYTES_MOST as UTF-8."""
    need()
    if title is None:
        title = f"Rig of {count(len(rig), 'camera')}: {clean(', '.join(rig), TITLE_MOST)}"
    has_views = len(rig.views) > 0
    parts = [
        ("What to do next", _listed(advice(rig), "ol")),
        ("What the program warned of", _listed(map(no_folders, rig.warnings[:ROWS_MOST]))),
        ("The rig", _space(rig)),
        ("Cameras", _cameras(rig)),
        ("Residuals", _picture(rig, "residuals") if has_views else ""),
        ("How well each view fits", _picture(rig, "views") if has_views else ""),
        ("The worst views", _thumbs(rig)),
        ("Who saw the target together", _picture(rig, "graph") if has_views else ""),
        ("What may be wrong with the rig as a whole", _faults(rig)),
        ("Clocks", _clocks(rig)),
        ("Views that are left out", _left_out(rig)),
        ("The program's report", _report(rig)),
        ("How it was made", _made(rig)),
    ]
    bodies = dict(parts)
    for least in (None, *NEEDED_LEAST):
        if least is not None:
            bodies[least] = (
                '<p class="note">Left out here: the page would be too large.</p>'
            )
        page = _assembled(rig, title, bodies)
        if len(page.encode("utf-8", "replace")) <= BYTES_MOST:
            return page
    raise Error(f"this rig is too large for a page of {BYTES_MOST} bytes")


def _assembled(rig: Rig, title: str, bodies: dict[str, str]) -> str:
    sections = "".join(_section(name, body) for name, body in bodies.items())
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        '<meta name="color-scheme" content="light dark">'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        "style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">"
        f"<title>{text(title)}</title><style>{STYLE}.k{{}}.o{{stroke:#ff5a1f}}</style></head>"
        f"<body><main><h1>{text(title)}</h1>{_first(rig)}{sections}</main>"
        f"<script>{SCRIPT}</script></body></html>\n"
    )


@contextlib.contextmanager
def _blamed(path: str | os.PathLike[str]) -> Iterator[None]:
    try:
        yield
    except OSError as problem:
        raise FileError(path, str(problem.strerror or problem)) from None


def check_path(path: str | os.PathLike[str]) -> None:
    """FileError if no page can be written there. Called before long work."""
    where = pathlib.Path(path)
    if where.is_dir():
        raise FileError(path, "this is a folder: the name of a file is expected")
    if not where.parent.is_dir():
        raise FileError(path, f"there is no folder {where.parent}")


def write_page(rig: Rig, path: str | os.PathLike[str], title: str | None = None) -> None:
    """Writes the page: whole, or not at all."""
    check_path(path)
    page = make_page(rig, title).encode("utf-8", "replace")
    where = pathlib.Path(path)
    with _blamed(path):
        handle, name = tempfile.mkstemp(".part", where.name + ".", where.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(page)
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(name, 0o666 & ~mask)
            os.replace(name, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)
            raise
