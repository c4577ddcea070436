"""How fast the fleet is: a loop, Dask and (where there is one) Spark, one and two workers.

python scale.py [--rigs 200] [--times 3]     prints a table for README.md
"""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import os
import pathlib
import platform
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

import fleet
import make_sample
import rigcal

BUCKETS = 32


def runs(files: tuple[str, str], last: str) -> Iterator[tuple[str, Callable[[str], Any]]]:
    """Name and run, which takes the folder to write into; set up before the clock runs."""
    yield "a loop", lambda out: fleet.run(*files, out, last, BUCKETS)
    from dask.distributed import Client, LocalCluster

    for n in (1, 2):
        with (
            LocalCluster(
                n_workers=n, threads_per_worker=1, dashboard_address=None
            ) as cluster,
            Client(cluster) as client,
        ):
            client.wait_for_workers(n)
            client.run(lambda: __import__("fleet"))
            engine = fleet.dask(client)
            name = f"Dask, {n} worker{'s' * (n > 1)}"
            yield name, lambda out, e=engine: fleet.run(*files, out, last, BUCKETS, e)
    if importlib.util.find_spec("pyspark") is None:
        return
    import spark

    for n in (1, 2):
        session = spark.make_session(f"local[{n}]")
        session.range(8).mapInPandas(lambda batches: batches, "id long").count()  # warm
        yield (
            f"Spark, local[{n}]",
            lambda out, s=session: spark.run(s, *files, out, last, BUCKETS),
        )
        session.stop()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigs", type=int, default=200)
    parser.add_argument("--times", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        sample = pathlib.Path(folder, "sample")
        make_sample.make(sample, given.rigs, 10, 1)
        files = str(sample / "evening2"), str(sample / "cameras.parquet")
        rows = sum(f.stat().st_size for f in (sample / "evening2").iterdir())
        last = f"{folder}/last"
        fleet.run(str(sample / "evening1"), files[1], last, None, BUCKETS)
        seconds: dict[str, float] = {}
        load = []
        for name, run in runs(files, last):
            for k in range(given.times):
                load.append(os.getloadavg()[0])
                start = time.monotonic()
                run(f"{folder}/{name}{k}")
                took = time.monotonic() - start
                seconds[name] = min(took, seconds.get(name, took))
    used = [
        f"{p} {importlib.metadata.version(p)}" for p in ("distributed", "pyarrow", "pandas")
    ]
    if any("Spark" in name for name in seconds):
        used.append(f"pyspark {importlib.metadata.version('pyspark')}")
    print(
        f"Made by scale.py: {given.rigs} rigs of 2 to 4 cameras, 10 places of 30 points, "
        f"{rows / 1e6:.1f} MB; {platform.machine()}, {os.cpu_count()} cores, load "
        f"{min(load):.1f} to {max(load):.1f}, Python {platform.python_version()}, "
        f"rigcal {rigcal.__version__}, {', '.join(used)}. The best of {given.times} runs.\n"
    )
    print("| | seconds | ms a rig | of the loop |\n| --- | --- | --- | --- |")
    for name, took in seconds.items():
        print(
            f"| {name} | {took:.1f} | {took / given.rigs * 1000:.0f} "
            f"| {took / seconds['a loop']:.2f} |"
        )
    for engine in ("Dask, {} worker{}", "Spark, local[{}]"):
        one, two = (engine.format(n, "s" * (n > 1)) for n in (1, 2))
        if one in seconds:
            ratio = seconds[one] / seconds[two]
            print(f"\n{engine.split(',')[0]}: two are {ratio:.2f} times as fast as one.")


if __name__ == "__main__":
    main()
