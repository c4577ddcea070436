"""The speed of a fleet: a loop, Dask and Spark (if installed), one and two workers.

python scale.py [--rigs 200] [--times 3] [--readme]    prints a table, writes it there
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import importlib.metadata
import importlib.util
import os
import pathlib
import platform
import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

import fleet
import make_sample
import psutil
import rigcal

BUCKETS = 32


Run = Callable[[str], Any]


@contextlib.contextmanager
def cluster_of(n: int) -> Iterator[Any]:
    """A Dask client with n workers of one thread each, ready to work."""
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=n, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.wait_for_workers(n)
        client.run(lambda: __import__("fleet"))
        yield client


def processor_seconds() -> float:
    """Memory or time of this process, its workers, and the programs that they ran."""
    me = psutil.Process()
    total = 0.0
    for process in (me, *me.children(recursive=True)):
        with contextlib.suppress(psutil.Error):
            t = process.cpu_times()
            ended = 0.0 if process == me else t.children_user + t.children_system
            total += t.user + t.system + ended
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return total + ended.ru_utime + ended.ru_stime


@contextlib.contextmanager
def runs(files: tuple[str, str], last: str) -> Iterator[dict[str, Run]]:
    """What is timed, by name: all of it is set up before the clock runs."""
    with cluster_of(1) as one, cluster_of(2) as two:
        found: dict[str, Run] = {
            "a loop": lambda out: fleet.run(*files, out, last, BUCKETS)
        }
        for name, client in (("Dask, 1 worker", one), ("Dask, 2 workers", two)):
            engine = fleet.dask(client)
            found[name] = lambda out, e=engine: fleet.run(*files, out, last, BUCKETS, e)
        yield found


def spark_runs(files: tuple[str, str], last: str) -> Iterator[tuple[str, Run]]:
    """The same with Spark, if it is installed; one session at a time."""
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


@dataclasses.dataclass
class Timing:
    """The runs of one engine: seconds, processor seconds, and the load before each."""

    seconds: list[float] = dataclasses.field(default_factory=list)
    busy: list[float] = dataclasses.field(default_factory=list)
    load: list[float] = dataclasses.field(default_factory=list)

    def add(self, run: Run, out: str) -> None:
        self.load.append(os.getloadavg()[0])
        start, before = time.monotonic(), processor_seconds()
        run(out)
        self.seconds.append(time.monotonic() - start)
        self.busy.append(processor_seconds() - before)

    @property
    def cores(self) -> float:
        """The mean number of cores that the machine gave to it."""
        return sum(self.busy) / sum(self.seconds)


def measure(folder: str, rigs: int, times: int) -> tuple[dict[str, Timing], float]:
    """Timings by name, and the bytes of the detections. The engines take turns, so that
    other load of the machine affects all of them."""
    sample = pathlib.Path(folder, "sample")
    make_sample.make(sample, rigs, 10, 1)
    files = str(sample / "evening2"), str(sample / "cameras.parquet")
    last = f"{folder}/last"
    fleet.run(str(sample / "evening1"), files[1], last, None, BUCKETS)
    found: dict[str, Timing] = {}
    with runs(files, last) as engines:
        for k in range(times):
            for name, run in engines.items():
                found.setdefault(name, Timing()).add(run, f"{folder}/{name}{k}")
    for name, run in spark_runs(files, last):
        for k in range(times):
            found.setdefault(name, Timing()).add(run, f"{folder}/{name}{k}")
    return found, sum(f.stat().st_size for f in (sample / "evening2").iterdir())


def report(found: dict[str, Timing], rows: float, rigs: int, times: int) -> Iterator[str]:
    """The lines of the table."""
    used = [
        f"{p} {importlib.metadata.version(p)}" for p in ("distributed", "pyarrow", "pandas")
    ]
    if any("Spark" in name for name in found):
        used.append(f"pyspark {importlib.metadata.version('pyspark')}")
    load = [x for timing in found.values() for x in timing.load]
    yield (
        f"Made by scale.py: {rigs} rigs of 2 to 4 cameras, 10 places of 30 points, "
        f"{rows / 1e6:.1f} MB; {platform.machine()}, {os.cpu_count()} cores, load "
        f"{min(load):.1f} to {max(load):.1f}, Python {platform.python_version()}, "
        f"rigcal {rigcal.__version__}, {', '.join(used)}. The middle one of {times} "
        "runs, in which the engines took turns.\n"
    )
    if min(load) > 1:
        yield "Others worked on the machine: read the ratios with the cores it gave.\n"
    yield "| | seconds | of the loop | processor s a rig | cores given |"
    yield "| --- | --- | --- | --- | --- |"
    loop = statistics.median(found["a loop"].seconds)
    for name, timing in found.items():
        took = statistics.median(timing.seconds)
        busy = statistics.median(timing.busy) / rigs
        ratio = took / loop
        yield f"| {name} | {took:.1f} | {ratio:.2f} | {busy:.3f} | {timing.cores:.2f} |"
    for engine in ("Dask, {} worker{}", "Spark, local[{}]"):
        one, two = (engine.format(n, "s" * (n > 1)) for n in (1, 2))
        if one in found:
            pairs = zip(found[one].seconds, found[two].seconds)
            ratio = statistics.median(a / b for a, b in pairs)
            given_more = found[two].cores / found[one].cores
            yield (
                f"\n{engine.split(',')[0]}: two are {ratio:.2f} times as fast as one; they "
                f"had {given_more:.2f} times the cores."
            )


def write(path: pathlib.Path, lines: list[str]) -> None:
    """Replaces the lines of the table in the page, except the description of how it is
    made."""
    text = path.read_text()
    begin, end = text.index("Made by scale.py"), text.index("`python scale.py --readme`")
    path.write_text(text[:begin] + "\n".join(lines) + "\n\n" + text[end:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigs", type=int, default=200)
    parser.add_argument("--times", type=int, default=3)
    parser.add_argument("--readme", action="store_true", help="writes it into README.md")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found, rows = measure(folder, given.rigs, given.times)
    lines = list(report(found, rows, given.rigs, given.times))
    print("\n".join(lines))
    if given.readme:
        write(pathlib.Path(__file__).with_name("README.md"), lines)


if __name__ == "__main__":
    main()
