#!/usr/bin/env python3
"""False alarms of a monitor on real boards that were held out of the calibration, and how
soon it finds a camera that was turned: two Markdown tables of BENCHMARKS.md.

    python3 tests/bench/monitor_boards.py RIGCAL LIBRARY [FRAMES]

RIGCAL: the command line. LIBRARY: the library, shared, of the same precision. The set is
examples/data/opencv_stereo: every second board calibrates, the others give matches, one board
and 20 of its corners a frame. A camera is turned by turning its rays.
"""
import ctypes as C
import os
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tests", "cli"))
os.environ["RIGCAL_BIN"] = sys.argv[1] if len(sys.argv) > 1 else ""
from cli_support import STEREO, cameras, read, rotation  # noqa: E402

MATCHES, SECONDS = 20, 1 / 30


class Rig(C.Structure):
    pass


def setup(library):
    real = {4: C.c_float, 8: C.c_double}[library.rigcal_sizeof_real()]
    if hasattr(Rig, "group"):
        return real
    p = C.POINTER(real)
    Rig._fields_ = [("cameras", C.c_void_p), ("group", C.c_void_p), ("held", C.c_void_p),
                    ("capacity", C.c_size_t), ("Sigma", p), ("Sigma_capacity", C.c_size_t),
                    ("n_cameras", C.c_size_t), ("sigma_px", real), ("F", real),
                    ("between", real), ("within", real)]
    return real


class Options(C.Structure):
    pass


class Report(C.Structure):
    pass


class Monitor:
    """A rig of two cameras, from stored bytes."""

    def __init__(self, library, data, arl0, common):
        self.real = real = setup(library)
        self.library = library
        if not hasattr(Options, "arl0"):
            Options._fields_ = [(n, real) for n in ("arl0", "common", "wrong", "walk_rad", "walk_t",
                                                    "move_rad", "move_t")]
            Report._fields_ = [("alarm", C.c_int32), ("body", C.c_int32), ("confidence", real),
                               ("evidence", real), ("noise", real), ("smallest", real),
                               ("n_blind", C.c_int32), ("frames", C.c_uint32), ("rows", C.c_uint32),
                               ("doubted", C.c_uint32), ("since", C.c_uint32)]
        self.memory = [C.create_string_buffer(4096) for _ in range(3)]
        self.Sigma = (real * 400)()
        rig = Rig(C.addressof(self.memory[0]), C.addressof(self.memory[1]),
                  C.addressof(self.memory[2]), 2, self.Sigma, 400, 0, 0, 0, 0, 0)
        info = C.create_string_buffer(256)
        self.check(library.rigcal_store_load_rig(C.byref(rig), info, data, C.c_size_t(len(data))))
        self.sigma = real(rig.sigma_px)
        size = library.rigcal_monitor_size(C.c_size_t(2), C.c_size_t(0))
        self.monitor = (real * size)()
        options = Options()
        library.rigcal_monitor_defaults(C.byref(options))
        options.arl0, options.common = arl0, common
        self.check(library.rigcal_monitor_begin(self.monitor, C.c_size_t(size), C.byref(rig),
                                                C.c_size_t(0), C.byref(options)))
        self.report = Report()

    @staticmethod
    def check(status):
        if status:
            raise RuntimeError(f"status {status}")

    def frame(self, left, right):
        """Takes one frame of rays. Returns whether it alarms; the alarm is dismissed."""
        for a, b in zip(left, right):
            self.check(self.library.rigcal_monitor_match_rays(
                self.monitor, C.c_size_t(0), (self.real * 3)(*a), C.c_size_t(1), (self.real * 3)(*b),
                self.sigma))
        self.check(self.library.rigcal_monitor_frame(C.byref(self.report), self.monitor,
                                                     self.real(SECONDS)))
        if self.report.alarm:
            self.check(self.library.rigcal_monitor_dismiss(self.monitor))
        return self.report.alarm


def calibrate(folder):
    """rig.bin from every second board, and the rays of the corners of the other boards."""
    rows = read(os.path.join(STEREO, "observations.csv"))
    boards = sorted({r["frame"] for r in rows})
    taken = boards[::2]
    path = os.path.join(folder, "observations.csv")
    with open(path, "w", encoding="utf-8") as file:
        file.write("frame,camera,point,X,Y,Z,u,v\n")
        for r in rows:
            if r["frame"] in taken:
                file.write(",".join(r[k] for k in "frame camera point X Y Z u v".split()) + "\n")
    out = os.path.join(folder, "out")
    subprocess.run([sys.argv[1], "calibrate", "--cameras", os.path.join(STEREO, "cameras.csv"),
                    "--observations", path, "--out", out], check=True, stdout=subprocess.DEVNULL)
    lens = cameras(STEREO)
    rays = {}
    for r in rows:
        if r["frame"] not in taken:
            key = r["frame"], r["point"]
            rays.setdefault(key, {})[r["camera"]] = lens[r["camera"]].ray(
                [float(r["u"]), float(r["v"])])
    held_out = [b for b in boards if b not in taken]
    pairs = {b: np.array([[v["left"], v["right"]] for k, v in rays.items()
                          if k[0] == b and len(v) == 2]) for b in held_out}
    with open(os.path.join(out, "rig.bin"), "rb") as file:
        return file.read(), list(pairs.values())


def draw(rng, boards):
    pairs = boards[rng.integers(len(boards))]
    chosen = pairs[rng.choice(len(pairs), MATCHES, replace=False)]
    return chosen[:, 0], chosen[:, 1]


def false_alarms(library, data, boards, frames):
    print(f"Held out: {len(boards)} boards, {MATCHES} corners of one a frame, {frames} frames, ARL0 1000.\n")
    print("| common | stated | counted |\n| ---: | ---: | ---: |")
    for common in (0.5, 0.2, 0):
        rng = np.random.default_rng(3)
        m = Monitor(library, data, 1000, common)
        count = sum(m.frame(*draw(rng, boards)) for _ in range(frames))
        print(f"| {common} | {frames / 1000:.0f} | {count} |", flush=True)


def delays(library, data, boards):
    runs, most = 24, 600
    print(f"\nThe right camera is turned after 200 to 456 frames; ARL0 10 000, common 0.5, {runs} runs.\n")
    print("| turned | found | mean frames |\n| --- | ---: | ---: |")
    for name, deg, axis in (("pitch", 0.05, 0), ("roll", 0.05, 2), ("yaw", 0.2, 1)):
        found = []
        for run in range(runs):
            rng = np.random.default_rng(run)
            m = Monitor(library, data, 10000, 0.5)
            for _ in range(rng.integers(200, 456)):
                m.frame(*draw(rng, boards))
            w = np.zeros(3)
            w[axis] = np.radians(deg) * (-1) ** run
            R = rotation(*w)
            for f in range(1, most + 1):
                left, right = draw(rng, boards)
                if m.frame(left, right @ R.T):
                    found.append(f)
                    break
        mean = (sum(found) + most * (runs - len(found))) / runs
        print(f"| {name} {deg} degrees | {len(found)} of {runs} | {mean:.1f} |", flush=True)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__.strip())
    library = C.CDLL(sys.argv[2])
    library.rigcal_monitor_size.restype = C.c_size_t
    with tempfile.TemporaryDirectory() as folder:
        data, boards = calibrate(folder)
    false_alarms(library, data, boards, int(sys.argv[3]) if len(sys.argv) > 3 else 20000)
    delays(library, data, boards)


if __name__ == "__main__":
    main()
