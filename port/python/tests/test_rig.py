"""The rig that calibrate returns: what it holds, measures, saves and loads."""

from __future__ import annotations

import csv
import json
import pathlib
import pickle
import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from cli_scenes import DATA, POSES, SETS, STEREO, Recording, project, rotation, rows_of

import rigcal
from rigcal.calibrate import program


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return tmp_path_factory.mktemp("rig") / "out"


@pytest.fixture(scope="module")
def rig(folder: pathlib.Path) -> rigcal.Rig:
    return rigcal.calibrate(STEREO / "cameras.csv", STEREO / "observations.csv", out=folder)


@pytest.fixture(scope="module")
def four() -> rigcal.Rig:
    recording = Recording()
    return rigcal.calibrate(recording.cameras, recording.rows)


def run(*arguments: str) -> list[dict[str, str]]:
    """The CSV that the program prints."""
    output = subprocess.run(
        [program(), *arguments], capture_output=True, text=True, check=True
    ).stdout
    return list(csv.DictReader(output.splitlines()))


def numbers(row: dict[str, str], keys: list[str]) -> Any:
    return np.array([float(row[key]) for key in keys])


ENTRIES = [(i, j) for i in range(6) for j in range(i + 1)]
R_KEYS = [f"R{i}{j}" for i in "123" for j in "123"]
T_KEYS = ["tx", "ty", "tz"]


# ---- what it holds --------------------------------------------------------------


def test_it_is_a_collection_of_cameras(rig: rigcal.Rig) -> None:
    assert list(rig) == ["left", "right"]
    assert len(rig) == 2
    assert "left" in rig
    assert "middle" not in rig
    assert repr(rig) == "Rig(left, right)"
    assert rig["right"] is rig.cameras["right"]
    with pytest.raises(rigcal.Error, match="there is no camera 'middle' in this rig: left"):
        rig["middle"]


def test_poses_and_covariances_are_those_of_the_files(
    rig: rigcal.Rig, folder: pathlib.Path
) -> None:
    for row in rows_of(folder / "rig.csv"):
        T = rig.cam_from_rig(row["camera"])
        assert T.R.ravel() == pytest.approx(numbers(row, R_KEYS), abs=1e-11)
        assert T.t == pytest.approx(numbers(row, T_KEYS), abs=1e-11)
        assert (T.to, T.frm) == (row["camera"], "rig")
        Sigma = rig.covariance(row["camera"])
        for i, j in ENTRIES:
            entry = pytest.approx(float(row[f"S{i + 1}{j + 1}"]), rel=1e-9)
            assert Sigma[i, j] == entry
            assert Sigma[j, i] == entry
        assert rig.sigmas[row["camera"]].position == float(row["sigma_pos"])
    (row,) = rows_of(folder / "pairs.csv")
    pair = rig.pair("left", "right")
    assert pair.transform.R.ravel() == pytest.approx(numbers(row, R_KEYS), abs=1e-11)
    assert pair.covariance is not None
    assert pair.covariance[3, 3] == pytest.approx(float(row["S44"]), rel=1e-9)


def test_between(four: rigcal.Rig) -> None:
    T = four.between("d", "b")
    assert (T.to, T.frm) == ("d", "b")
    R = POSES["d"][0] @ POSES["b"][0].T
    assert np.abs(T.R - R).max() < 1e-2
    assert np.abs(T.t - (POSES["d"][1] - R @ POSES["b"][1])).max() < 5e-3
    assert np.abs((T @ four.between("b", "d")).matrix - np.eye(4)).max() < 1e-12
    assert np.abs(four.pair("b", "d").transform.matrix - T.matrix).max() < 1e-9


def test_the_joint_covariance(four: rigcal.Rig) -> None:
    joint = four.joint_covariance
    assert joint.shape == (24, 24)
    assert np.abs(joint - joint.T).max() == 0
    assert np.linalg.eigvalsh(joint[6:, 6:]).min() > 0
    assert np.abs(joint[:6]).max() == 0  # a is the frame
    assert (joint[12:18, 6:12] == four.covariance("c", "b")).all()
    # The covariance of a pair follows from it: that of c_from_b, by poses that are moved a
    # little.
    pair = four.pair("b", "c")
    J = np.zeros((6, 12))
    step = 1e-6
    for k in range(12):
        moved = []
        for name, d in (("b", np.eye(12)[k, :6]), ("c", np.eye(12)[k, 6:])):
            T = four.cam_from_rig(name)
            moved.append((rotation(*(step * d[:3])) @ T.R, T.t + step * d[3:]))
        (Rb, tb), (Rc, tc) = moved
        R = Rc @ Rb.T
        turn = R @ pair.transform.R.T
        J[:3, k] = turn[2, 1], turn[0, 2], turn[1, 0]
        J[3:, k] = tc - R @ tb - pair.transform.t
    J /= step
    assert pair.covariance is not None
    expected = J @ joint[6:18, 6:18] @ J.T
    assert np.abs(pair.covariance - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.parametrize("name", SETS)
def test_residuals_are_those_of_the_report(name: str) -> None:
    rig = rigcal.calibrate(DATA / name / "cameras.csv", DATA / name / "observations.csv")
    r = rig.residuals
    observed = {
        (o["camera"], o["frame"], o["point"]): (float(o["u"]), float(o["v"]))
        for o in rows_of(DATA / name / "observations.csv")
    }
    places = {
        (o["camera"], o["frame"], o["point"]): [float(o[k]) for k in "XYZ"]
        for o in rows_of(DATA / name / "observations.csv")
    }
    assert len(r) == len(observed)
    for view, row in enumerate(rig.views):
        own = r[r["view"] == view]
        keys = [(row["camera"], row["frame"], p) for p in own["point"]]
        X = np.array([places[key] for key in keys])
        T = rig.cam_from_rig(row["camera"]) @ rig.targets[row["frame"]]
        seen = rigcal.project(rig[row["camera"]], T.apply(X)).uv
        du = np.array([observed[key] for key in keys]) - seen
        assert np.abs(du - np.column_stack([own["du"], own["dv"]])).max() < 1e-6
        rms = np.sqrt((own["error_px"] ** 2).mean())
        words = [text.split() for text in rig.report.splitlines()]
        head = [row["camera"], row["frame"], str(row["n"])]
        (line,) = (line for line in words if line[:3] == head)
        assert line[3:5] == [f"{row['rms_px']:.3f}", f"{rms:.3f}"]


def test_what_is_not_known_is_none() -> None:
    rig = rigcal.calibrate(
        DATA / "openptv_cavity" / "cameras.csv",
        DATA / "openptv_cavity" / "observations.csv",
    )
    assert (rig.F, rig.sqrt_f, rig.verdict, rig.cause) == (None, None, None, "")
    assert rig.advice == ["show the target to cam2 and cam4 together in more places"]
    assert all(np.isnan(fault.p) or fault.p >= 0 for fault in rig.faults)


def test_the_verdict(rig: rigcal.Rig) -> None:
    assert rig.verdict == "found"
    assert rig.cause in rig.report
    assert rig.sqrt_f == pytest.approx(2.0, abs=0.01)
    assert pytest.approx(4.0, abs=0.02) == rig.F
    assert rig.sigma_px == pytest.approx(0.1526, abs=1e-4)
    assert rig.noise_px == pytest.approx(0.1473, abs=1e-4)
    lens, more = rig.advice
    assert lens == "check the lens model, the board's coordinates and the detector"
    # With two cameras both have the same sigma. Rounding decides which is named first.
    pairs = ("right and left", "left and right")
    assert more in [f"show the target to {pair} together in more places" for pair in pairs]
    bent = rig.faults[0]
    assert (bent.name, bent.explains, len(bent.values)) == ("bent", False, 2)


# ---- what it measures, beside the program -----------------------------------------


def seen_in(frame: str) -> tuple[list[str], dict[str, Any]]:
    rows = [r for r in rows_of(STEREO / "observations.csv") if r["frame"] == frame]
    points = sorted({r["point"] for r in rows})
    uv = {
        name: np.array(
            [[float(r["u"]), float(r["v"])] for p in points for r in rows
             if r["camera"] == name and r["point"] == p]
        )
        for name in ("left", "right")
    }  # fmt: skip
    return points, uv


def test_triangulate(rig: rigcal.Rig, folder: pathlib.Path) -> None:
    points, uv = seen_in("03")
    found = rig.triangulate(uv)
    rows = {
        r["point"]: r
        for r in run(
            "triangulate", f"--cameras={STEREO / 'cameras.csv'}",
            f"--rig={folder / 'rig.csv'}", f"--observations={STEREO / 'observations.csv'}",
        )
        if r["frame"] == "03"
    }  # fmt: skip
    assert len(rows) == 54
    for k, point in enumerate(points):
        assert found.X[k] == pytest.approx(numbers(rows[point], ["X", "Y", "Z"]), abs=1e-9)
        assert np.sqrt(np.diag(found.Sigma[k])) == pytest.approx(
            numbers(rows[point], ["sigma_X", "sigma_Y", "sigma_Z"]), rel=1e-6
        )
    wider = rig.triangulate(uv, sigma_px=1.0)
    assert (wider.Sigma[:, 2, 2] > found.Sigma[:, 2, 2]).all()


def test_match_line_band_and_spans(rig: rigcal.Rig, folder: pathlib.Path) -> None:
    rows = run(
        "line", f"--cameras={STEREO / 'cameras.csv'}", f"--rig={folder / 'rig.csv'}",
        "--from=left", "--to=right", "--pixel=300,200", "--probability=0.95",
    )  # fmt: skip
    curve = rig.match_line("left", [[300, 200]], "right", n=17, probability=0.95)
    band = [r for r in rows if r["quantity"] == "band"]
    assert curve.uv[0, : len(band)] == pytest.approx(
        np.array([numbers(r, ["v1", "v2"]) for r in band]), abs=1e-6
    )
    assert curve.half_width[0, : len(band)] == pytest.approx(
        np.array([float(r["v3"]) for r in band]), rel=1e-6
    )
    spans = rig.spans("left", [[300, 200]], "right", probability=0.95)
    expected = [
        [int(float(r[k])) for k in ("v1", "v2", "v3")]
        for r in rows
        if r["quantity"] == "span"
    ]
    assert spans[0].tolist() == expected
    bands = rig.band("left", [[300, 200]], "right", probability=0.95)
    assert len(bands) == 1


def test_transfer(four: rigcal.Rig) -> None:
    X = np.array([[0.05, 0.02, 0.9], [-0.1, 0.1, 1.1]])
    found = four.transfer("a", project(X, "a"), "b", project(X, "b"), "c")
    assert np.abs(found.uv - project(X, "c")).max() < 2


def test_monitor(four: rigcal.Rig) -> None:
    rng = np.random.default_rng(1)
    monitor = four.monitor()
    for _ in range(10):
        X = rng.uniform([-0.2, -0.2, 0.8], [0.2, 0.2, 1.2], (30, 3))
        monitor.add_matches("a", project(X, "a"), "b", project(X, "b"))
        monitor.add_matches("c", project(X, "c"), "d", project(X, "d"))
        report = monitor.end_frame(seconds=0.1)
    assert not report.alarm
    assert report.frames == 10


# ---- files -------------------------------------------------------------------------


def test_stored_bytes(
    rig: rigcal.Rig, folder: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    rig.save(tmp_path / "x.bin")
    assert (tmp_path / "x.bin").read_bytes() == (folder / "rig.bin").read_bytes()
    rig.save(tmp_path / "x.rigcal", "stored")
    rig.save(folder / "x.bin")
    for path, names, known in (
        (tmp_path / "x.bin", None, ["cam0", "cam1"]),
        (folder / "x.bin", None, ["cam0", "cam1"]),  # the rig.csv there may be of another
        (tmp_path / "x.rigcal", ["l", "r"], ["l", "r"]),
        (folder / "rig.bin", None, ["left", "right"]),
    ):
        again = rigcal.load(path, names)
        assert list(again) == known
        assert (again.joint_covariance == rig.joint_covariance).all()
        assert (
            again[known[1]].cam_from_rig.t.tolist() == rig.cam_from_rig("right").t.tolist()
        )
        assert again.report == ""
        assert str(again) == repr(again)
        assert len(again.residuals) == len(again.views) == 0
    with pytest.raises(rigcal.Error, match="names: 2 are expected, not 1"):
        rigcal.load(tmp_path / "x.bin", ["l"])
    data = bytearray((tmp_path / "x.bin").read_bytes())
    data[100] ^= 1
    (tmp_path / "y.bin").write_bytes(data)
    with pytest.raises(rigcal.FileError, match=r"y\.bin: .*altered"):
        rigcal.load(tmp_path / "y.bin")
    again = rigcal.load(folder / "rig.bin")
    _, uv = seen_in("03")
    assert np.abs(again.triangulate(uv).X - rig.triangulate(uv).X).max() < 1e-6


def test_a_folder(rig: rigcal.Rig, folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    again = rigcal.load(folder)
    assert again.cameras == rig.cameras
    assert again.sigmas == rig.sigmas
    assert again.noise_px == rig.noise_px
    (tmp_path / "summary.json").write_text("{")
    with pytest.raises(rigcal.FileError, match=r"summary\.json: this is no summary"):
        rigcal.load(tmp_path)
    (tmp_path / "summary.json").unlink()
    with pytest.raises(rigcal.FileError, match=r"summary\.json: No such file"):
        rigcal.Rig.from_folder(tmp_path)
    with pytest.raises(rigcal.FileError):
        rigcal.load(tmp_path)


DAMAGES = {
    "empty": lambda text: "",
    "cut off": lambda text: text[: len(text) // 2],
    "another table": lambda text: "a,b\n1,2\n",
    "a number that is none": lambda text: text.replace("0.", "0x"),
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize(
    "name",
    ["rig.csv", "poses.csv", "targets.csv", "residuals.csv", "faults.csv", "summary.json"],
)
def test_a_damaged_file_of_a_folder_is_named(
    folder: pathlib.Path, tmp_path: pathlib.Path, name: str, damage: str
) -> None:
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / name).write_text(DAMAGES[damage]((folder / name).read_text()))
    with pytest.raises(rigcal.FileError, match=re.escape(name)):
        rigcal.load(tmp_path)


def test_a_summary_without_its_keys_is_named(
    folder: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    del summary["findings"]
    for content, text in ((summary, "there is no findings"), (3, "this is no summary")):
        (tmp_path / "summary.json").write_text(json.dumps(content))
        with pytest.raises(rigcal.FileError, match=rf"summary\.json: {text}"):
            rigcal.load(tmp_path)


@pytest.mark.parametrize("name", ["Calib.toml", "stereo.xml", "transforms.json"])
def test_other_formats(rig: rigcal.Rig, tmp_path: pathlib.Path, name: str) -> None:
    rig.save(tmp_path / name)
    again = rigcal.load(tmp_path / name)
    assert list(again) == ["left", "right"]
    assert (
        np.abs(again.between("right", "left").t - rig.between("right", "left").t).max()
        < 1e-9
    )
    with pytest.raises(rigcal.Error, match="noise"):
        again.triangulate(seen_in("03")[1])
    assert np.isfinite(again.triangulate(seen_in("03")[1], sigma_px=0.2).X).all()


def test_files_that_are_no_rig(rig: rigcal.Rig, tmp_path: pathlib.Path) -> None:
    with pytest.raises(rigcal.FileError, match="no camera in it has a pose"):
        rigcal.load(STEREO / "cameras.csv")
    with pytest.raises(rigcal.FileError, match="nowhere"):
        rigcal.load(tmp_path / "nowhere.bin")
    with pytest.raises(rigcal.FileError, match="nowhere"):
        rig.save(tmp_path / "nowhere" / "x.bin")
    with pytest.raises(rigcal.Error, match="format"):
        rig.save(tmp_path / "x.unknown")


def test_cameras_are_stored_and_loaded_by_the_formats(
    rig: rigcal.Rig, tmp_path: pathlib.Path
) -> None:
    rigcal.save_cameras(tmp_path / "x.bin", rig.cameras)
    again = rigcal.load_cameras(tmp_path / "x.bin")
    assert list(again) == ["cam0", "cam1"]
    assert again["cam1"].dist == rig["right"].dist
    assert (rigcal.load(tmp_path / "x.bin")["cam1"].cam_from_rig.R
            == rig.cam_from_rig("right").R).all()  # fmt: skip


def test_a_rig_can_be_pickled(rig: rigcal.Rig, tmp_path: pathlib.Path) -> None:
    again = pickle.loads(pickle.dumps(rig))
    assert again.cameras == rig.cameras
    assert (again.joint_covariance == rig.joint_covariance).all()
    (tmp_path / "rig.pickle").write_bytes(pickle.dumps(rig))
    script = (
        "import pickle, sys; rig = pickle.load(open(sys.argv[1], 'rb'));"
        "print(repr(float(rig.joint_covariance.sum())))"
    )
    other = subprocess.run(  # a process in which no address of this one is valid
        [sys.executable, "-c", script, str(tmp_path / "rig.pickle")],
        capture_output=True, text=True, check=True, cwd=tmp_path,
    )  # fmt: skip
    assert float(other.stdout) == rig.joint_covariance.sum()
