"""From images and videos to a rig: real ones, and drawn ones with known truth."""

from __future__ import annotations

import dataclasses
import json
import re
import warnings

import image_scenes as scenes
import numpy as np
import pytest
from conftest import ROOT, angle

import rigcal
from rigcal import command

CAMERAS = ROOT / "examples/data/opencv_stereo/cameras.csv"
LEFT, RIGHT = (str(scenes.DATA / f"{side}*.jpg") for side in ("left", "right"))
BOARD = rigcal.Chessboard(9, 6, 0.025)
DELAYS, FPS = (0.0, 0.020, -0.012), 15.0  # s; pictures a second


@pytest.fixture(scope="module")
def stereo():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)  # left.jpg is none of the 26
        return rigcal.detect([LEFT, RIGHT], BOARD, cameras=CAMERAS)


def baseline(rig):
    return np.linalg.norm(rig.pair("left", "right").transform.t)


def test_26_images(stereo):
    assert len(stereo) == 26 * 54
    rig = rigcal.calibrate(CAMERAS, stereo)
    assert baseline(rig) == pytest.approx(0.0832, abs=0.0003)
    assert rig.images["left", "01"] == str(scenes.DATA / "left01.jpg")
    assert rig.warnings == []
    # as those of the project's own data, which OpenCV 5 made of the same images
    own = rigcal.Detections.load(ROOT / "examples/data/opencv_stereo/observations.csv")
    rows = {key: k for k, key in enumerate(zip(stereo.frame, stereo.camera, stereo.point))}
    same = [rows[key] for key in zip(own.frame, own.camera, own.point)]
    assert np.median(np.hypot(own.u - stereo.u[same], own.v - stereo.v[same])) < 1e-3


def test_sizes_of_cameras_come_from_images(stereo, tmp_path):
    known = rigcal.load_cameras(CAMERAS)
    bare = {n: dataclasses.replace(c, size=None) for n, c in known.items()}
    rig = rigcal.calibrate(bare, stereo)
    assert rig["left"].size == (640, 480)
    assert baseline(rig) == baseline(rigcal.calibrate(known, stereo))


def test_sigma_ranks_residuals(stereo):
    rig = rigcal.calibrate(CAMERAS, stereo)
    error = {(r["camera"], r["frame"], r["point"]): r["error_px"] for r in rig.residuals}
    e = np.array([error[k] for k in zip(stereo.camera, stereo.frame, stereo.point)])
    worst = stereo.sigma_px > np.quantile(stereo.sigma_px, 0.95)
    assert np.sqrt(np.mean(e[worst] ** 2)) > 1.1 * np.sqrt(np.mean(e[~worst] ** 2))


def test_corners_weigh_by_their_sigma(stereo, tmp_path):
    """A wrong corner with a large sigma moves a rig only if points are not weighted."""
    plain = rigcal.calibrate(CAMERAS, stereo)
    assert "all points count alike: column sigma_px is not used" in plain.report
    u, sigma = stereo.u.copy(), np.ones(len(stereo))
    wrong = np.flatnonzero(stereo.point == "13")
    u[wrong] += 2.0
    sigma[wrong] = 1e5
    spoilt = dataclasses.replace(stereo, u=u, sigma_px=sigma)
    without = {name: np.delete(stereo[name], wrong) for name in stereo.columns}
    right = rigcal.calibrate(CAMERAS, without)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        rigs = [rigcal.calibrate(CAMERAS, spoilt, weigh=weigh) for weigh in (True, False)]
    off = [abs(baseline(rig) - baseline(right)) for rig in rigs]
    assert off[0] < 1e-9 < 1e-5 < off[1]
    spoilt.save(tmp_path / "d.csv")
    from_file = rigcal.calibrate(CAMERAS, tmp_path / "d.csv", weigh=True)
    assert baseline(from_file) == baseline(rigs[0])
    with pytest.raises(rigcal.Error, match="detections: no column sigma_px"):
        rigcal.calibrate(CAMERAS, {n: without[n] for n in list(without)[:8]}, weigh=True)


# ---- boards that look the same from several sides ---------------------------------


def as_board(stereo, columns, rows):
    """The detections of a part of the board, as if it were the whole board."""
    board = rigcal.Chessboard(columns, rows, 0.025)
    number = stereo.point.astype(int)
    inside = (number % 9 < columns) & (number // 9 < rows)
    point = (number // 9 * columns + number % 9)[inside].astype(str)
    columns_of = {name: stereo[name][inside] for name in stereo.columns}
    return dataclasses.replace(stereo, **{**columns_of, "point": point}, target=board)


def read_from(found, changed):
    """Detections with some views read from another side: {(camera, frame): turns}."""
    names = list(found.target.points)
    X = np.array(list(found.target.points.values()))
    point, at = found.point.copy(), np.column_stack([found.X, found.Y, found.Z])
    for key, turns in changed.items():
        rows = found.views[key]
        new = [found.target.symmetry[turns - 1][int(name)] for name in point[rows]]
        point[rows], at[rows] = [names[k] for k in new], X[new]
    x, y, z = at.T
    return dataclasses.replace(found, point=point, X=x, Y=y, Z=z)


@pytest.mark.parametrize("size", [(8, 6), (7, 5), (6, 6)])
def test_boards_read_from_several_sides(stereo, size, rng, tmp_path):
    found = as_board(stereo, *size)
    right = rigcal.calibrate(CAMERAS, found)
    assert right.warnings == []
    turns = len(found.target.symmetry)
    changed = {
        key: int(rng.integers(1, turns + 1)) for key in found.views if rng.random() < 0.4
    }
    mixed = read_from(found, changed)
    assert not (mixed.point == found.point).all()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rig = rigcal.calibrate(CAMERAS, mixed)
    assert f"looks the same from {turns + 1} sides" in str(caught[0].message)
    assert baseline(rig) == pytest.approx(baseline(right), rel=1e-6)
    assert rig.left_out == []
    assert rig.sqrt_f == pytest.approx(right.sqrt_f, rel=1e-6)
    # so does a table that has gone through a file, or is a mapping, or was loaded
    mixed.save(tmp_path / "d.csv")
    loaded = rigcal.Detections.load(tmp_path / "d.csv")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for table in (tmp_path / "d.csv", loaded, loaded.table()):
            assert baseline(rigcal.calibrate(CAMERAS, table)) == baseline(rig)
    loaded.save(tmp_path / "e.csv")
    assert (tmp_path / "e.csv").read_text() == (tmp_path / "d.csv").read_text()


def test_a_symmetric_board_in_one_place_is_open(stereo):
    found = as_board(stereo, 8, 6)
    one = found.frame == "03"
    found = dataclasses.replace(found, **{n: found[n][one] for n in found.columns})
    with pytest.warns(rigcal.Caveat, match="do not tell which is meant for right"):
        rigcal.calibrate(CAMERAS, found)


# ---- videos ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def videos(tmp_path_factory):
    """Three cameras with clocks of their own: their files, cameras, and a file of these."""
    folder = tmp_path_factory.mktemp("videos")
    target = rigcal.Chessboard(9, 6, 0.03)
    cameras, pictures = scenes.moving_rig(target, 30, DELAYS, FPS)
    paths = {
        n: scenes.write_video(folder / f"{n}.avi", p, FPS) for n, p in pictures.items()
    }
    bare = {n: dataclasses.replace(c, cam_from_rig=None) for n, c in cameras.items()}
    rigcal.save_cameras(folder / "cameras.csv", bare)
    return paths, cameras, folder / "cameras.csv"


def off(rig, cameras, name):
    """The error of a camera: rotation [deg] and shift."""
    found, true = rig.pair("cam0", name).transform, cameras[name].cam_from_rig
    return np.degrees(angle(found.R, true.R)), np.linalg.norm(found.t - true.t)


def test_times_of_pictures_only_test_clocks_unless_these_are_asked_for(videos):
    """Without clocks the rig is the same as without times, although the pictures of a frame
    differ."""
    paths, _, file = videos
    found = rigcal.detect(paths, rigcal.Chessboard(9, 6, 0.03), every=2)
    late = {"cam0": 0.0, "cam1": 0.004, "cam2": -0.003}
    found.times = {(f, c): t + late[c] for (f, c), t in found.times.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        rig = rigcal.calibrate(file, found)
        without = rigcal.calibrate(file, dict(found))
        known = rigcal.calibrate(file, found, times=found.times)
    assert "the clocks" in rig.cause
    rms = [np.sqrt(np.mean(r.residuals["error_px"] ** 2)) for r in (rig, without, known)]
    assert rms[0] == pytest.approx(rms[1], rel=1e-6)
    assert rms[2] != pytest.approx(rms[1], rel=1e-3)


def test_clocks_of_videos(videos, tmp_path, capsys):
    paths, cameras, file = videos
    out, table = str(tmp_path / "out"), ["--board", "9x6", "--square", "0.03"]
    status = command.main(
        [
            "calibrate",
            "--videos",
            *paths.values(),
            *table,
            "--cameras",
            str(file),
            "--out",
            out,
        ]
    )
    text = capsys.readouterr().out
    assert status == 0
    assert "cam1: a chessboard of 9 x 6 inner corners in 30 of 30 pictures" in text
    assert re.search(r"the clocks: .* cam1's pictures are later by (19|20|21)\.\d+ ", text)
    assert re.search(r"cam2's pictures are earlier by 1[123]\.\d+ ", text)
    rig = rigcal.load(out)
    assert off(rig, cameras, "cam1")[0] > 0.5

    status = command.main(
        ["calibrate", "--clocks", "--cameras", str(file), "--out", out, *table, "--videos",
         *(f"{name}={path}" for name, path in paths.items())]
    )  # fmt: skip
    assert status == 0
    rig = rigcal.load(out)
    for name, delay in zip(cameras, DELAYS):
        assert rig.clocks[name].offset == pytest.approx(delay, abs=0.001)
        turn, shift = off(rig, cameras, name)
        assert turn < 0.05
        assert shift < 0.0005
    # what the program had is kept beside its answer
    again = rigcal.calibrate(
        file, f"{out}/observations.csv", times=f"{out}/times.csv", clocks=True
    )
    assert again.sqrt_f == pytest.approx(rig.sqrt_f)


# ---- the command ------------------------------------------------------------------


def run(capsys, *words):
    status = command.main([str(word) for word in words])
    streams = capsys.readouterr()
    return status, streams.out, streams.err


def test_calibrate_from_images(capsys, tmp_path, monkeypatch):
    pages = []
    monkeypatch.setattr(
        rigcal.Rig, "html", lambda rig, path: pages.append(path), raising=False
    )
    status, out, err = run(
        capsys, "calibrate", "--images", LEFT, RIGHT, "--board", "9x6", "--square", "0.025",
        "--cameras", CAMERAS, "--out", tmp_path, "--html", tmp_path / "rig.html",
        "--sigma=0.15", "--hold", "left",
    )  # fmt: skip
    assert status == 0
    assert out.startswith("left: a chessboard of 9 x 6 inner corners in 13 of 13 pictures")
    assert "left    right   0.0832" in out
    assert "left.jpg has no number as the others have" in err
    assert pages == [str(tmp_path / "rig.html")]
    assert json.loads((tmp_path / "summary.json").read_text())["n_points"] == 26 * 54


def test_detect_writes_what_calibrate_reads(capfd, tmp_path, videos):
    paths, _, file = videos
    table, times = tmp_path / "d.csv", tmp_path / "t.csv"
    status, out, _ = run(
        capfd, "detect", paths["cam0"], paths["cam1"], "--board=9x6", "--square=0.03",
        "--out", table, "--times-out", times, "--every", "3",
    )  # fmt: skip
    assert status == 0
    assert (
        "cam1: a chessboard of 9 x 6 inner corners in 10 of 10 pictures, 540 points" in out
    )
    two = tmp_path / "cameras.csv"
    two.write_text("\n".join(file.read_text().splitlines()[:3]) + "\n")
    status, out, _ = run(
        capfd, "calibrate", "--cameras", two, "--observations", table, "--times", times
    )
    assert "cam0    cam1" in out
    status, _, err = run(
        capfd, "detect", LEFT.replace("*", "01"), "--board", "9x6", "--square", "1",
        "--out", table, "--times-out", times,
    )  # fmt: skip
    assert (status, "the images have no times" in err) == (2, True)


def test_targets_of_the_command(tmp_path):
    parser = command._Parser()
    from rigcal.detect.command import add_target, target_of

    add_target(parser)
    grid, checks = tmp_path / "grid.yaml", tmp_path / "checks.yaml"
    rigcal.save_target(grid, rigcal.Target("aprilgrid", 6, 5, 0.088, 0.3))
    rigcal.save_target(checks, rigcal.Target("checkerboard", 9, 6, 0.02, 0.02))
    circles = tmp_path / "circles.yaml"
    rigcal.save_target(circles, rigcal.Target("circlegrid", 9, 6, 0.02))
    for words, target in (
        ("--board 9x6 --square 0.02 --inverted", rigcal.Chessboard(9, 6, 0.02, True)),
        (
            "--charuco 4x5 --square 2 --marker 1 --legacy --dictionary 5X5_50",
            rigcal.Charuco(4, 5, 2, 1, "5X5_50", True),
        ),
        (
            "--aprilgrid 6x5 --tag-size 1 --spacing 0.3 --first 7",
            rigcal.AprilGrid(6, 5, 1, 0.3, "tag36h11", 7),
        ),
        ("--tag 4 --tag-size 1 --family tag25h9", rigcal.Tag(1, 4, "tag25h9")),
        ("--tag --tag-size 1", rigcal.Tag(1)),
        (f"--target {grid}", rigcal.AprilGrid(6, 5, 0.088, 0.3)),
        (f"--target {checks}", rigcal.Chessboard(9, 6, 0.02)),
        ("--board 9x6", "--board needs --square"),
        ("--board 9 --square 1", "columns x rows are expected"),
        ("--charuco 4x5", "--square and --marker"),
        ("--tag x --tag-size 1", "the number of a tag"),
        ("--square 1", "one of --board, .* 0 are given"),
        (f"--target {circles}", "circlegrid of this kind cannot be detected"),
    ):
        given = parser.parse_args(words.split())
        if isinstance(target, str):
            with pytest.raises(rigcal.Error, match=target):
                target_of(given)
        else:
            assert target_of(given) == target


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("detect", "SOURCE, --out"),
        ("detect a=b c --out x --board 9x6 --square 1", "NAME=SOURCE, or none"),
        ("detect a=b a=c --out x --board 9x6 --square 1", "two sources have the same name"),
        (
            "detect /no --out x --board 9x6 --square 1",
            "/no: there is no such file or folder",
        ),
        ("calibrate --images a --videos b", "not allowed with"),
        ("calibrate --images a --board 9x6 --square 1", "--cameras: the file of the intri"),
        ("calibrate --images a --observations b", "unrecognized arguments: --observations"),
        (
            f"calibrate --images {LEFT} {RIGHT} --board 9x6 --square 1 --cameras {CAMERAS} "
            "--intrinsics-sigma 1,x",
            "five numbers",
        ),
    ],
)
def test_what_the_command_refuses(capsys, words, text):
    status, _, err = run(capsys, *words.split())
    assert status == 2
    assert text in err


def test_help(capsys):
    _, out, _ = run(capsys, "detect", "--help")
    assert "--charuco 4x5 --square 0.054 --marker 0.0405" in out
