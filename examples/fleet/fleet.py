"""Calibrates every rig of a fleet: one row a camera comes out. See README.md.

    python fleet.py DETECTIONS CAMERAS OUT [--last OUT_OF_EARLIER] [--workers 2]
                    [--scheduler ADDRESS] [--loop] [--buckets 64]

`calibrate_rows` is the work: a data frame of rows of whole rigs in, a data frame out. Every
engine runs it. A plain loop and Dask are below, Spark is in spark.py.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import itertools
import os
import pathlib
import sys
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet
import rigcal

DETECTIONS = ["rig", "frame", "camera", "point", "X", "Y", "Z", "u", "v"]
INTRINSICS = ["fx", "fy", "cx", "cy", "width", "height"]
COEFFICIENTS = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]

# The chance that one camera which stayed counts as moved. 10 000 rigs of four cameras then
# have a false alarm in 25 evenings.
ALPHA = 1e-6

ROW = pa.schema(
    {
        "rig": pa.string(),
        "camera": pa.string(),
        "verdict": pa.string(),  # of the rig: Rig.verdict, "no verdict" or "failed"
        "reason": pa.string(),  # what Rig.warnings and Rig.cause say, or why it failed
        # cam_from_rig: X_cam = R X_rig + t, R as a rotation vector [rad]
        **dict.fromkeys(["rx", "ry", "rz", "tx", "ty", "tz"], pa.float64()),
        "sigma_rotation_deg": pa.float64(),
        "sigma_position": pa.float64(),
        "noise_px": pa.float64(),
        "moved": pa.bool_(),  # null: unknown
        "stayed": pa.string(),  # the camera that the next five are relative to
        "p": pa.float64(),  # the chance that noise alone gives as much
        **dict.fromkeys(["turn_deg", "sigma_turn_deg"], pa.float64()),
        **dict.fromkeys(["shift", "sigma_shift"], pa.float64()),  # of the camera's centre
        "names": pa.string(),  # of the cameras in `stored`
        "stored": pa.binary(),  # the last known poses of all cameras of the rig
        "digest": pa.string(),  # of all data that the row is made from
    }
)


# ---- one rig -----------------------------------------------------------------


def cameras_of(rows: pd.DataFrame) -> dict[str, rigcal.Camera]:
    """Intrinsics by camera. Columns of coefficients, and `lens`, may be absent."""
    cameras = {}
    for row in rows.sort_values("camera").to_dict("records"):
        fx, fy, cx, cy, *size = (row[name] for name in INTRINSICS)
        dist = [row.get(name) for name in COEFFICIENTS]
        dist = [0.0 if pd.isna(value) else value for value in dist]
        lens = row["lens"] if isinstance(row.get("lens"), str) else "brown"
        if lens == "fisheye":
            dist = [dist[k] for k in (0, 1, 4, 5)]
        cameras[row["camera"]] = rigcal.Camera(fx, fy, cx, cy, tuple(size), dist, lens)
    return cameras


def stored_rig(names: str | None, stored: bytes | None) -> rigcal.CalibratedRig | None:
    """The last known poses with their joint covariance. None if there are none."""
    if not isinstance(stored, bytes) or not isinstance(names, str):
        return None
    return rigcal.CalibratedRig.from_bytes(stored, names.split(","))


def chance_above(chi_square: float) -> float:
    """The chance that a chi-square variable of 6 degrees of freedom is larger."""
    half = chi_square / 2
    return float(np.exp(-half) * (1 + half + half * half / 2))


def cross(t: Any) -> Any:
    """[t]x, (3, 3)."""
    return np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0.0]])


def length_and_sigma(x: Any, Sigma: Any) -> tuple[float, float]:
    length = float(np.linalg.norm(x))
    way = x / length if length > 0 else np.array([1.0, 0, 0])
    return length, float(np.sqrt(max(way @ Sigma @ way, 0)))


def change(now: rigcal.Pair, before: rigcal.Pair) -> dict[str, Any]:
    """How far camera b moved against camera a. now, before: b_from_a of two evenings."""
    if now.covariance is None or before.covariance is None:
        return {"p": np.nan}
    b, old = now.transform, before.transform
    w = rigcal.Transform(b.R @ old.R.T, np.zeros(3)).rvec
    d = np.concatenate([w, b.t - old.t])
    Sigma = now.covariance + before.covariance
    # d(centre) = -R^T (dt + [t]x w), in the frame of a
    J = [
        -p.transform.R.T @ np.hstack([cross(p.transform.t), np.eye(3)])
        for p in (now, before)
    ]
    of_centre = J[0] @ now.covariance @ J[0].T + J[1] @ before.covariance @ J[1].T
    turn, sigma_turn = length_and_sigma(w, Sigma[:3, :3])
    shift, sigma_shift = length_and_sigma(b.center - old.center, of_centre)
    return {
        "p": chance_above(float(d @ np.linalg.solve(Sigma, d))),
        "turn_deg": np.degrees(turn),
        "sigma_turn_deg": np.degrees(sigma_turn),
        "shift": shift,
        "sigma_shift": sigma_shift,
    }


def changes(
    now: rigcal.CalibratedRig, before: rigcal.CalibratedRig
) -> tuple[dict[str, dict[str, Any]], str]:
    """What moved since the last evening, by camera, and what is to be said about it.

    Cameras that did not move against each other are a group. The largest group stayed.
    Where two groups are equally large, all cameras count as moved: the data cannot say
    which did.
    """
    names = [name for name in now.names if name in before.names]
    pairs = {
        (a, b): change(now.pair(a, b), before.pair(a, b))
        for a, b in itertools.permutations(names, 2)
    }
    group = {
        a: frozenset(b for b in names if b == a or not pairs[a, b]["p"] < ALPHA)
        for a in names
    }
    if len(names) < 2:
        return {}, ""
    stayed = max(names, key=lambda a: len(group[a]))  # the first of equals
    equal = [a for a in names if len(group[a]) == len(group[stayed])]
    rival = next((a for a in equal if a not in group[stayed]), None)
    found = {}
    for b in names:
        how = pairs[stayed, b] if b != stayed else {"p": 1.0}
        moved = rival is not None or b not in group[stayed]
        is_known = how["p"] == how["p"]
        found[b] = {**how, "moved": moved if is_known else None, "stayed": stayed}
    if rival is None:
        return found, ""
    return found, f"{stayed} or {rival} moved, or both: the data cannot say which"


def calibrate_rig(
    rig: str, rows: pd.DataFrame, intrinsics: pd.DataFrame, last: pd.DataFrame
) -> list[dict[str, Any]]:
    """One row for each camera. Any error of a rig is reported in its rows; no exception is
    raised. `last` has the rows of the rig of an earlier evening, or none."""
    names = sorted({*map(str, rows.camera.dropna()), *map(str, intrinsics.camera)}) or [""]
    known = dict.fromkeys(["names", "stored"])
    if len(last):
        known = {key: last.iloc[0][key] for key in known}
    base = {"rig": rig, "verdict": "failed", "reason": "", **known}
    cameras: dict[str, dict[str, Any]] = {name: {} for name in names}
    try:
        found = calibrated(rows, intrinsics)
        before = stored_rig(**known)
        base["verdict"] = found.verdict or "no verdict"
        said = [*found.warnings, found.cause]
        if set(found) == set(names) or before is None:
            base |= {"names": ",".join(found), "stored": found.stored}
        for name in found:
            pose, sigma = found.cam_from_rig(name), found.sigmas.get(name)
            numbers = [*pose.rvec, *pose.t]
            cameras[name] |= dict(zip(["rx", "ry", "rz", "tx", "ty", "tz"], numbers))
            if sigma is not None:
                cameras[name]["sigma_rotation_deg"] = sigma.rotation_deg
                cameras[name]["sigma_position"] = sigma.position
                cameras[name]["noise_px"] = sigma.noise_px
        if before is not None:
            moved, which = changes(found.calibrated, before)
            said.append(which)
            for name, how in moved.items():
                cameras[name] |= how
        base["reason"] = "\n".join(filter(None, said))
    except Exception as problem:  # in a large fleet every kind of fault occurs
        kind = "" if isinstance(problem, rigcal.Error) else f"{type(problem).__name__}: "
        base |= {**known, "verdict": "failed", "reason": f"{kind}{problem}"}
        cameras = {name: {} for name in names}
    return [{**base, "camera": name, **values} for name, values in cameras.items()]


def calibrated(rows: pd.DataFrame, intrinsics: pd.DataFrame) -> rigcal.Rig:
    """Calibrates the rig. Doubts about it are in Rig.warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        return rigcal.calibrate(cameras_of(intrinsics), rows, robust=True, progress=False)


# ---- many rigs ---------------------------------------------------------------


def rows_of(path: str | None, rigs: Sequence[str]) -> pd.DataFrame:
    """The rows of some rigs from a Parquet file or folder, which may be missing."""
    if path is None or not os.path.exists(path):
        return pd.DataFrame({name: [] for name in ROW.names})
    dataset = pyarrow.dataset.dataset(path, format="parquet")
    return dataset.to_table(filter=pyarrow.dataset.field("rig").isin(rigs)).to_pandas()


def in_order(rows: pd.DataFrame) -> pd.DataFrame:
    """Sorts the rows, so that their order does not depend on engine or files."""
    return rows[DETECTIONS].sort_values(DETECTIONS[1:], ignore_index=True)


def digest_of(*tables: pd.DataFrame) -> str:
    found = hashlib.sha256(rigcal.__version__.encode())
    for table in tables:
        found.update(table.to_csv(index=False).encode())
    return found.hexdigest()


def calibrate_rows(
    rows: pd.DataFrame, cameras: str, last: str | None = None, done: str | None = None
) -> pd.DataFrame:
    """Rows of detections of whole rigs in, one row a camera out. Engines call this.

    cameras  Parquet: rig, camera, width, height, fx, fy, cx, cy, k1, k2, p1, p2, ..., lens
    last     what an earlier evening gave: Parquet
    done     what this evening gave already: rigs whose data are the same are not calibrated
    """
    rigs = sorted(rows.rig.unique())
    others = [rows_of(path, rigs) for path in (cameras, last, done)]
    found: list[pd.DataFrame] = []
    by_rig = dict(list(rows.groupby("rig")))
    for rig in rigs:
        theirs = in_order(by_rig[rig])
        intrinsics, before, kept = (table[table.rig == rig] for table in others)
        digest = digest_of(theirs, intrinsics, before[["names", "stored"]][:1])
        if len(kept) and (kept.digest == digest).all():
            found.append(kept)
        else:
            table = pd.DataFrame(calibrate_rig(rig, theirs, intrinsics, before))
            found.append(table.assign(digest=digest))
    return to_schema(found)


def to_schema(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """All rows, with the columns and types of ROW, in one order."""
    listed = [row for table in tables for row in table.to_dict("records")]
    for row in listed:
        for name, value in row.items():
            row[name] = None if isinstance(value, float) and np.isnan(value) else value
    listed.sort(key=lambda row: (row["rig"], row["camera"]))
    table = pa.Table.from_pylist(listed, schema=ROW)
    return table.to_pandas(types_mapper={pa.bool_(): pd.BooleanDtype()}.get)


def bucket_of(rig: str, buckets: int) -> int:
    """A hash that is the same on every machine, unlike hash()."""
    return zlib.crc32(rig.encode()) % buckets


def in_buckets(detections: str, buckets: int) -> dict[int, list[str]]:
    """The rigs of each bucket. Only one column is read."""
    rigs: set[str] = set()
    dataset = pyarrow.dataset.dataset(detections, format="parquet")
    for batch in dataset.to_batches(columns=["rig"]):
        rigs.update(batch.column(0).unique().to_pylist())
    found: dict[int, list[str]] = {}
    for rig in sorted(rigs):
        found.setdefault(bucket_of(rig, buckets), []).append(rig)
    return found


def calibrate_bucket(
    rigs: Sequence[str], detections: str, cameras: str, last: str | None, done: str | None
) -> pd.DataFrame:
    """A task. It reads its own input, so that it can run again on any machine."""
    return calibrate_rows(rows_of(detections, rigs), cameras, last, done)


def file_of(out: str, bucket: int, buckets: int) -> pathlib.Path:
    return pathlib.Path(out) / f"bucket-{bucket:04}-of-{buckets:04}.parquet"


def write(rows: pd.DataFrame, path: pathlib.Path) -> None:
    """Writes the whole file or nothing. A file with the same content is not touched."""
    table = pa.Table.from_pandas(rows, schema=ROW, preserve_index=False)
    sink = io.BytesIO()
    pyarrow.parquet.write_table(table.replace_schema_metadata(), sink)
    data = sink.getvalue()
    if path.exists() and path.read_bytes() == data:
        return
    # Readers ignore files with this name.
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    with open(unfinished, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)


# ---- engines -----------------------------------------------------------------

# It takes the number of a bucket and its rows, in any order.
Work = Iterator[tuple[int, pd.DataFrame]]


def loop(tasks: dict[int, tuple[Any, ...]]) -> Work:
    for bucket, arguments in tasks.items():
        yield bucket, calibrate_bucket(*arguments)


def dask(client: Any) -> Callable[[dict[int, tuple[Any, ...]]], Work]:
    """Runs the tasks on a Dask cluster. Tasks of a worker that dies run on another."""
    from dask.distributed import as_completed

    def engine(tasks: dict[int, tuple[Any, ...]]) -> Work:
        futures = {
            client.submit(
                calibrate_bucket, *arguments, key=f"bucket-{bucket}", pure=False
            ): bucket
            for bucket, arguments in tasks.items()
        }
        for future in as_completed(list(futures)):
            if future.status == "error":
                print(f"bucket {futures[future]}: {future.exception()}", file=sys.stderr)
                continue
            rows = future.result()
            bucket = futures[future]
            future.release()
            yield bucket, rows

    return engine


def run(
    detections: str,
    cameras: str,
    out: str,
    last: str | None = None,
    buckets: int = 64,
    engine: Callable[[dict[int, tuple[Any, ...]]], Work] = loop,
    wrote: Callable[[int], None] = lambda bucket: None,
) -> list[int]:
    """Calibrates the fleet into files of OUT, a bucket of rigs each.

    Run again after an end in the middle, it goes on. Run again with new detections, it
    calibrates the rigs whose data changed. Returns buckets that failed, which is none
    unless the engine itself failed."""
    folder = pathlib.Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    others = [f.name for f in folder.glob("bucket-*") if f"-of-{buckets:04}." not in f.name]
    if others:
        raise SystemExit(f"{out} has another number of buckets: {others[0]}")
    tasks = {}
    for bucket, rigs in in_buckets(detections, buckets).items():
        file = file_of(out, bucket, buckets)
        tasks[bucket] = (rigs, detections, cameras, last, str(file))
    for bucket, rows in engine(dict(tasks)):
        write(rows, file_of(out, bucket, buckets))
        del tasks[bucket]
        wrote(bucket)
    return sorted(tasks)


def summary(out: str) -> str:
    """How many cameras have which verdict, and how many moved."""
    rows = pyarrow.parquet.read_table(out, columns=["rig", "verdict", "moved"]).to_pandas()
    rigs = rows.drop_duplicates("rig").verdict.value_counts().sort_index()
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in rigs.items())
    moved = int((rows.moved == True).sum())  # noqa: E712 -- null is not known
    return f"{len(rows)} cameras of {rows.rig.nunique()} rigs ({verdicts}); {moved} moved"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("detections")
    parser.add_argument("cameras")
    parser.add_argument("out")
    parser.add_argument("--last", help="what an earlier evening gave")
    parser.add_argument("--buckets", type=int, default=64)
    parser.add_argument("--workers", type=int, help="processes of a Dask cluster here")
    parser.add_argument("--scheduler", help="address of a Dask cluster")
    parser.add_argument("--loop", action="store_true", help="without an engine")
    given = parser.parse_args()
    how = (given.detections, given.cameras, given.out, given.last, given.buckets)
    if given.loop:
        failed = run(*how)
    else:
        from dask.distributed import Client, LocalCluster

        cluster = given.scheduler or LocalCluster(
            n_workers=given.workers, threads_per_worker=1, dashboard_address=None
        )
        with Client(cluster) as client:
            failed = run(*how, engine=dask(client))
    print(summary(given.out))
    if failed:
        print(f"buckets {failed} failed: run it again", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
