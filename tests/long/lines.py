#!/usr/bin/env python3
"""Long files through the command line: time that grows as the lines do, and memory within a few
times the file.

    python3 tests/long/lines.py              10 000, 100 000 and 1 000 000 lines, in some 10 minutes;
                                             writes tests/long/lines.md. It goes on where the last
                                             run of the same program and script ended
    python3 tests/long/lines.py short        5 000 and 50 000; of --method paper 1 000 and 10 000
    python3 tests/long/lines.py --only NAME  of the kinds of file whose names contain NAME; prints

Build the preset gcc-double first, or name another program by --rigcal. Each kind of file is
made with ten times as many lines in turn. A run fails if the program does not end as it
should, if ten times the lines take more than 30 times the time of the processor (a time that
grows with the square takes 100 times), or if the memory is above the kind's limit, in times
the file, and 4 MB, which the program takes whatever it reads.
"""
import argparse
import collections
import hashlib
import json
import pathlib
import platform
import resource
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/bench"))
from scale import look_at, project, random_rotation  # noqa: E402

N_CAMERAS, N_POINTS, SIGMA_PX = 4, 25, 0.3
GROWTH_MOST = 3.0  # of the time per line, from one file to the next
BASE_BYTES = 4e6
MIN_SECONDS = 0.02  # below, the start of the program counts
CAMERA = {"width": 1280, "height": 960, "fx": 900.0, "fy": 905.0, "cx": 640.5, "cy": 478.25,
          "k1": -0.12, "k2": 0.03, "p1": 0.0005, "p2": -0.0003}

# sizes: the cameras, placements and points that n lines become; options: of rigcal; most: the
# memory, in times the file; status: with which the program may end, beside 0; longest: lines
Kind = collections.namedtuple("Kind", "name what sizes options most status longest", defaults=[0, 1000000])


def rig(n: int) -> tuple[int, int, int]:
    return N_CAMERAS, n // (N_CAMERAS * N_POINTS), N_POINTS


def few(n: int) -> tuple[int, int, int]:
    return 2, 10, n // 20


def tags(n: int) -> tuple[int, int, int]:
    return N_CAMERAS, n // (4 * N_CAMERAS), 4


def tags_of_one(n: int) -> tuple[int, int, int]:
    return 1, n // 4, 4


def tags_of_two(n: int) -> tuple[int, int, int]:
    return 2, n // 8, 4


def threes(n: int) -> tuple[int, int, int]:
    return N_CAMERAS, n // (3 * N_CAMERAS), 3


def single(n: int) -> tuple[int, int, int]:
    return 1, n, 1


def one(n: int) -> tuple[int, int, int]:
    return 1, 1, n


KINDS = [
    Kind("rig", "views of 25 points", rig, ["calibrate"], 3),
    Kind("rig, --robust", "the same", rig, ["calibrate", "--robust"], 3),
    Kind("rig, --times frames", "the same", rig, ["calibrate", "--times", "frames"], 3),
    Kind("rig, --method paper", "the same", rig, ["calibrate", "--method", "paper"], 3),
    Kind("few views", "20 views of many points", few, ["calibrate"], 3),
    Kind("few views, --method paper", "the same", few, ["calibrate", "--method", "paper"], 3),
    Kind("names", "views of 25 points; no two lines name the same point", rig, ["calibrate"], 3),
    Kind("tags", "views of 4 points", tags, ["calibrate"], 3),
    Kind("tags, one camera", "views of 4 points, each in a placement of its own", tags_of_one, ["calibrate"], 3),
    Kind("tags, two cameras", "views of 4 points", tags_of_two, ["calibrate"], 3, 1),
    Kind("tags, late", "views of 4 points, those of one camera a frame late", tags, ["calibrate"], 3, 1),
    Kind("tags, out of order", "views of 4 points, those of one camera in other frames", tags, ["calibrate"], 3, 1),
    Kind("threes", "views of 3 points", threes, ["calibrate"], 3, 1),
    Kind("single", "each line a view of its own, which has no pose", single, ["calibrate"], 3, 1),
    Kind("one view", "one view of all points", one, ["calibrate"], 3),
    Kind("one view, --method paper", "the same", one, ["calibrate", "--method", "paper"], 4),
    Kind("triangulate", "points of 4 cameras", rig, ["triangulate"], 3),
    Kind("line", "candidates", None, ["line"], 3),
    Kind("monitor", "matches, 25 a frame", None, ["monitor"], 3),
]


def poses_of(n: int) -> list:
    """cam_from_rig of cameras on a circle that look at its middle."""
    angles = np.pi * np.arange(n) / max(n, 2)
    return [look_at(np.array([3 * np.cos(a), 3 * np.sin(a), 0.3 * k]), np.zeros(3)) for k, a in enumerate(angles)]


def write_cameras(folder: pathlib.Path, n: int) -> None:
    with open(folder / "cameras.csv", "w") as file:
        file.write("camera," + ",".join(CAMERA) + "\n")
        for c in range(n):
            file.write(f"c{c}," + ",".join(map(str, CAMERA.values())) + "\n")


def frame_of(kind: Kind, camera: int, frame: int, n_frames: int) -> int:
    """The frame that the file names for this view."""
    if camera == 1 and kind.name == "tags, late":
        return frame + 1
    if camera == 1 and kind.name == "tags, out of order":
        return (7919 * frame + 13) % n_frames  # a prime, so that each frame is named once
    return frame


def write_observations(path: pathlib.Path, kind: Kind, n: int) -> None:
    cameras, placements, points = kind.sizes(n)
    rng = np.random.default_rng(22)
    poses = poses_of(cameras)
    target = np.round(rng.uniform(-0.3, 0.3, (points, 3)), 4)
    texts = ["%.4f,%.4f,%.4f" % tuple(X) for X in target]
    line = 0
    with open(path, "w") as file:
        file.write("frame,camera,point,X,Y,Z,u,v\n")
        for f in range(placements):
            R_f, t_f = random_rotation(rng), rng.uniform(-0.5, 0.5, 3)
            in_rig = target @ R_f.T + t_f
            for c, (R, t) in enumerate(poses):
                frame = frame_of(kind, c, f, placements)
                uv = project(CAMERA, in_rig @ R.T + t) + rng.normal(scale=SIGMA_PX, size=(points, 2))
                first = line if kind.name == "names" else 0
                file.writelines("%d,c%d,p%d,%s,%.3f,%.3f\n" % (frame, c, first + k, texts[k], u, v)
                                for k, (u, v) in enumerate(uv.tolist()))
                line += points


def write_candidates(path: pathlib.Path, n: int) -> None:
    uv = np.random.default_rng(22).uniform((0, 0), (1279, 959), (n, 2))
    with open(path, "w") as file:
        file.write("u,v\n")
        file.writelines("%.3f,%.3f\n" % (u, v) for u, v in uv.tolist())


def write_matches(path: pathlib.Path, n: int) -> None:
    rng = np.random.default_rng(22)
    X = rng.uniform(-0.5, 0.5, (n, 3))
    seen = [project(CAMERA, X @ R.T + t) + rng.normal(scale=SIGMA_PX, size=(n, 2)) for R, t in poses_of(N_CAMERAS)]
    with open(path, "w") as file:
        file.write("time_s,camera_a,u_a,v_a,camera_b,u_b,v_b\n")
        for k in range(n):
            a = k % N_CAMERAS
            b = (a + 1) % N_CAMERAS
            file.write("%.2f,c%d,%.3f,%.3f,c%d,%.3f,%.3f\n" % (k // N_POINTS * 0.04, a, *seen[a][k], b, *seen[b][k]))


def used_by(command: list[str], good: set[int], folder: pathlib.Path) -> tuple[float, int]:
    """The time of the processor [s] and the largest resident memory [bytes]. /usr/bin/time
    starts the program: what Python starts counts Python's own memory as well."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(folder / "output.txt", "w") as out:
        status = subprocess.run(["/usr/bin/time", "-f", "%M", "-o", str(folder / "used.txt"), *command],
                                stdout=out, stderr=subprocess.STDOUT, check=False).returncode
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if status not in good:
        sys.exit(f"lines: {' '.join(command)}: exit status {status}\n{(folder / 'output.txt').read_text()[-2000:]}")
    kilobytes = (folder / "used.txt").read_text().split()[-1]
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 1024 * int(kilobytes)


def calibrated(rigcal: str, folder: pathlib.Path) -> pathlib.Path:
    """Makes a folder with rig.csv and rig.bin from a short file of kind rig. Returns the
    folder."""
    known = folder / "known"
    if not known.exists():
        write_observations(folder / "short.csv", KINDS[0], 10000)
        used_by([rigcal, "calibrate", "--cameras", str(folder / "cameras.csv"), "--observations",
                 str(folder / "short.csv"), "--out", str(known)], {0}, folder)
    return known


def measure(kind: Kind, n: int, rigcal: str, folder: pathlib.Path, n_runs: int) -> tuple[int, float, int]:
    """The number of bytes of the file, the least time and the most memory of the runs."""
    path = folder / "long.csv"
    cameras = kind.sizes(n)[0] if kind.sizes else N_CAMERAS
    write_cameras(folder, cameras)
    command = [rigcal, *kind.options]
    # 1 is an alarm, for the short file's rig is not exact; a point of which a view is left out
    good = {0, kind.status} if kind.options[0] == "calibrate" else {0, 1}
    if kind.options[0] == "monitor":
        write_matches(path, n)
        command += ["--rig", str(calibrated(rigcal, folder) / "rig.csv"), "--matches", str(path)]
    else:
        command += ["--cameras", str(folder / "cameras.csv")]
    if kind.options[0] == "line":
        write_candidates(path, n)
        command += ["--from", "c0", "--to", "c1", "--pixel", "640,480", "--candidates", str(path)]
    elif kind.options[0] in ("calibrate", "triangulate"):
        write_observations(path, kind, n)
        command += ["--observations", str(path)]
    if kind.options[0] in ("line", "triangulate"):
        command += ["--rig", str(calibrated(rigcal, folder) / "rig.csv")]
    elif kind.options[0] == "calibrate":
        command += ["--out", str(folder / "out")]
    runs = [used_by(command, good, folder) for _ in range(n_runs)]
    return path.stat().st_size, min(seconds for seconds, _ in runs), max(memory for _, memory in runs)


def kept(kind: Kind, n: int, rigcal: str) -> pathlib.Path:
    """Where the result of this program and script is."""
    text = pathlib.Path(__file__).read_bytes() + pathlib.Path(rigcal).read_bytes()
    return ROOT / "build/lines" / f"{hashlib.sha256(text).hexdigest()[:16]}-{kind.name.replace(' ', '_')}-{n}.json"


def measure_once(kind: Kind, n: int, rigcal: str, folder: pathlib.Path, n_runs: int) -> tuple[int, float, int]:
    """As `measure`, or from an earlier run of the same program and script."""
    path = kept(kind, n, rigcal)
    if not path.exists():
        result = measure(kind, n, rigcal, folder, n_runs)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(result))
    return tuple(json.loads(path.read_text()))


def judge(kind: Kind, n: int, rigcal: str, folder: pathlib.Path, before: float,
          is_short: bool) -> tuple[str, list[str], float]:
    """The row of the table, what is wrong with it, and the time per line."""
    once = measure if is_short else measure_once
    size, seconds, memory = once(kind, n, rigcal, folder, 1 if before else 3)
    row = f"| {kind.name} | {n} | {size / 1e6:.1f} | {seconds:.2f} | {memory / 1e6:.1f} | {memory / size:.2f} |"
    wrong = []
    if memory > kind.most * size + BASE_BYTES:
        wrong.append(f"{kind.name}, {n} lines: {memory} bytes of memory, more than {kind.most} times the file")
    per_line = max(seconds, MIN_SECONDS) / n
    if before and per_line > GROWTH_MOST * before:
        wrong.append(f"{kind.name}, {n} lines: a line takes {per_line / before:.1f} times as long as in a tenth of it")
    print(row, flush=True)
    return row, wrong, per_line


def head() -> str:
    found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    return found.stdout.strip() or "none"


def write_table(rows: list[str], commit: str) -> None:
    n_run = sum("not run" not in row for row in rows)
    model = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    kinds = [f"- {k.name}: {k.what}. At most {k.most} times the file." for k in KINDS]
    (ROOT / "tests/long/lines.md").write_text("\n".join([
        "# Long files through the command line", "",
        "`python3 tests/long/lines.py` writes this file. It asserts that ten times the lines take at most 30 times the",
        "time of the processor, and that the memory is at most so many times the file and 4 MB:", "", *kinds, "",
        "A line that is read takes 32 bytes, and a place of a point 28. A view of few points takes some 350 beside them: two",
        "poses, and the library's work. A placement takes some 200. By --method paper, the pairs of a view take up to 0.9 MB,",
        "which counts in a file of 0.5 MB.",
        "", "| file | lines | MB | s of the processor | memory, MB | memory over file |",
        "| --- | ---: | ---: | ---: | ---: | ---: |", *rows, "",
        f"*{n_run} files, commit {commit}, gcc-double, {platform.machine()}, {model[0] if model else 'unknown'}*",
        ""]))


def lengths_of(kind: Kind, is_short: bool) -> list[int]:
    if is_short:
        return [1000, 10000] if "paper" in kind.name else [5000, 50000]
    return [n for n in (10000, 100000, 1000000) if n <= kind.longest]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("form", nargs="?", choices=["full", "short"], default="full")
    parser.add_argument("--rigcal", default=str(ROOT / "build/gcc-double/rigcal"))
    parser.add_argument("--only", default="")
    parser.add_argument("--known", action="store_true", help="nothing is run: the table of what has been")
    parser.add_argument("--commit", help="of the program, if not HEAD")
    options = parser.parse_args()
    rows, wrong = [], []
    for kind in KINDS:
        if options.only not in kind.name:
            continue
        per_line = 0.0
        with tempfile.TemporaryDirectory() as name:
            for n in lengths_of(kind, options.form == "short"):
                if options.known and not kept(kind, n, options.rigcal).exists():
                    rows.append(f"| {kind.name} | {n} | | not run | | |")
                    continue
                row, bad, per_line = judge(kind, n, options.rigcal, pathlib.Path(name), per_line,
                                           options.form == "short")
                rows.append(row)
                wrong += bad
    if wrong:
        sys.exit("lines: " + "\nlines: ".join(wrong))
    if options.form == "full" and not options.only:
        write_table(rows, options.commit or head())
    print(f"{sum('not run' not in row for row in rows)} files: time and memory grow as the lines do")
    return 0


if __name__ == "__main__":
    sys.exit(main())
