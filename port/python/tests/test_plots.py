"""Pictures show what the rig holds, and can be read in every case."""

from __future__ import annotations

import itertools
import pathlib
import subprocess
import sys
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cli_scenes import STEREO, Recording, rotation
from conftest import numpy_project
from plot_scenes import SIZE, ink, labelled, panels, pixels, ring, stored, texts

import rigcal
from rigcal.plots import _scene, _style, _views

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")


@pytest.fixture(scope="module")
def stereo_rig() -> rigcal.Rig:
    return rigcal.calibrate(STEREO / "cameras.csv", STEREO / "observations.csv")


@pytest.fixture(autouse=True)
def closed() -> Any:
    yield
    from matplotlib import pyplot

    pyplot.close("all")


def vertices(artist: Any) -> Any:
    return artist.get_path().vertices


# ---- in space -----------------------------------------------------------------------


def segments(ax: Any, label: str) -> list[Any]:
    return [s for artist in labelled(ax, label) for s in artist._segments3d]


def test_each_camera_and_board_is_drawn_where_it_is(stereo_rig: rigcal.Rig) -> None:
    figure = stereo_rig.plot()
    (ax,) = figure.axes
    turn = _scene.make_scene(stereo_rig).turn
    assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-12
    assert np.linalg.det(turn) == pytest.approx(1)
    for name in stereo_rig:
        border, *edges = segments(ax, f"frustum {name}")
        C = stereo_rig.cam_from_rig(name).center
        assert len(edges) == 4
        for edge in edges:
            assert np.abs(turn.T @ edge[0] - C).max() < 1e-9
        camera = stereo_rig[name]
        X = stereo_rig.cam_from_rig(name).apply(border @ turn)
        uv = numpy_project(camera, X)
        w, h = camera.size
        corners = [[-0.5, -0.5], [w - 0.5, -0.5], [w - 0.5, h - 0.5], [-0.5, h - 0.5]]
        assert np.abs(uv[:-1:4] - corners).max() < 1e-3  # of a distorted lens
    boards = segments(ax, "boards")
    assert len(boards) == 7
    X = np.array([[x, y, 0] for x in (0, 8) for y in (0, 5)]) * 0.025
    seen = [stereo_rig.targets[f].apply(X) @ turn.T for f in sorted(stereo_rig.targets)]
    for board, corners in zip(boards, seen):
        gap = np.linalg.norm(board[:, None] - corners[None], axis=2).min(0)
        assert gap.max() < 1e-3 * np.ptp(corners, axis=0).max()
        assert np.abs(board[0] - board[-1]).max() == 0
    for name in stereo_rig:
        assert name in texts(figure)


def test_ellipsoids_are_those_of_the_covariance(stereo_rig: rigcal.Rig) -> None:
    C = _scene.centre_covariance(stereo_rig, "right")
    assert C is not None
    # The program's own standard deviation of the centre, to the digits of rig.csv.
    assert np.sqrt(np.trace(C)) == pytest.approx(
        stereo_rig.sigmas["right"].position, rel=1e-6
    )
    for k, exaggeration in ((3.0, None), (1.0, 50.0)):
        figure = stereo_rig.plot(k=k, exaggeration=exaggeration)
        ax = figure.axes[0]
        scene = _scene.make_scene(stereo_rig, k, exaggeration)
        rings = segments(ax, "ellipsoid right")
        assert len(rings) == 3
        assert not labelled(ax, "ellipsoid left")  # the frame has none
        d = np.vstack(rings) @ scene.turn - stereo_rig.cam_from_rig("right").center
        large = k * scene.exaggeration
        inside = np.einsum("ni,ij,nj->n", d, np.linalg.inv(C), d) / large**2
        assert np.abs(inside - 1).max() < 1e-6
        said = texts(figure)
        assert f"{k:g} sigma of the centre" in said
        assert f"{scene.exaggeration:g} times as large" in said
        assert "no ellipsoid of left" in said
    assert scene.exaggeration == 50


def test_the_covariance_of_a_centre_is_that_of_moved_poses() -> None:
    recording = Recording()
    rig = rigcal.calibrate(recording.cameras, recording.rows)
    T, step = rig.cam_from_rig("c"), 1e-6
    J = np.zeros((3, 6))
    for k, d in enumerate(step * np.eye(6)):
        R = rotation(*d[:3]) @ T.R
        J[:, k] = (-R.T @ (T.t + d[3:]) - T.center) / step
    expected = J @ rig.covariance("c") @ J.T
    C = _scene.centre_covariance(rig, "c")
    assert C is not None
    assert np.abs(C - expected).max() < 1e-4 * np.abs(expected).max()


def test_scales_are_equal_and_all_is_inside(stereo_rig: rigcal.Rig) -> None:
    for rig in (stereo_rig, ring(12, 3), ring(1, 3), stored()):
        figure = rig.plot()
        (ax,) = figure.axes
        sides = [np.ptp(lim()) for lim in (ax.get_xlim, ax.get_ylim, ax.get_zlim)]
        assert np.ptp(sides) < 1e-9 * sides[0]
        assert np.ptp(ax._box_aspect) < 1e-9
        from rigcal.plots._rig import _on_screen

        screen = _on_screen(ax, np.vstack(segments(ax, "frustum")))
        w, h = figure.get_size_inches() * figure.dpi
        assert (screen > 0).all()
        assert (screen < [w, h]).all()
        assert np.ptp(screen, axis=0).max() > 0.2 * h


def test_up_is_as_the_cameras_stand() -> None:
    assert _scene.make_scene(ring(5)).up == pytest.approx([0, -1, 0], abs=1e-9)
    down = []  # cameras that look straight down, turned about their axes
    for k in range(4):
        a = np.pi / 2 * k
        R = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
        pose = rigcal.Transform(R, -R @ [k % 2, k // 2, 0], f"c{k}", "rig")
        down.append(
            rigcal.Camera(900, 900, 640, 360, size=SIZE, cam_from_rig=pose, name=f"c{k}")
        )
    calibrated = rigcal.CalibratedRig.from_cameras(down)
    scene = _scene.make_scene(rigcal.Rig(calibrated, calibrated.cameras))
    assert scene.up == pytest.approx([0, 0, -1])


def test_names_do_not_lie_on_each_other() -> None:
    figure = ring(6).plot()
    figure.canvas.draw()
    boxes = [
        t.get_window_extent() for t in figure.axes[0].texts if t.get_text()[:3] == "cam"
    ]
    assert len(boxes) == 6
    for a, b in itertools.combinations(boxes, 2):
        assert not a.overlaps(b)


def test_many_boards_are_thinned_and_it_is_said() -> None:
    rig = ring(3, 500)
    figure = rig.plot()
    n = len(segments(figure.axes[0], "boards"))
    assert 40 <= n <= _scene.BOARDS_MOST
    assert f"{n} of 500 boards are drawn" in texts(figure)
    assert not labelled(rig.plot(boards=False).axes[0], "boards")


# ---- residuals ------------------------------------------------------------------------


def test_arrows_are_the_residuals() -> None:
    rig = ring(3, 5, left_out=2)
    figure = rig.plot_residuals(scale=40)
    assert "40 times as long" in texts(figure)
    for ax, name in zip(figure.axes, rig):
        r = rig.residuals[rig.residuals["camera"] == name]
        for label, which in (("residuals", ~r["left_out"]), ("left out", r["left_out"])):
            rows = r[which]
            found = labelled(ax, label)
            if not len(rows):
                assert not found
                continue
            (arrows,) = found
            places = vertices(arrows).reshape(-1, 5, 2)
            uv, d = (np.column_stack([rows[a], rows[b]]) for a, b in ("uv", ("du", "dv")))
            assert np.abs(places[:, 0] - (uv - d)).max() < 1e-9
            assert np.abs(places[:, 1] - (uv + 39 * d)).max() < 1e-9
        crosses = [len(line.get_xdata()) for line in labelled(ax, "left-out points")]
        assert sum(crosses) == r["left_out"].sum()
        rms = np.sqrt(np.mean(r["error_px"][~r["left_out"]] ** 2))
        assert ax.get_title(loc="left") == f"{name}: {rms:.3g} px rms"
        (border,) = labelled(ax, "border")
        assert (border.get_width(), border.get_height()) == SIZE
        assert border.get_xy() == (-0.5, -0.5)
        assert ax.yaxis_inverted()


def test_the_scale_is_one_for_all_and_the_arrows_can_be_seen() -> None:
    rig = ring(4)
    scale = _views.arrow_scale(rig)
    assert 0.02 * 1280 < scale * np.quantile(rig.residuals["error_px"], 0.9) < 0.08 * 1280
    for large in (1e-6, 1e5):
        changed = ring(2)
        for name in ("du", "dv", "error_px"):
            changed.residuals[name] *= large
        figure = changed.plot_residuals()
        assert min(panels(figure)) > 0.01


def test_of_many_points_the_largest_are_drawn() -> None:
    rig = ring(2, 60, points=40)
    figure = rig.plot_residuals(most=300)
    for ax, name in zip(figure.axes, rig):
        (arrows,) = labelled(ax, "residuals")
        places = vertices(arrows).reshape(-1, 5, 2)
        assert len(places) == 300
        r = rig.residuals[rig.residuals["camera"] == name]
        worst = r[r["error_px"].argmax()]
        start = np.array([worst["u"] - worst["du"], worst["v"] - worst["dv"]])
        assert np.abs(places[:, 0] - start).sum(1).min() < 1e-9
    assert f"600 of {len(rig.residuals)} points: the largest" in texts(figure)
    own = rig.plot_residuals("cam1", most=10)
    assert len(own.axes) == 1
    with pytest.raises(rigcal.Error, match="no camera 'cam7'"):
        rig.plot_residuals(["cam7"])
    with pytest.raises(rigcal.Error, match="ax: one camera is drawn on it, not 2"):
        rig.plot_residuals(ax=own.axes[0])


# ---- views and graph --------------------------------------------------------------------


def test_dots_are_the_rms_of_views() -> None:
    rig = ring(3, 8, left_out=3)
    figure = rig.plot_views(worst=4)
    (ax,) = figure.axes
    out = rig.views["verdict"] == "contradicts"
    rms = np.array(
        [np.sqrt(np.mean(rig.residuals["error_px"][rig.residuals["view"] == k] ** 2))
         for k in range(len(rig.views))]
    )  # fmt: skip
    for name in rig:
        (dots,) = labelled(ax, name)
        mine = (rig.views["camera"] == name) & ~out
        assert dots.get_ydata() == pytest.approx(rms[mine])
        assert np.round(dots.get_xdata()) == pytest.approx(
            rig.views["frame"][mine].astype(int)
        )
    (crosses,) = labelled(ax, "left out")
    assert sorted(crosses.get_ydata()) == pytest.approx(sorted(rms[out]))
    (stems,) = labelled(ax, "from own to rig")
    assert len(vertices(stems)) == 2 * len(rig.views)
    said = texts(figure)
    order = [k for k in np.argsort(-rms) if not out[k]][:4]
    for rank, k in enumerate(order, 1):
        camera, frame = rig.views[k]["camera"], rig.views[k]["frame"]
        assert f"{rank}: {camera} in {frame}, {rms[k]:.3g} px" in said
    assert [t.get_text() for t in ax.get_legend().get_texts()] == [*rig, "left out"]
    huge = ring(2, 30)
    huge.residuals["error_px"][:12] *= 1000
    assert huge.plot_views().axes[0].get_yscale() == "log"


def test_edges_have_the_number_of_common_frames() -> None:
    rig = ring(4, 7, left_out=4, seed=3)
    counts = {n: set() for n in rig}
    every: dict[str, set[str]] = {n: set() for n in rig}
    for view in rig.views:
        every[view["camera"]].add(view["frame"])
        if view["verdict"] == "fits":
            counts[view["camera"]].add(view["frame"])
    figure = rig.plot_graph()
    left, right = figure.axes
    said = [t.get_text() for t in left.texts]
    for a, b in itertools.combinations(rig, 2):
        common = len(counts[a] & counts[b])
        lost = len(every[a] & every[b]) - common
        (edge,) = labelled(left, f"edge {a} {b}")
        assert edge.get_linestyle() == ("-" if common else "--")
        assert f"{common}" + (f" +{lost}" if lost else "") in said
    assert len(labelled(left, "camera")) == 4
    drawn = sum(len(vertices(x)) for x in labelled(right, "views")) // 2
    assert drawn == (rig.views["verdict"] == "fits").sum()
    lost_views = sum(len(vertices(x)) for x in labelled(right, "left out")) // 2
    assert lost_views == 4
    assert all(x.get_linestyle() != "-" for x in labelled(right, "left out"))
    assert "24 views count" not in texts(figure)
    assert "23 views count, 4 left out (dashed)" in texts(figure)


def test_an_edge_of_views_left_out_is_dashed() -> None:
    rig = ring(2, 3)
    rig.views["verdict"][rig.views["camera"] == "cam1"] = "one_of_two"
    (edge,) = labelled(rig.plot_graph().axes[0], "edge")
    assert edge.get_linestyle() == "--"


def test_many_cameras_are_a_table() -> None:
    rig = ring(12, 9)
    figure = rig.plot_graph()
    said = [t.get_text() for t in figure.axes[0].texts]
    assert len(said) == 12 * 11 // 2
    assert said.count("9") == 11 * 10 // 2
    assert said.count("8") == 11  # the last camera did not see frame 1
    assert not labelled(figure.axes[0], "edge")


# ---- matches ----------------------------------------------------------------------------


def test_the_band_is_drawn_where_it_is(stereo_rig: rigcal.Rig) -> None:
    r = stereo_rig.residuals
    left, right = (r[(r["camera"] == n) & (r["frame"] == "03")] for n in ("left", "right"))
    uv = np.column_stack([left["u"], left["v"]])[[4, 30]]
    candidates = np.column_stack([right["u"], right["v"]])
    options = {"depth": (0.2, 0.6), "probability": 0.95}
    figure = stereo_rig.plot_match("left", uv, "right", candidates=candidates, **options)
    a, b = figure.axes
    pixel = np.array([line.get_xydata()[0] for line in labelled(a, "pixel")])
    assert pixel == pytest.approx(uv)
    curve = stereo_rig.match_line("left", uv, "right", n=96, **options)
    lines, bands = labelled(b, "line"), labelled(b, "band")
    assert len(lines) == len(bands) == 2
    for k, (line, band) in enumerate(zip(lines, bands)):
        n = curve.n_places[k]
        assert line.get_xydata() == pytest.approx(curve.uv[k, :n])
        side = curve.half_width[k, :n, None] * curve.across[k, :n]
        xy = band.get_xy()
        assert xy[:n] == pytest.approx(curve.uv[k, :n] - side)
        assert xy[n : 2 * n][::-1] == pytest.approx(curve.uv[k, :n] + side)
    said = texts(figure)
    assert "band of 95 %" in said
    for text in ("0: 0.2", "0: 0.6", "1: 0.2", "1: 0.6", "54 candidates (dots)"):
        assert text in said
    assert len(labelled(b, "candidates")[0].get_xdata()) == 54
    (best,) = labelled(b, "best")
    assert best.get_xydata() == pytest.approx(candidates[[4, 30]])
    assert min(panels(figure)) > 0.01


def test_images_are_drawn_beneath(stereo_rig: rigcal.Rig, tmp_path: pathlib.Path) -> None:
    rng = np.random.default_rng(1)
    grey = rng.integers(0, 255, (480, 640), dtype=np.uint8)
    deep = (grey.astype(np.uint16)) * 256
    matplotlib.image.imsave(tmp_path / "x.png", grey, cmap="gray")
    for images in (
        (grey, deep),
        (tmp_path / "x.png", grey / 255.0),
        (grey[..., None], grey),
    ):
        figure = stereo_rig.plot_match("left", [300, 200], "right", images=images)
        for ax in figure.axes:
            (image,) = ax.images
            shown = np.asarray(image.get_array(), float)
            if shown.ndim == 3:
                shown = shown[..., 0]
            assert np.abs(shown - grey).max() <= 2
            assert image.get_extent() == pytest.approx((-0.5, 639.5, 479.5, -0.5))
    for images, match in (
        ((grey, grey[:-1]), "images: right is 640 x 480, not 640 x 479"),
        ((grey,), "images: a pair"),
        ((grey, np.zeros((2, 2, 2, 2))), r"images: \(h, w\)"),
        ((tmp_path / "no.png", grey), r"no\.png: there is no such file"),
        ((pathlib.Path(__file__), grey), "this is no image"),
    ):
        with pytest.raises(rigcal.Error, match=match):
            stereo_rig.plot_match("left", [300, 200], "right", images=images)
    far = stereo_rig.plot_match("left", [300, 200], "right", depth=(1e-6, 2e-6))
    assert "pixel 0: no match in this image" in texts(far)


# ---- a monitor --------------------------------------------------------------------------


def history(n: int = 60, alarm: int = 40) -> list[rigcal.MonitorReport]:
    first = rigcal.MonitorReport(
        alarm=False, body="left", confidence=0.0, evidence=-9.0, noise=1.02,
        smallest_rad=1e-3, n_blind=0, frames=0, rows=0, doubted=0, frames_since=0,
    )  # fmt: skip
    return [
        replace(
            first, frames=k + 1, evidence=-8 + 0.21 * k, alarm=k >= alarm,
            body="right" if k > 20 else "left", confidence=0.97,
        )
        for k in range(n)
    ]  # fmt: skip


def test_evidence_alarm_and_blame() -> None:
    reports = history()
    figure = rigcal.plot_monitor(reports)
    top, low = figure.axes
    (line,) = labelled(top, "evidence")
    assert line.get_xdata() == pytest.approx(np.arange(1, 61))
    assert line.get_ydata() == pytest.approx([r.evidence for r in reports])
    (limit,) = labelled(top, "limit")
    assert set(limit.get_ydata()) == {0}
    (alarm,) = labelled(top, "alarm")
    assert alarm.get_x() == 41
    assert "alarm: right, 97 %" in texts(figure)
    assert "1 alarm" in texts(figure)
    (blamed,) = labelled(low, "blamed")
    assert blamed.get_xdata() == pytest.approx(np.arange(41, 61))
    assert sum(len(x.get_xdata()) for x in labelled(low, "most evidence")) == 40
    assert [t.get_text() for t in low.get_yticklabels()] == ["left", "right"]
    assert min(panels(figure)) > 0.005
    timed = rigcal.Monitor.plot(reports, np.arange(60) / 30, dark=True)
    assert labelled(timed.axes[0], "evidence")[0].get_xdata()[-1] == pytest.approx(59 / 30)


def test_odd_histories() -> None:
    figure = rigcal.plot_monitor([])
    assert texts(figure).count("no reports yet") == 2
    broken = [
        replace(r, evidence=np.nan if k % 2 else -np.inf) for k, r in enumerate(history())
    ]
    assert "60 reports without a number" in texts(rigcal.plot_monitor(broken))
    one = rigcal.plot_monitor(history(1), ax=matplotlib.figure.Figure().add_subplot())
    assert len(one.axes) == 1
    bodies = [replace(r, body=f"b{k}", n_blind=3) for k, r in enumerate(history())]
    said = texts(rigcal.plot_monitor(bodies))
    assert "36 more are not drawn" in said
    assert "3 bodies seen too little" in said
    with pytest.raises(rigcal.Error, match="reports: several are expected, not NoneType"):
        rigcal.plot_monitor(None)
    with pytest.raises(rigcal.Error, match="reports: a MonitorReport is expected, not int"):
        rigcal.plot_monitor([3])  # type: ignore[list-item]
    with pytest.raises(rigcal.Error, match="seconds: 60 numbers are expected"):
        rigcal.plot_monitor(history(), [1, 2])


# ---- every picture, in every case --------------------------------------------------------


def holes() -> rigcal.Rig:
    """NaN where numbers may be missing."""
    rig = ring(3, 4, left_out=1)
    rig.residuals["du"][::3] = rig.residuals["error_px"][::3] = np.nan
    rig.residuals["u"][::5] = np.nan
    rig.residuals["X"][::7] = np.nan
    rig.views["rms_px"][::2] = np.nan
    return rig


def empty() -> rigcal.Rig:
    """Not one number among the residuals."""
    rig = ring(2, 3)
    for name in ("X", "Y", "Z", "u", "v", "du", "dv", "error_px"):
        rig.residuals[name] = np.nan
    return rig


ODD = ["$x$", "a_b^2 \\frac", "кам\N{CAMERA}", "x" * 300, "\ud800\n\x00", "_hidden"]
CASES = {
    "ring": ring, "one": lambda: ring(1, 1),
    "stored": stored, "eleven": lambda: ring(11, 4, left_out=5),
    "long": lambda: ring(2, 1000, points=4), "names": lambda: ring(6, 3, names=ODD),
    "no size": lambda: ring(2, 3, size=None), "holes": holes, "empty": empty,
}  # fmt: skip
PLOTS = ("plot", "plot_residuals", "plot_views", "plot_graph")


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("plot", PLOTS)
def test_each_picture_of_each_rig_has_ink(case: str, plot: str) -> None:
    rig = CASES[case]()
    dark = plot in PLOTS[::2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "Glyph")
        warnings.filterwarnings("ignore", "Matplotlib currently does not support")
        figure = getattr(rig, plot)(dark=dark)
        image = pixels(figure)
        inks = panels(figure, image)
    paper = matplotlib.colors.to_rgb((_style.DARK if dark else _style.LIGHT)["paper"])
    assert np.abs(image[0, -1] - np.array(paper) * 255).max() <= 1
    assert len(inks) >= 1
    assert min(inks) > 0.002
    said = texts(figure)
    if case == "stored":
        assert "no " in said
    if case == "no size" and plot in PLOTS[:2]:
        assert "image size" in said
    if case == "names":
        assert r"\$x\$" in said or plot == "plot_views"


def test_pictures_go_on_axes_that_are_given() -> None:
    rig = ring(3)
    figure = matplotlib.figure.Figure(figsize=(9, 9))
    space = figure.add_subplot(2, 2, 1, projection="3d")
    flat = [figure.add_subplot(2, 2, k) for k in (2, 3, 4)]
    assert rig.plot(ax=space) is figure
    assert rig.plot_residuals("cam0", ax=flat[0]) is figure
    assert rig.plot_views(ax=flat[1]) is figure
    assert rig.plot_graph(ax=flat[2]) is figure
    assert len(figure.axes) == 4
    assert min(panels(figure)) > 0.01
    assert labelled(space, "frustum")
    assert labelled(flat[2], "edge")


def test_what_is_shown_once_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib import pyplot

    assert ring(2).plot_views() is pyplot.gcf()
    pyplot.close("all")
    monkeypatch.setattr(matplotlib, "get_backend", lambda: "module://matplotlib_inline")
    figure = ring(2).plot_views()
    assert not pyplot.get_fignums()
    assert ink(pixels(figure)) > 0.01


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for plot in PLOTS:
        with pytest.raises(rigcal.Error, match=r"pip install rigcal\[plot\]"):
            getattr(ring(2), plot)()


def test_the_package_does_not_import_matplotlib(tmp_path: pathlib.Path) -> None:
    script = "import rigcal, sys; sys.exit('matplotlib' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], check=False, cwd=tmp_path)
    assert run.returncode == 0


# ---- colours -----------------------------------------------------------------------------


def luminance(rgb: Any) -> float:
    """The luminance of WCAG 2, of linear red, green and blue."""
    return float(np.dot([0.2126, 0.7152, 0.0722], rgb))


def linear(colour: str) -> Any:
    c = np.array(matplotlib.colors.to_rgb(colour))
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


# Machado, Oliveira and Fernandes 2009, full severity, of linear values.
BLIND = {
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
               [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
               [-0.011820, 0.042940, 0.968881]],
    "none": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
}  # fmt: skip


def lab(rgb: Any) -> Any:
    """CIE Lab of linear sRGB, white of D65."""
    M = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    t = M @ np.clip(rgb, 0, 1) / [0.9505, 1, 1.089]
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("theme", [_style.LIGHT, _style.DARK])
def test_colours_can_be_read_and_told_apart(theme: dict[str, str]) -> None:
    assert len(set(theme.values())) == len(theme)  # each is one variable of a page
    paper = luminance(linear(theme["paper"]))

    def contrast(name: str) -> float:
        other = luminance(linear(theme[name]))
        return (max(paper, other) + 0.05) / (min(paper, other) + 0.05)

    for name, least in (("ink", 12), ("faint", 4.5), ("bad", 4.5)):
        assert contrast(name) > least
    marks = [f"c{k}" for k in range(_style.N_COLOURS)]
    assert min(map(contrast, marks)) > 2.7
    for matrix in BLIND.values():
        seen = {
            name: lab(np.array(matrix) @ linear(theme[name])) for name in [*marks, "bad"]
        }
        for a, b in itertools.combinations(seen, 2):
            assert np.linalg.norm(seen[a] - seen[b]) > 10, (a, b)


def test_cameras_of_one_colour_have_different_markers() -> None:
    n = 6 * len(_style.MARKERS)
    theme = _style.Theme()
    assert len({(theme.of(k), _style.marker(k)) for k in range(n)}) == n
