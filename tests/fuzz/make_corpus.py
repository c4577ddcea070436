#!/usr/bin/env python3
"""Writes inputs for the fuzz harnesses, from the real rigs of examples/data.

    python3 tests/fuzz/make_corpus.py FOLDER [HARNESS...]

Each harness reads its arguments from bytes, in the order that its source shows. From an
input that is valid the fuzzer finds its way to the rest.
"""

from __future__ import annotations

import csv
import pathlib
import random
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
RIGS = ("opencv_stereo", "openptv_cavity", "myptv_stepped")
LENSES = ("brown", "fisheye")
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


def reals(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def table(path: pathlib.Path) -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def camera(row: dict[str, str]) -> bytes:
    """A camera in the order in which fuzz_camera reads it."""
    coefficients = [float(row.get(name) or 0) for name in COEFFICIENTS]
    while coefficients and coefficients[-1] == 0:
        coefficients.pop()
    return (
        bytes([LENSES.index(row.get("lens") or "brown")])
        + struct.pack("<ii", int(row["width"]), int(row["height"]))
        + bytes([len(coefficients)])
        + reals(*(float(row[name]) for name in ("fx", "fy", "cx", "cy")), *coefficients)
    )


def identity() -> bytes:
    """A transform in the order in which fuzz_transform reads it: no rotation, one unit
    ahead."""
    return b"\0" + reals(0, 0, 0) + reals(0, 0, 1)


class Rig:
    """A rig of examples/data with fewer points."""

    def __init__(self, name: str, n_points: int) -> None:
        folder = ROOT / "examples" / "data" / name
        self.cameras = {row["camera"]: row for row in table(folder / "cameras.csv")}
        self.views: dict[tuple[str, str], list[dict[str, str]]] = {}
        for row in table(folder / "observations.csv"):
            self.views.setdefault((row["frame"], row["camera"]), []).append(row)
        for key, rows in self.views.items():
            step = max(1, len(rows) // n_points)
            self.views[key] = rows[::step][:n_points]

    def observations(self, rows: list[dict[str, str]]) -> bytes:
        return b"".join(reals(*(float(row[x]) for x in "XYZuv")) for row in rows)

    def view(self, key: tuple[str, str]) -> bytes:
        """A view in the order in which fuzz_view reads it, without sigma."""
        rows = self.views[key]
        return camera(self.cameras[key[1]]) + bytes([len(rows), 0]) + self.observations(rows)

    def shared(self, n_cameras: int, n_frames: int) -> tuple[list[str], list[str]]:
        """Some cameras, and frames that most of them saw."""
        names = list(self.cameras)[:n_cameras]
        frames = list(dict.fromkeys(frame for frame, _ in self.views))
        frames.sort(key=lambda f: -sum((f, name) in self.views for name in names))
        return names, sorted(frames[:n_frames])


def of_views(rig: Rig, before: bytes) -> list[bytes]:
    keys = [key for key in rig.views if len(rig.views[key]) >= 4]
    return [before + rig.view(key) for key in keys[:: max(1, len(keys) // 6)]]


def pose(rig: Rig) -> list[bytes]:
    plain = of_views(rig, b"\0" + b"\7" + b"\0")
    noisy = of_views(rig, b"\0" + b"\7" + b"\1" + reals(0.5))
    started = of_views(rig, b"\0" + b"\7" + b"\2" + identity())
    corners = reals(300, 200, 360, 205, 355, 262, 298, 260)
    first = camera(next(iter(rig.cameras.values())))
    return [*plain, *noisy, *started, b"\7\7\0" + first + reals(0.1) + corners]


def robust(rig: Rig) -> list[bytes]:
    return of_views(rig, b"\7" + b"\0") + of_views(
        rig, b"\7" + b"\1" + reals(3, 0.5) + struct.pack("<II", 40, 1)
    )


def diagnose(rig: Rig) -> list[bytes]:
    return of_views(rig, b"\0\0") + of_views(rig, b"\1\1" + reals(0.5))


def of_camera(rig: Rig) -> list[bytes]:
    found = [
        b"\0" + camera(row) + reals(200, 150) + reals(0.1, -0.2, 1)
        for row in rig.cameras.values()
    ]
    return found + [b"\3" + data + identity() for data in of_views(rig, b"")]


def rotation(rig: Rig) -> list[bytes]:
    turn = reals(0.3, -1.2, 0.7)
    return [
        b"\0" + turn + reals(0.5, 0.1, -0.3, 0.2) + reals(1, 0.1, 0, -0.1, 1, 0, 0, 0.2, 1),
        b"\1" + identity() + b"\0" + turn + turn + turn,
        b"\2\3\1" + (b"\0" + turn + turn + reals(1)) * 3,
    ]


def posed(rig: Rig) -> list[tuple[str, bytes]]:
    """Each camera with a pose, side by side."""
    return [
        (name, camera(row) + b"\0" + reals(0, 0.02 * i, 0) + reals(-0.1 * i, 0, 0))
        for i, (name, row) in enumerate(rig.cameras.items())
    ]


def measure(rig: Rig) -> list[bytes]:
    cameras = posed(rig)[:3]
    data = bytes([len(cameras) - 2]) + b"".join(data for _, data in cameras)
    pixels = b"".join(reals(300 - 10 * i, 220) for i in range(len(cameras)))
    return [
        bytes([kind]) + data + pixels + reals(0.3, 0.2, 5) + reals(0.1, 0, 1, 0, 0.1, 1)
        for kind in range(6)
    ]


def stored(rig: Rig, form: int, real: str) -> bytes:
    """A stored calibration (examples/data/FORMAT.md). The harness computes its
    checksums."""
    rows, size = list(rig.cameras.values())[:3], struct.calcsize(real)
    body = b""
    if form == 2:
        body += struct.pack(f"<4{real}", 0.3, 1.2, 20, 300)
    for number, row in enumerate(rows):
        lens = LENSES.index(row.get("lens") or "brown")
        known = number == 0 if form == 2 else number > 0
        body += struct.pack("<4i", lens, int(row["width"]), int(row["height"]), known)
        body += struct.pack("<i", 0) if form == 2 else b""
        numbers = [float(row[x]) for x in ("fx", "fy", "cx", "cy")]
        numbers += [float(row.get(x) or 0) for x in COEFFICIENTS]
        numbers += [1, 0, 0, 0, 1, 0, 0, 0, 1, -0.1 * number, 0, 0]
        if form == 1:
            numbers += [1e-6 * (known and i == j) for i in range(6) for j in range(i + 1)]
        body += struct.pack(f"<{len(numbers)}{real}", *numbers)
    if form == 2:
        n = 6 * (len(rows) - 1)
        triangle = [1e-6 * (i == j) for i in range(n) for j in range(i + 1)]
        body += struct.pack(f"<{len(triangle)}{real}", *triangle)
    head = (form, size, len(rows), 5, 77, 32 + len(body), 0, 0)
    return b"RIGC" + struct.pack("<HHIIIIII", *head) + body


def store(rig: Rig) -> list[bytes]:
    variances = reals(*[1e-6] * 6)
    cameras = posed(rig)[:3]
    saved = b"".join(b"\1" + data + variances for _, data in cameras)
    forms = [b"\1" + stored(rig, form, real) for form in (1, 2) for real in "fd"]
    return [b"\2" + bytes([len(cameras)]) + saved, *forms]


def adjust(rig: Rig) -> list[bytes]:
    found = []
    for options in (0, 1, 2, 4, 8, 16, 32, 63):
        names, frames = rig.shared(3, 5)
        data = bytes([options, 7, len(names), len(frames)])
        data += b"".join(camera(rig.cameras[name]) for name in names)
        for frame in frames:
            for name in names:
                rows = rig.views.get((frame, name), [])
                data += bytes([len(rows)]) + rig.observations(rows)
        found.append(data + reals(0.3, 0.001, 1e-3, 1))
    return found


def monitor(rig: Rig) -> list[bytes]:
    cameras = posed(rig)[:3]
    head = bytes([len(cameras) - 2, 1]) + b"".join(data for _, data in cameras)
    head += reals(1e-6, 0.3)
    match = b"".join(
        b"\0\0\0\1" + reals(300 - 7 * i, 200 + 3 * i, 290 - 7 * i, 200 + 3 * i, 0.3)
        for i in range(6)
    )
    frame = b"\0\2" + reals(0.1)
    rows = next(rows for rows in rig.views.values() if len(rows) >= 6)[:6]
    target = b"\0\4\0\6\0" + rig.observations(rows) + reals(0.3)
    return [
        head + (match + frame) * 3 + (target + frame) * 2 + bytes([0, kind, 1]) + frame * 2
        for kind in (6, 7, 8)
    ]


def neldermead(rig: Rig) -> list[bytes]:
    return [bytes([k, 0, 200]) + reals(1, -1, 0.5, 1e-6, 1e-6) for k in (1, 2, 3)]


def paper(rig: Rig) -> list[bytes]:
    return of_views(rig, bytes([0, 7, 2, 3, 0, 0])) + of_views(rig, bytes([1, 7, 3, 0, 2, 1]))


def ways(rig: Rig) -> list[bytes]:
    """Its scenes are made from the bytes alone."""
    chance = random.Random(" ".join(rig.cameras))
    return [bytes([kind % 4]) + chance.randbytes(400) for kind in range(8)]


def text(rig: Rig) -> list[bytes]:
    row = "cam,640,480,532.8,532.9,342.4,233.8,-0.28,0.025,0.0012,-0.00013,0.16\n"
    head = "camera,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3\n"
    seen = "frame,camera,point,X,Y,Z,u,v\n1,cam,0,0,0,0,244.4,94.1\n1,cam,1,1,0,0,250,9\n"
    return [
        b"\0" + (head + row).encode(),
        b"\1" + seen.encode(),
        b"\2camera,R11,R12,R13,R21,R22,R23,R31,R32,R33,tx,ty,tz\na,1,0,0,0,1,0,0,0,1,0,0,2\n",
        b"\3" + "\ufeffframe, camera ,time_s\r\n1,7,0.5\r\n".encode(),
    ]


HARNESSES = {
    "adjust": adjust, "camera": of_camera, "csv": text, "diagnose": diagnose,
    "measure": measure, "monitor": monitor, "neldermead": neldermead, "paper": paper,
    "pose": pose, "rig": adjust, "robust": robust, "rotation": rotation, "store": store,
    "ways": ways,
}  # fmt: skip


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    for name in sys.argv[2:] or HARNESSES:
        where = folder / name
        where.mkdir(parents=True, exist_ok=True)
        for source in RIGS:
            few = 6 if name in ("adjust", "rig") else 10
            for number, data in enumerate(HARNESSES[name](Rig(source, few))):
                (where / f"{source}-{number:02}").write_bytes(data)


if __name__ == "__main__":
    main()
