"""The fleet of make_sample.py, against its truth: by a loop, by Dask, by Spark."""

from __future__ import annotations

import itertools
import os
import pathlib
import signal
from typing import Any

import fleet
import make_sample
import numpy as np
import pandas as pd
import pytest
import rigcal

BUCKETS = 6


@pytest.fixture(scope="session")
def sample(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder: pathlib.Path = tmp_path_factory.mktemp("sample")
    make_sample.make(folder, rigs=24, places=6, seed=1)
    return folder


def evening(sample: pathlib.Path, number: int, out: Any, **how: Any) -> pathlib.Path:
    """Calibrates an evening into files, with any engine."""
    detections, cameras = sample / f"evening{number}", sample / "cameras.parquet"
    assert not fleet.run(str(detections), str(cameras), str(out), buckets=BUCKETS, **how)
    return pathlib.Path(out)


@pytest.fixture(scope="session")
def first(sample: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return evening(sample, 1, tmp_path_factory.mktemp("first"))


@pytest.fixture(scope="session")
def second(
    sample: pathlib.Path, first: pathlib.Path, tmp_path_factory: pytest.TempPathFactory
) -> pathlib.Path:
    return evening(sample, 2, tmp_path_factory.mktemp("second"), last=str(first))


@pytest.fixture(scope="session")
def rows(second: pathlib.Path) -> pd.DataFrame:
    return pd.read_parquet(second)


@pytest.fixture(scope="session")
def truth(sample: pathlib.Path) -> pd.DataFrame:
    return pd.read_parquet(sample / "truth.parquet")


def bytes_of(folder: pathlib.Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


# ---- what comes out ----------------------------------------------------------


def test_every_camera_of_every_rig_has_one_row(
    rows: pd.DataFrame, truth: pd.DataFrame
) -> None:
    assert not rows.duplicated(["rig", "camera"]).any()
    expected = set(zip(truth.rig, truth.camera))
    more = {("rig00006", "webcam"), ("rig00017", "cam 0, left")}
    assert set(zip(rows.rig, rows.camera)) == expected | more


def test_broken_rigs_are_rows_that_say_why(rows: pd.DataFrame, truth: pd.DataFrame) -> None:
    broken = truth[truth.broken != ""].groupby("rig").broken.first()
    said = {
        "nan": "detections['u'], row 27: nan is no number",
        "unknown camera": "camera webcam is not in cameras",
        "one camera": "camera cam1 is not in the rig: there are no observations of it",
        "no intrinsics": "cameras: there is no camera",
        "text": "a name without commas, blanks and quotes is expected, not 'cam 0, left'",
        "garbage": "camera cam0 is not in the rig: it has no pose in any frame",
    }
    assert set(broken) == set(said)
    for rig, kind in broken.items():
        theirs = rows[rows.rig == rig]
        assert theirs.reason.str.contains(said[kind], regex=False).all(), kind
        assert set(theirs.verdict) == {"no verdict" if kind == "one camera" else "failed"}
        assert theirs.moved.isna().all()
    others = rows[~rows.rig.isin(broken.index)]
    assert set(others.verdict) == {"agrees"}


def test_a_rig_that_failed_keeps_its_last_extrinsics(
    rows: pd.DataFrame, first: pathlib.Path
) -> None:
    before = pd.read_parquet(first).groupby("rig").stored.first()
    for rig in ("rig00001", "rig00006", "rig00009", "rig00017", "rig00021"):
        assert (rows[rows.rig == rig].stored == before[rig]).all()
    assert rows[rows.rig == "rig00014"].stored.isna().all()  # never had any
    assert not (rows[rows.rig == "rig00000"].stored == before["rig00000"]).any()


def test_poses_are_as_far_from_the_truth_as_their_sigmas_say(
    rows: pd.DataFrame, truth: pd.DataFrame
) -> None:
    both = rows[rows.verdict == "agrees"].merge(truth, on=["rig", "camera"])
    turns, shifts = [], []
    for _, rig in both.groupby("rig"):
        origin = rig.iloc[0]
        for _, row in rig.iloc[1:].iterrows():
            R = row.R.reshape(3, 3) @ origin.R.reshape(3, 3).T
            true = rigcal.Transform(R, row.t - R @ origin.t)
            found = rigcal.Transform.from_rvec(
                row[["rx", "ry", "rz"]], row[["tx", "ty", "tz"]]
            )
            off = np.degrees(np.linalg.norm((found @ true.inv()).rvec))
            turns.append(off / row.sigma_rotation_deg)
            shifts.append(np.linalg.norm(found.center - true.center) / row.sigma_position)
    assert len(turns) == 37
    # The mean square is 1; of 37 with three numbers each its sigma is below 0.16.
    for ratios in (turns, shifts):
        assert 0.5 < np.mean(np.square(ratios)) < 1.6


def test_the_cameras_that_got_a_knock_moved_by_as_much(
    rows: pd.DataFrame, truth: pd.DataFrame
) -> None:
    both = rows[rows.verdict == "agrees"].merge(
        truth, on=["rig", "camera"], suffixes=("", "_true")
    )
    cameras = both.groupby("rig").camera.transform("size")
    more = both[cameras > 2]
    assert more.moved_true.sum() == 4
    assert (more.moved == more.moved_true).all()
    hit = both[both.moved_true]
    assert (abs(hit.turn_deg - make_sample.TURN) < 4 * hit.sigma_turn_deg).all()
    assert (abs(hit["shift"] - make_sample.SHIFT) < 4 * hit.sigma_shift).all()
    assert (hit.sigma_turn_deg < 0.1).all()
    assert (hit.sigma_shift < 0.002).all()
    stayed = both[~both.moved_true & (both.stayed != both.camera)]
    assert stayed.p.between(0.001, 1).all()


def test_of_two_cameras_none_can_say_which_moved(rows: pd.DataFrame) -> None:
    pair = rows[rows.rig == "rig00003"]
    assert pair.moved.tolist() == [True, True]
    assert pair.reason.str.contains("cam0 or cam1 moved, or both").all()


def test_the_camera_whose_frame_is_the_rig_can_be_the_one_that_moved(
    sample: pathlib.Path, first: pathlib.Path
) -> None:
    """The result for cam0 of a rig of four whose other cameras stayed."""
    rng = np.random.default_rng([1, 2])
    rig = make_sample.make_rig(rng, 4)
    list(make_sample.record(rig, 6, rng))
    make_sample.knock(rig["cam0"], rng)
    rows = pd.DataFrame(make_sample.record(rig, 6, rng)).assign(rig="rig00002")
    cameras = str(sample / "cameras.parquet")
    found = fleet.calibrate_rows(rows, cameras, str(first)).set_index("camera")
    assert found.moved.tolist() == [True, False, False, False]
    assert set(found.stayed) == {"cam1"}
    assert abs(found.turn_deg["cam0"] - make_sample.TURN) < 4 * found.sigma_turn_deg["cam0"]


def test_the_chance_of_a_change_is_that_of_six_numbers() -> None:
    sums = np.random.default_rng(3).chisquare(6, 200000)
    for limit in (1.0, 5.0, 12.0, 20.0):
        assert fleet.chance_above(limit) == pytest.approx((sums > limit).mean(), abs=0.004)


def test_the_sigma_of_a_change_is_that_of_many_evenings(sample: pathlib.Path) -> None:
    """Draws of both poses from their covariances, moved by hand."""
    cameras = str(sample / "cameras.parquet")
    rows = pd.concat(
        fleet.rows_of(str(sample / f"evening{k}"), ["rig00002"]).assign(rig=k)
        for k in (1, 2)
    )
    intrinsics = fleet.rows_of(cameras, ["rig00002"])
    now, before = (
        fleet.calibrated(fleet.in_order(rows[rows.rig == k]), intrinsics).pair(
            "cam1", "cam3"
        )
        for k in (1, 2)
    )
    rng = np.random.default_rng(4)
    centres = []
    for _ in range(4000):
        centre = []
        for pair in (now, before):
            step = rng.multivariate_normal(np.zeros(6), pair.covariance)
            turn = rigcal.Transform.from_rvec(step[:3], np.zeros(3))
            t = pair.transform.t + step[3:]
            centre.append(-(turn.R @ pair.transform.R).T @ t)
        centres.append(centre[0] - centre[1])
    found = fleet.change(now, before)
    way = now.transform.center - before.transform.center
    spread = np.std(np.array(centres) @ (way / np.linalg.norm(way)))
    assert found["sigma_shift"] == pytest.approx(spread, rel=0.05)
    assert found["shift"] == pytest.approx(np.linalg.norm(way))


# ---- how it runs -------------------------------------------------------------


def test_a_repeated_run_writes_nothing(
    sample: pathlib.Path, first: pathlib.Path, second: pathlib.Path, monkeypatch: Any
) -> None:
    before = {path: path.stat().st_mtime_ns for path in second.iterdir()}
    monkeypatch.setattr(fleet, "calibrated", None)  # nothing is calibrated
    evening(sample, 2, second, last=str(first))
    assert {path: path.stat().st_mtime_ns for path in second.iterdir()} == before


def test_a_run_that_ended_in_the_middle_goes_on(
    sample: pathlib.Path, second: pathlib.Path, first: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    def stop(bucket: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        evening(sample, 2, tmp_path / "out", last=str(first), wrote=stop)
    (tmp_path / "out" / ".bucket-0001-of-0006.parquet.1").write_bytes(b"half")
    assert len(bytes_of(tmp_path / "out")) == 2
    out = evening(sample, 2, tmp_path / "out", last=str(first))
    (out / ".bucket-0001-of-0006.parquet.1").unlink()
    assert bytes_of(out) == bytes_of(second)


def test_only_rigs_with_new_detections_are_calibrated(
    sample: pathlib.Path, first: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: Any
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for name, data in bytes_of(first).items():
        (out / name).write_bytes(data)
    for path in (sample / "evening1").iterdir():
        (tmp_path / "evening1").mkdir(exist_ok=True)
        (tmp_path / "evening1" / path.name).write_bytes(path.read_bytes())
    rows = fleet.rows_of(str(sample / "evening1"), ["rig00005"])
    rows.assign(frame="later").to_parquet(
        tmp_path / "evening1" / "late.parquet", index=False
    )
    asked = []

    def calibrated(rows: pd.DataFrame, intrinsics: pd.DataFrame) -> Any:
        asked.append(rows.rig.iloc[0])
        raise rigcal.Error("not tonight")

    monkeypatch.setattr(fleet, "calibrated", calibrated)
    (tmp_path / "cameras.parquet").write_bytes((sample / "cameras.parquet").read_bytes())
    evening(tmp_path, 1, out)
    assert asked == ["rig00005"]


def test_another_number_of_buckets_is_refused(
    sample: pathlib.Path, first: pathlib.Path
) -> None:
    files = str(sample / "evening1"), str(sample / "cameras.parquet"), str(first)
    with pytest.raises(SystemExit, match="another number of buckets"):
        fleet.run(*files, buckets=BUCKETS + 1)


# ---- Dask --------------------------------------------------------------------


def test_dask_gives_the_bits_of_the_loop_though_a_worker_is_killed(
    sample: pathlib.Path, first: pathlib.Path, second: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = client.run(os.getpid)
        killed = []

        def kill(bucket: int) -> None:
            """A worker that has work, once."""
            busy = [address for address, work in client.processing().items() if work]
            if busy and not killed:
                killed.append(pids[busy[0]])
                os.kill(killed[0], signal.SIGKILL)

        engine = fleet.dask(client)
        out = evening(
            sample, 2, tmp_path / "out", last=str(first), engine=engine, wrote=kill
        )
        assert killed
        client.wait_for_workers(2, timeout=60)
        assert killed[0] not in client.run(os.getpid).values()  # a new worker replaces it
    assert bytes_of(out) == bytes_of(second)


def test_a_bucket_that_fails_is_named_and_the_others_are_written(
    sample: pathlib.Path, first: pathlib.Path, tmp_path: pathlib.Path, capsys: Any
) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.Client(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as client:
        real = fleet.calibrate_bucket

        def fails(rigs: list[str], *rest: Any) -> pd.DataFrame:
            if "rig00000" in rigs:
                raise MemoryError("too large")
            return real(rigs, *rest)

        fleet.calibrate_bucket = fails
        try:
            failed = fleet.run(
                str(sample / "evening1"), str(sample / "cameras.parquet"), str(tmp_path),
                buckets=BUCKETS, engine=fleet.dask(client),
            )  # fmt: skip
        finally:
            fleet.calibrate_bucket = real
    bucket = fleet.bucket_of("rig00000", BUCKETS)
    assert failed == [bucket]
    assert f"bucket {bucket}: too large" in capsys.readouterr().err
    expected = bytes_of(first)
    del expected[fleet.file_of("", bucket, BUCKETS).name]
    assert bytes_of(tmp_path) == expected


# ---- Spark -------------------------------------------------------------------


def test_batches_of_spark_are_cut_where_a_rig_ends() -> None:
    spark = pytest.importorskip("spark")
    table = pd.DataFrame({"rig": list("aaabbbbbcdddd"), "u": range(13)})
    for cuts in itertools.combinations(range(1, 13), 3):
        ends = [0, *cuts, 13]
        batches = [table[a:b] for a, b in itertools.pairwise(ends)]
        found = list(spark.whole_rigs([*batches, table[:0]]))
        assert [u for rows in found for u in rows.u] == list(range(13))
        rigs = [rig for rows in found for rig in rows.rig.unique()]
        assert rigs == list("abcd")  # each in one table


def test_spark_gives_the_bits_of_the_loop(
    sample: pathlib.Path, first: pathlib.Path, second: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    pytest.importorskip("pyspark")
    import spark

    session = spark.make_session("local[2]")
    session.conf.set("spark.sql.execution.arrow.maxRecordsPerBatch", "500")
    try:
        files = str(sample / "evening2"), str(sample / "cameras.parquet"), str(tmp_path)
        for _ in range(2):  # run again, when all files are there
            spark.run(session, *files, last=str(first), buckets=BUCKETS)
    finally:
        session.stop()
    assert bytes_of(tmp_path) == bytes_of(second)
