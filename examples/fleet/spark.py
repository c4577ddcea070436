"""The same fleet on Spark: mapInPandas hands whole rigs to calibrate_rows of fleet.py.

python spark.py DETECTIONS CAMERAS OUT [--last OUT_OF_EARLIER] [--master local[2]]
                [--buckets 64]
"""

from __future__ import annotations

import argparse
import pathlib
from collections.abc import Iterable, Iterator
from typing import Any

import fleet
import pandas as pd

TYPES = {"string": "string", "double": "double", "bool": "boolean", "binary": "binary"}
SCHEMA = ", ".join(f"{field.name} {TYPES[str(field.type)]}" for field in fleet.ROW)


def whole_rigs(batches: Iterable[pd.DataFrame]) -> Iterator[pd.DataFrame]:
    """Groups batches into whole rigs, in the order of rigs. Spark cuts batches anywhere."""
    rest = pd.DataFrame()
    for batch in batches:
        rows = pd.concat([rest, batch], ignore_index=True) if len(rest) else batch
        if len(rows):
            is_last = rows.rig == rows.rig.iloc[-1]
            rest = rows[is_last]
            if not is_last.all():
                yield rows[~is_last]
    if len(rest):
        yield rest


def run(
    session: Any, detections: str, cameras: str, out: str, last: str | None, buckets: int
) -> None:
    """The same as fleet.run, with Spark."""
    folder = pathlib.Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    done = out if any(folder.iterdir()) else None

    def calibrate(batches: Iterator[pd.DataFrame]) -> Iterator[pd.DataFrame]:
        for rows in whole_rigs(batches):
            yield fleet.calibrate_rows(rows, cameras, last, done)

    rows = (
        session.read.parquet(detections)
        .repartition(buckets, "rig")
        .sortWithinPartitions("rig")
        .mapInPandas(calibrate, schema=SCHEMA)
        .toPandas()  # a row a camera
    )
    for bucket, theirs in rows.groupby(
        rows.rig.map(lambda rig: fleet.bucket_of(rig, buckets))
    ):
        fleet.write(fleet.to_schema([theirs]), fleet.file_of(out, bucket, buckets))


def make_session(master: str) -> Any:
    """A session on this machine only: no web page, no name lookup."""
    from pyspark.sql import SparkSession

    return (
        SparkSession.builder.master(master)
        .config("spark.driver.bindAddress", "127.0.0.1")
        .config("spark.driver.host", "127.0.0.1")
        .config("spark.ui.enabled", "false")
        .config("spark.sql.execution.arrow.pyspark.enabled", "true")
        .config("spark.submit.pyFiles", fleet.__file__)
        .getOrCreate()
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("detections")
    parser.add_argument("cameras")
    parser.add_argument("out")
    parser.add_argument("--last", help="what an earlier evening gave")
    parser.add_argument("--master", default="local[*]")
    parser.add_argument("--buckets", type=int, default=64)
    given = vars(parser.parse_args())
    run(make_session(given.pop("master")), **given)
    print(fleet.summary(given["out"]))
