"""rigcal.calibrate gives the program's numbers for detections in any form."""

from __future__ import annotations

import collections
import io
import pathlib
import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest
from cli_scenes import (
    DATA,
    NAMES,
    POSES,
    ROOT,
    SETS,
    STEREO,
    Recording,
    camera,
    off_by,
    rows_of,
    table_of,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import rigcal
from rigcal import _tables
from rigcal.calibrate import _Bar, program

COLUMNS = _tables.OBSERVATIONS
Module = sys.modules["rigcal.calibrate"]


def printed(folder: pathlib.Path, *options: str) -> str:
    """What the C program prints: the program that tests/cli tests, if it was built."""
    built = ROOT / "build" / "gcc-double" / "rigcal"
    run = subprocess.run(
        [
            str(built) if built.is_file() else program(),
            "calibrate",
            f"--cameras={folder / 'cameras.csv'}",
            f"--observations={folder / 'observations.csv'}",
            *options,
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout


# ---- the same numbers -----------------------------------------------------------


@pytest.mark.parametrize("name", SETS)
def test_the_ten_lines_print_what_the_program_prints(name: str) -> None:
    script = ROOT / "port" / "python" / "examples" / "calibrate.py"
    assert len(script.read_text().splitlines()) <= 10
    run = subprocess.run(
        [sys.executable, str(script), str(DATA / name)], capture_output=True, check=True
    )
    assert run.stdout.decode() == printed(DATA / name)
    assert run.stderr == b""


def as_structured(table: dict[str, Any]) -> Any:
    array = np.zeros(
        len(table["u"]), [(name, column.dtype) for name, column in table.items()]
    )
    for name, column in table.items():
        array[name] = column
    return array


def as_frame(table: dict[str, Any]) -> Any:
    return pytest.importorskip("pandas").DataFrame(table)


class Frame:
    """What every data frame has."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.table, self.columns = table, list(table)

    def __getitem__(self, name: str) -> Any:
        return self.table[name]


def as_named(table: dict[str, Any]) -> Any:
    row = collections.namedtuple("row", list(reversed(COLUMNS)))  # type: ignore[misc]
    return [
        row(**dict(zip(table, values)))
        for values in zip(*map(np.ndarray.tolist, table.values()))
    ]


FORMS = {
    "columns": dict,
    "lists": lambda t: {name: column.tolist() for name, column in t.items()},
    "structured": as_structured,
    "pandas": as_frame,
    "a data frame": Frame,
    "tuples": lambda t: list(zip(*(t[name].tolist() for name in COLUMNS))),
    "arrays": lambda t: [np.array(r, object) for r in zip(*(t[name] for name in COLUMNS))],
    "dicts": lambda t: [dict(zip(t, r)) for r in zip(*map(np.ndarray.tolist, t.values()))],
    "named tuples": as_named,
    "a generator": lambda t: (r for r in zip(*(t[name].tolist() for name in COLUMNS))),
    "objects": lambda t: {name: column.astype(object) for name, column in t.items()},
    "strided": lambda t: {name: np.repeat(column, 2)[::2] for name, column in t.items()},
}


@pytest.mark.parametrize("form", FORMS)
def test_detections_of_any_form(form: str) -> None:
    table = table_of(STEREO / "observations.csv")
    for column in table.values():
        column.setflags(write=False)
    cameras = rigcal.load_cameras(STEREO / "cameras.csv")
    rig = rigcal.calibrate(cameras, FORMS[form](table))
    assert rig.report == printed(STEREO)
    assert str(rig) == rig.report


@pytest.mark.parametrize(
    "convert",
    [
        lambda ids: np.array([int(i) for i in ids]),
        lambda ids: np.array([int(i) for i in ids], np.uint8),
        lambda ids: np.array([float(i) for i in ids]),
        lambda ids: [int(i) for i in ids],
        lambda ids: np.array([i.encode() for i in ids]),
        lambda ids: [np.int16(i) for i in ids],
    ],
)
def test_whole_numbers_are_names(convert: Any) -> None:
    table = table_of(STEREO / "observations.csv")
    table["point"] = convert(table["point"].tolist())
    assert rigcal.calibrate(STEREO / "cameras.csv", table).report == printed(STEREO)


def test_an_array_of_numbers_is_a_table() -> None:
    table = table_of(STEREO / "observations.csv")
    table["camera"] = (table["camera"] == "right") * 1.0
    array = np.column_stack([np.asarray(table[name], float) for name in COLUMNS])
    left, right = rigcal.load_cameras(STEREO / "cameras.csv").values()
    rig = rigcal.calibrate({"0": left, "1": right}, array)
    assert list(rig) == ["0", "1"]
    assert rig.views["frame"][0] == "1"  # 1.0: a column of numbers has no leading zero


def test_cameras_of_any_form(tmp_path: pathlib.Path) -> None:
    cameras = rigcal.load_cameras(STEREO / "cameras.csv")
    rigcal.save_cameras(tmp_path / "Calib.toml", cameras)
    for form in (
        list(cameras.values()),
        tmp_path / "Calib.toml",
        str(tmp_path / "Calib.toml"),
    ):
        rig = rigcal.calibrate(form, STEREO / "observations.csv")
        assert rig.report == printed(STEREO)
    recording = Recording(noise=0)
    unnamed = rigcal.calibrate(
        [camera() for _ in NAMES],
        [[f, f"cam{NAMES.index(c)}", *rest] for f, c, *rest in recording.rows],
    )
    assert list(unnamed) == ["cam0", "cam1", "cam2", "cam3"]


def test_options_are_those_of_the_program(tmp_path: pathlib.Path) -> None:
    files = STEREO / "cameras.csv", STEREO / "observations.csv"
    rig = rigcal.calibrate(
        *files, sigma_px=0.2, intrinsics_sigma=[0.001, 0.001, 1, 0.01, 0.02]
    )
    options = ("--sigma=0.2", "--intrinsics-sigma=0.001,0.001,1,0.01,0.02")
    assert rig.report == printed(STEREO, *options)
    by_name = dict(k2=0.02, k1=0.01, centre=1, aspect=0.001, focal=0.001)
    assert (
        rigcal.calibrate(*files, sigma_px=0.2, intrinsics_sigma=by_name).report
        == rig.report
    )
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        robust = rigcal.calibrate(
            *files, robust=True, threshold_px=0.4, seed=3, hold="right"
        )
    again = printed(STEREO, "--robust", "--threshold=0.4", "--seed=3", "--hold=right")
    assert robust.report == again
    assert 0 < robust.residuals["left_out"].sum() < 50
    with pytest.warns(rigcal.Caveat, match="camera left in frame 0"):
        rigcal.calibrate(*files, robust=True, threshold_px=0.3)
    paper = rigcal.calibrate(*files, method="paper")
    assert paper.report == printed(STEREO, "--method=paper")
    assert (paper.sigmas, paper.F, paper.noise_px, paper.verdict) == ({}, None, None, None)
    with pytest.raises(rigcal.Error, match="covariance"):
        paper.covariance("right")


# ---- a rig that is known ----------------------------------------------------------


def test_the_truth_without_noise() -> None:
    recording = Recording(noise=0)
    rig = rigcal.calibrate(recording.cameras, recording.rows)
    assert max(off_by(rig)) < 1e-8
    assert list(rig.cameras) == list(NAMES)
    assert (rig.left_out, rig.warnings) == ([], [])
    assert len(rig.residuals) == len(recording.rows)
    assert np.abs(rig.residuals["error_px"]).max() < 1e-5


def test_the_truth_with_noise_is_within_the_covariance() -> None:
    recording = Recording()
    rig = rigcal.calibrate(recording.cameras, recording.rows)
    assert rig.verdict == "agrees"
    assert rig.sqrt_f is not None
    assert 0.7 < rig.sqrt_f < 1.3
    assert rig.noise_px == pytest.approx(0.3, rel=0.05)
    assert "The views agree with one rig" in rig.cause
    chi2 = 0.0
    for name in "bcd":
        R, t = POSES[name]
        T = rig.cam_from_rig(name)
        turn = R @ T.R.T
        w = np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        error = np.concatenate([w / 2, t - T.t])
        chi2 += error @ np.linalg.solve(rig.covariance(name), error)
        assert rig.sigmas[name].rotation_deg == pytest.approx(
            np.degrees(np.sqrt(np.trace(rig.covariance(name)[:3, :3]))), rel=1e-6
        )
        assert rig.sigmas[name].noise_px == pytest.approx(0.3, rel=0.1)
    assert 2 < chi2 < 50  # of 18


def test_a_wrong_view_is_left_out_with_its_reason() -> None:
    recording = Recording()
    recording.spoil("101", "c")
    with pytest.warns(rigcal.Caveat, match="frame 101: camera c contradicts the others"):
        rig = rigcal.calibrate(recording.cameras, recording.rows)
    (view,) = rig.left_out
    assert (view.camera, view.frame) == ("c", "101")
    assert view.why.startswith("frame 101: camera c contradicts")
    assert view.advice
    assert rig.warnings == [
        f"{view.why}; the view is left out of the rig; {view.advice}"
    ] or rig.warnings == [f"{view.why}; {view.advice}"]
    row = rig.views[(rig.views["camera"] == "c") & (rig.views["frame"] == "101")]
    assert row["verdict"].tolist() == ["contradicts"]
    out = rig.residuals[rig.residuals["left_out"]]
    assert set(zip(out["camera"], out["frame"])) == {("c", "101")}
    assert (rig.views[out["view"]]["camera"] == out["camera"]).all()
    assert (rig.views[out["view"]]["frame"] == out["frame"]).all()
    assert off_by(rig)[1] < 1e-3


def test_a_wrong_camera_and_a_view_without_a_pose_are_left_out() -> None:
    recording = Recording()
    for frame in sorted({row[0] for row in recording.rows}):
        if frame != "700":
            recording.spoil(frame, "d")
    kept = recording.of("301", "b")[:2]
    recording.rows = [r for r in recording.rows if r[:2] != ["301", "b"]] + kept
    with pytest.warns(rigcal.Caveat):
        rig = rigcal.calibrate(recording.cameras, recording.rows)
    out = {(view.camera, view.frame): view.why for view in rig.left_out}
    assert "has no pose in frame 301" in out["b", "301"]
    of_d = {why for (name, _), why in out.items() if name == "d"}
    assert len(out) >= 22
    assert any("camera d" in why for why in of_d)


def test_two_views_of_a_frame_have_reasons_of_their_own() -> None:
    recording = Recording()
    recording.spoil("301", "c")
    kept = recording.of("301", "b")[:2]
    recording.rows = [r for r in recording.rows if r[:2] != ["301", "b"]] + kept
    with pytest.warns(rigcal.Caveat):
        rig = rigcal.calibrate(recording.cameras, recording.rows)
    out = {view.camera: view.why for view in rig.left_out}
    assert "has no pose" in out["b"]
    assert "camera c contradicts" in out["c"]


def test_one_of_two_has_the_reason_of_both() -> None:
    table = table_of(STEREO / "observations.csv")
    wrong = (table["frame"] == "05") & (table["camera"] == "left")
    table["u"][wrong] += 40
    with pytest.warns(rigcal.Caveat, match="one of the two is wrong"):
        rig = rigcal.calibrate(STEREO / "cameras.csv", table)
    assert {(v.camera, v.frame) for v in rig.left_out} == {("left", "05"), ("right", "05")}
    assert len({v.why for v in rig.left_out}) == 1


def test_the_partner_of_a_duplicate_has_its_reason() -> None:
    table = table_of(STEREO / "observations.csv")
    left = table["camera"] == "left"
    for name in "uv":
        again = table[name][left & (table["frame"] == "03")]
        table[name][left & (table["frame"] == "07")] = again
    with pytest.warns(rigcal.Caveat, match="frame 07 is a duplicate of frame 03 in camera"):
        rig = rigcal.calibrate(STEREO / "cameras.csv", table)
    out = {(view.camera, view.frame): view.why for view in rig.left_out}
    assert set(out) == {("left", "07"), ("right", "07")}
    assert all("is a duplicate" in why for why in out.values())


def test_of_many_messages_five_are_warned_of() -> None:
    table = table_of(STEREO / "observations.csv")
    with pytest.warns(rigcal.Caveat) as caught:
        rig = rigcal.calibrate(STEREO / "cameras.csv", table, sigma_px=0.1)
    assert len(caught) == 6
    assert f"and {len(rig.warnings) - 5} more" in str(caught[-1].message)
    assert caught[0].filename == __file__


def test_without_a_rig_there_is_an_error() -> None:
    recording = Recording()
    rows = [row for row in recording.rows if row[2] in ("p0", "p1")]
    with pytest.raises(rigcal.Error, match="has no pose in any frame") as error:
        rigcal.calibrate(recording.cameras, rows)
    assert str(error.value).count("\n") == 4  # five messages


def test_cameras_that_share_nothing() -> None:
    recording = Recording()
    rows = [r for r in recording.rows if (r[1] in "ab") == (int(r[0]) < 400)]
    with pytest.warns(rigcal.Caveat, match="disconnected"):
        rig = rigcal.calibrate(recording.cameras, rows)
    assert list(rig) == ["a", "b"]
    assert any("show the target to" in text for text in rig.advice)


# ---- what is known beforehand -------------------------------------------------------


def test_prior_of_a_rig_a_file_and_cameras(tmp_path: pathlib.Path) -> None:
    recording = Recording()
    before = rigcal.calibrate(recording.cameras, recording.rows, out=tmp_path / "out")
    few = [row for row in recording.rows if row[0] in ("0", "1")]
    alone = rigcal.calibrate(recording.cameras, few, sigma_px=0.3)
    known = rigcal.calibrate(recording.cameras, few, sigma_px=0.3, prior=before)
    assert "in the frame of prior" in known.report
    assert known.sigmas["b"].position < alone.sigmas["b"].position / 2
    path = tmp_path / "out" / "rig.csv"
    same = rigcal.calibrate(recording.cameras, few, sigma_px=0.3, prior=path)
    for name in NAMES:
        assert np.abs(same[name].cam_from_rig.t - known[name].cam_from_rig.t).max() < 1e-9
    held = rigcal.calibrate(
        recording.cameras, few, prior={"a": before["a"], "b": before["b"]}, hold=["a", "b"]
    )
    T, was = held.cam_from_rig("b"), before.cam_from_rig("b")
    assert np.abs(T.matrix - was.matrix).max() < 1e-12
    assert held.covariance("b").max() == 0
    assert held.covariance("c").max() > 0
    with pytest.raises(rigcal.Error, match=r"prior, row 0: camera a has no covariance"):
        rigcal.calibrate(recording.cameras, few, sigma_px=0.3, prior=before.cameras)
    with pytest.raises(rigcal.Error, match="prior needs sigma_px"):
        rigcal.calibrate(recording.cameras, few, prior=before)


LATE = {"b": 0.012, "d": -0.007}


def test_clocks() -> None:
    recording = Recording(LATE)
    told = rigcal.calibrate(recording.cameras, recording.rows, times=recording.times)
    assert told.verdict == "explained"
    assert "Most likely the clocks" in told.cause
    assert told.faults[0].name == "clocks"
    assert told.faults[0].explains
    assert told.faults[0].values[0] == pytest.approx(0.012, abs=2e-3)
    assert any("clocks" in text for text in told.advice)
    free = rigcal.calibrate(
        recording.cameras, recording.rows, times=recording.times, clocks=True
    )
    assert free.clocks["a"].state == "held"
    for name in "bcd":
        clock = free.clocks[name]
        assert clock.state == "free"
        assert clock.offset == pytest.approx(LATE.get(name, 0.0), abs=2e-3)
        assert 0 < clock.sigma_offset < 1e-3
        assert clock.paired_later == 0
    assert off_by(free)[1] < off_by(told)[1] / 3
    drift = rigcal.calibrate(
        recording.cameras, recording.rows, times=recording.times, clocks=True, drift=True,
        sigma_time=1e-4,
    )  # fmt: skip
    assert abs(drift.clocks["b"].drift) < 1e-3


def test_times_of_any_form(tmp_path: pathlib.Path) -> None:
    recording = Recording(LATE)
    rows = [(*key, value) for key, value in recording.times.items()]
    frames, cameras, times = zip(*rows)
    path = tmp_path / "times.csv"
    path.write_text(
        "\n".join(["frame,camera,time_s", *(f"{f},{c},{t!r}" for f, c, t in rows)])
    )
    forms: list[Any] = [recording.times, rows, path, str(path)]
    forms.append(dict(frame=frames, camera=cameras, time_s=times))
    reports = {
        rigcal.calibrate(recording.cameras, recording.rows, times=form, clocks=True).report
        for form in forms
    }
    assert len(reports) == 1
    by_frames = rigcal.calibrate(
        recording.cameras, recording.rows, times="frames", clocks=True
    )
    assert by_frames.clocks["b"].offset == pytest.approx(0.012 * 30, abs=0.05)


def test_estimated_intrinsics() -> None:
    recording = Recording()
    cameras = {**recording.cameras, "c": camera(fx=900.5 * 1.01, fy=905.25 * 1.01)}
    sigma = [0.01, 1e-4, 1e-3, 1e-4, 1e-4]
    rig = rigcal.calibrate(
        cameras,
        recording.rows,
        sigma_px=0.3,
        intrinsics_sigma=sigma,
        estimate_intrinsics=True,
    )
    assert abs(rig["c"].fx - 900.5) < 2.5 < abs(cameras["c"].fx - 900.5)
    assert rig["c"].size == (1280, 960)


def test_what_a_file_said_besides_is_kept() -> None:
    recording = Recording(noise=0)
    recording.cameras["b"] = camera(extra={"timeshift": 0.25})
    rig = rigcal.calibrate(recording.cameras, recording.rows)
    assert rig["b"].extra == {"timeshift": 0.25}


def test_the_files_are_kept_where_asked(tmp_path: pathlib.Path) -> None:
    out = tmp_path / "a" / "b"
    rig = rigcal.calibrate(STEREO / "cameras.csv", STEREO / "observations.csv", out=out)
    assert {"rig.csv", "rig.bin", "summary.json", "residuals.csv"} <= {
        path.name for path in out.iterdir()
    }
    again = rigcal.load(out)
    assert again.cameras == rig.cameras
    assert again.cause == rig.cause
    assert (again.residuals == rig.residuals).all()
    with pytest.raises(rigcal.Error, match="cannot write"):
        rigcal.calibrate(
            STEREO / "cameras.csv", STEREO / "observations.csv", out=out / "rig.csv"
        )


# ---- wrong input --------------------------------------------------------------------


GOOD: dict[str, Any] = {
    "frame": [1, 1, 1], "camera": ["a"] * 3, "point": [1, 2, 3],
    "X": [0.0, 1, 0], "Y": [0.0, 0, 1], "Z": [1.0] * 3, "u": [1.0, 2, 3], "v": [1.0, 2, 4],
}  # fmt: skip
WRONG: list[tuple[Any, str]] = [
    (None, "detections: .* not a NoneType"),
    (3, "detections: .* not a int"),
    (b"rows", "detections: .* not a bytes of 4|not a bytes"),
    ([], "detections: there is no row"),
    ({}, r"detections: no column frame, .* there are none"),
    (
        np.zeros((3, 7)),
        r"shape \(n, 8\), .* not an array of shape \(3, 7\) and dtype float64",
    ),
    (np.zeros(8), r"not an array of shape \(8,\)"),
    (np.zeros((0, 8)), "there is no row"),
    ([(1, 2)], r"detections\[0\]: 8 values, .* not 2"),
    ([3], r"detections\[0\]: a row is expected, not a int"),
    (["abcdefgh"], r"detections\[0\]: a row is expected"),
    ([{"frame": 1}], r"detections\[0\]: no field camera, point"),
    ({**GOOD, "u": [1.0]}, "columns of one length"),
    (
        {**GOOD, "u": [[1.0], [2], [3]]},
        r"detections\['u'\]: a column is expected, not a list",
    ),
    ({**GOOD, "u": np.zeros((3, 2))}, r"not an array of shape \(3, 2\)"),
    ({**GOOD, "u": ["1", "2", "3"]}, r"detections\['u'\]: numbers .* dtype <U1"),
    ({**GOOD, "u": [1.0, None, 3]}, r"detections\['u'\], row 1: nan is no number"),
    ({**GOOD, "u": [1.0, object(), 3]}, r"detections\['u'\]: numbers are expected"),
    ({**GOOD, "u": [1.0, np.nan, 3]}, r"detections\['u'\], row 1: nan is no number"),
    ({**GOOD, "X": [1.0, np.inf, 3]}, r"detections\['X'\], row 1: inf"),
    (
        {**GOOD, "u": np.ma.masked_array([1.0, 2, 3], mask=[0, 1, 0])},
        r"detections\['u'\]: a row is masked",
    ),
    ({**GOOD, "point": ["a", "b", "a"]}, r"detections, row 2: point a .* in row 0 already"),
    ({**GOOD, "u": [1 + 2j, 2, 3]}, r"detections\['u'\]: numbers .* complex128"),
    ({**GOOD, "u": [True, False, True]}, r"detections\['u'\]: numbers .* bool"),
    ({**GOOD, "frame": [1.5, 1, 1]}, r"detections\['frame'\], row 0: a name .* not 1.5"),
    ({**GOOD, "frame": [None, 1, 1]}, r"detections\['frame'\], row 0: a name .* not None"),
    ({**GOOD, "frame": [np.nan, 1, 1]}, r"detections\['frame'\], row 0"),
    ({**GOOD, "frame": [True, False, True]}, r"detections\['frame'\], row 0: .* not True"),
    (
        {**GOOD, "point": ["a b", "c", "d"]},
        r"detections\['point'\], row 0: .*blanks.*'a b'",
    ),
    ({**GOOD, "point": ["a", "", "d"]}, r"detections\['point'\], row 1"),
    ({**GOOD, "point": ["a", 'b"', "d"]}, r"detections\['point'\], row 1"),
    ({**GOOD, "point": ["a", "b,", "d"]}, r"detections\['point'\], row 1"),
    ({**GOOD, "point": ["a", "b\x01", "d"]}, r"detections\['point'\], row 1: .*control"),
    ({**GOOD, "point": {1: 2}}, r"detections\['point'\]: a column is expected"),
    ({**GOOD, "point": [[1], [2], [3, 4]]}, r"detections\['point'\]"),
    ({**GOOD, "camera": ["z"] * 3}, "detections, row 0: camera z is not in cameras"),
    ({**GOOD, "X": [0.0, 1e300, 0]}, "has no pose in frame 1 because of point 2"),
    ("nowhere.csv", "nowhere.csv: there is no such file"),
]


@pytest.mark.parametrize("case", range(len(WRONG)))
def test_wrong_detections_are_named(case: int) -> None:
    detections, text = WRONG[case]
    with pytest.raises(rigcal.Error, match=text) as error:
        rigcal.calibrate({"a": camera(), "b": camera()}, detections)
    assert "/rigcal-" not in str(error.value)


@pytest.mark.parametrize(
    ("cameras", "text"),
    [
        (None, "cameras: cameras by name are expected, not a NoneType"),
        ({}, "cameras: there is no camera"),
        ([], "cameras: there is no camera"),
        ({"a": 3}, r"cameras\['a'\]: a Camera is expected, not a int"),
        ({3: camera()}, r"cameras\[3\]: a Camera is expected"),
        ([camera(name="x"), camera(name="x")], "cameras: two cameras have the same name"),
        ({"a b": camera()}, "cameras: 'a b': a name without commas"),
        ({"a": camera(size=None)}, "cameras: .*size"),
        ("nowhere.yaml", "nowhere.yaml: "),
        (b"x", "cameras: .* not a bytes"),
    ],
)
def test_wrong_cameras_are_named(cameras: Any, text: str) -> None:
    with pytest.raises(rigcal.Error, match=text):
        rigcal.calibrate(cameras, GOOD)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"sigma_px": -1}, "sigma_px is from"),
        ({"sigma_px": "x"}, "sigma_px: a number is expected, not 'x'"),
        ({"sigma_px": [1, 2]}, "sigma_px: a number is expected"),
        ({"sigma_px": np.nan}, "sigma_px: a number is expected"),
        ({"threshold_px": 1}, "threshold_px and seed go with robust"),
        ({"robust": True, "seed": 1.5}, "seed is a whole number"),
        ({"robust": True, "threshold_px": 0}, "threshold_px is from"),
        ({"clocks": True}, "clocks goes with times"),
        ({"hold": "x"}, "hold x: this camera is not in cameras"),
        ({"hold": 3}, "hold: names of cameras are expected, not int"),
        ({"hold": None}, "hold: names of cameras are expected, not NoneType"),
        ({"robust": "no"}, "robust: True or False is expected, not str"),
        ({"estimate_intrinsics": None}, "estimate_intrinsics: True or False"),
        ({"out": 3}, "out: a path is expected, not int"),
        ({"method": "best"}, 'method is ml or paper, not "best"'),
        ({"intrinsics_sigma": 3}, "intrinsics_sigma: five numbers"),
        ({"intrinsics_sigma": ["a"] * 5}, "intrinsics_sigma: five numbers"),
        ({"intrinsics_sigma": {"f": 3}}, "intrinsics_sigma: .* are known, not .*'f'"),
        ({"intrinsics_sigma": [9, 0, 0, 0, 0]}, "intrinsics_sigma 9.0,"),
        ({"estimate_intrinsics": True}, "estimate_intrinsics goes with intrinsics_sigma"),
        ({"times": {("1", "a"): "x"}}, r"times\['time_s'\]: numbers"),
        ({"times": {("1", "b"): 1.0}}, "times has no time of camera a in frame 1"),
        ({"times": {("1",): 1.0}}, r"times\[0\]: 3 values"),
        ({"times": "nowhere.csv"}, "nowhere.csv: there is no such file"),
        ({"prior": 3}, "prior: cameras by name are expected"),
        ({"prior": {"a": camera()}}, "prior: no camera of it has a pose"),
    ],
)
def test_wrong_options_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(rigcal.Error, match=text):
        rigcal.calibrate({"a": camera(), "b": camera()}, GOOD, **options)


def test_a_wrong_option_is_named_although_something_else_was_said_before() -> None:
    outside = {**GOOD, "u": [9999.0, 1, 2]}
    with pytest.raises(rigcal.Error, match=r"^clocks goes with times"):
        rigcal.calibrate({"a": camera(), "b": camera()}, outside, clocks=True)


def complaint(call: Any, *arguments: Any) -> str | None:
    """The text of its Error; None: there is none."""
    try:
        call(*arguments)
    except rigcal.Error as error:
        return str(error)
    return None


ANYTHING = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3),
    st.binary(max_size=3), st.complex_numbers(), st.lists(st.floats(), max_size=3),
)  # fmt: skip
ARRAYS = st.builds(
    lambda shape, kind: np.zeros(shape, kind),
    st.lists(st.integers(0, 4), max_size=3),
    st.sampled_from(
        ["f8", "f4", "f2", "i1", "u8", "?", "c16", "U3", "S2", "O", "M8[s]", ">f8"]
    ),
)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    name=st.sampled_from(COLUMNS),
    column=st.one_of(ARRAYS, st.lists(ANYTHING, min_size=3, max_size=3), ANYTHING),
)
def test_no_column_crashes(name: str, column: Any) -> None:
    """The error names a wrong column. The rest is left to the program."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        error = complaint(_tables.columns, {**GOOD, name: column}, COLUMNS, "detections")
    assert error is None or ("detections" in error and name in error)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    table=st.one_of(
        ANYTHING,
        ARRAYS,
        st.lists(st.lists(ANYTHING, max_size=9), max_size=3),
        st.dictionaries(st.sampled_from(COLUMNS), ANYTHING),
    )
)
def test_no_table_crashes(table: Any) -> None:
    error = complaint(_tables.columns, table, COLUMNS, "detections")
    assert error is None or error.startswith("detections")


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    numbers=st.lists(
        st.floats(allow_nan=False, allow_infinity=False), min_size=9, max_size=9
    ),
    names=st.lists(st.text(min_size=1, max_size=4), min_size=3, max_size=3),
)
def test_no_numbers_and_names_crash_the_program(
    numbers: list[float], names: list[str]
) -> None:
    table = {**GOOD, "X": numbers[:3], "u": numbers[3:6], "v": numbers[6:], "point": names}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        error = complaint(rigcal.calibrate, {"a": camera()}, table)
    assert error is None or "status -" not in error  # no signal ended it


def test_names_of_any_script() -> None:
    recording = Recording(noise=0)
    name = "\u30ab\u30e1\u30e9-\u00e9\\'"[:-1]
    cameras = {name if k == "a" else k: c for k, c in recording.cameras.items()}
    rows = [[r[0], name if r[1] == "a" else r[1], *r[2:]] for r in recording.rows]
    rig = rigcal.calibrate(cameras, rows)
    assert next(iter(rig)) == name
    assert rig.residuals["camera"][0] == name


def test_many_detections() -> None:
    recording = Recording(noise=0)
    rows = [
        [f"{seed}-{r[0]}", *r[1:]]
        for seed in range(30)
        for r in Recording(noise=0, seed=seed).rows
    ]
    assert len(rows) == 57600
    rig = rigcal.calibrate(recording.cameras, rows)
    assert len(rig.residuals) == len(rows)
    assert max(off_by(rig)) < 1e-8


# ---- progress, and the program ----------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    files = STEREO / "cameras.csv", STEREO / "observations.csv"
    lines: list[str] = []
    rigcal.calibrate(*files, progress=lines.append)
    assert [x for x in lines if x.startswith("view ")] == [
        f"view {k} of 14" for k in range(1, 15)
    ]
    assert any("adjusting the rig" in text for text in lines)
    rigcal.calibrate(*files)
    rigcal.calibrate(*files, progress=True)  # shorter than a second
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(_Bar, "WAIT", 0.0)
    monkeypatch.setattr(_Bar, "EVERY", 0.0)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    rigcal.calibrate(*files)
    shown = terminal.getvalue()
    assert "\rrigcal [############............] view 7 of 14" in shown
    assert shown.endswith("\r")
    assert not shown.split("\r")[-2].strip()
    rigcal.calibrate(*files, progress=False)
    assert terminal.getvalue() == shown
    monkeypatch.setattr(sys, "stderr", None)
    rigcal.calibrate(*files)


def test_what_interrupts_the_progress_ends_the_program() -> None:
    started: list[subprocess.Popen[bytes]] = []

    class Watched(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)

    def interrupt(text: str) -> None:
        raise KeyboardInterrupt

    patch = pytest.MonkeyPatch()
    patch.setattr(Module.subprocess, "Popen", Watched)
    with patch.context(), pytest.raises(KeyboardInterrupt):
        rigcal.calibrate(
            STEREO / "cameras.csv", STEREO / "observations.csv", progress=interrupt
        )
    patch.undo()
    assert started[0].returncode is not None


def test_a_program_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGCAL_PROGRAM", "/nowhere/rigcal")
    with pytest.raises(rigcal.Error, match="the program rigcal cannot be run"):
        rigcal.calibrate({"a": camera()}, GOOD)
    monkeypatch.delenv("RIGCAL_PROGRAM")
    monkeypatch.setattr(rigcal._library, "FOLDER", pathlib.Path("/nowhere"))
    with pytest.raises(rigcal.Error, match="is not there"):
        rigcal.calibrate({"a": camera()}, GOOD)


def test_a_program_that_dies(
    monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path
) -> None:
    if sys.platform == "win32":
        pytest.skip("needs a shell")
    script = tmp_path / "rigcal"
    script.write_text("#!/bin/sh\nkill -9 $$\n")
    script.chmod(0o755)
    monkeypatch.setenv("RIGCAL_PROGRAM", str(script))
    with pytest.raises(rigcal.Error, match="the program ended with status -9"):
        rigcal.calibrate({"a": camera()}, GOOD)


def test_rows_of_the_files_of_a_run() -> None:
    assert len(rows_of(STEREO / "observations.csv")) == 756
