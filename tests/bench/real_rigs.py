#!/usr/bin/env python3
"""Real rigs through `rigcal calibrate`, in double and in float, beside SciPy: two Markdown
tables of BENCHMARKS.md.

    python3 tests/bench/real_rigs.py                 the sets of the repository
    python3 tests/bench/real_rigs.py FOLDER...       other sets, files as examples/data/FORMAT.md

Build the presets gcc-double and gcc-float first, or name other builds by --double and --float.

scipy.optimize.least_squares adjusts the same views, in NumPy and without code of rigcal's.
It starts from the poses of the single views, composed along a tree, each off by a hundredth.
The script prints how far rigcal's cameras are from SciPy's, and from reference_rig.csv where
the set has one that is an adjustment of all views (--no-reference NAME: it is none). Evaluations
are those of bench_rig_views, from composed poses and from the join.

Exit status: 1 if a set misses a target that is stated at TARGETS. SciPy's minimum counts. A
set whose cameras are not connected, or that rigcal refuses, is named and passed over.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
from scipy.optimize import least_squares

ROOT = pathlib.Path(__file__).resolve().parents[2]
SETS = ["examples/data/opencv_stereo", "examples/data/myptv_stepped",
        "examples/data/openptv_cavity", "tests/data/pose2sim_scene"]
# Limits: degrees; part of the camera's distance from the target; part of the rms.
TARGETS = {"double": (1e-4, 1e-5, 1e-5), "float": (2e-3, 5e-5, 1e-3)}
DISTURB = 0.01  # radian, and part of the distance
COEFFICIENTS = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]
POSE = [f"R{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)] + ["tx", "ty", "tz"]


def table(path):
    with open(path, newline="", encoding="utf-8-sig") as file:
        return list(csv.DictReader(file))


def pose_of(line):
    p = np.array([float(line[name]) for name in POSE])
    return p[:9].reshape(3, 3), p[9:]


def times(a, b):
    return a[0] @ b[0], a[0] @ b[1] + a[1]


def inverse(a):
    return a[0].T, -a[0].T @ a[1]


def turn(w):
    angle = np.linalg.norm(w)
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if angle < 1e-9:
        return np.eye(3) + W
    return np.eye(3) + np.sin(angle) / angle * W + (1 - np.cos(angle)) / angle**2 * W @ W


def degrees_between(a, b):
    R = a @ b.T
    sine = np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return np.degrees(np.arctan2(sine, (np.trace(R) - 1) / 2))


class Camera:
    def __init__(self, line):
        self.is_fisheye = line.get("lens", "") == "fisheye"
        self.size = line["width"], line["height"]
        self.f = np.array([float(line["fx"]), float(line["fy"])])
        self.c = np.array([float(line["cx"]), float(line["cy"])])
        self.k = [float(line.get(name) or 0) for name in COEFFICIENTS]

    def text(self):
        numbers = [float(self.is_fisheye), *map(float, self.size), *self.f, *self.c, *self.k]
        return " ".join(f"{x:.17g}" for x in numbers)

    def project(self, X):
        k1, k2, p1, p2, k3, k4, k5, k6 = self.k
        if self.is_fisheye:
            r = np.hypot(X[:, 0], X[:, 1])
            theta = np.arctan2(r, X[:, 2])
            q = theta**2
            bent = theta * (1 + q * (k1 + q * (k2 + q * (k3 + q * k4))))
            d = X[:, :2] * np.where(r > 0, bent / np.maximum(r, 1e-300), 1 / X[:, 2])[:, None]
        else:
            x, y = X[:, 0] / X[:, 2], X[:, 1] / X[:, 2]
            q = x * x + y * y
            radial = (1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6)))
            d = np.stack([x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x),
                          y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y], 1)
        return d * self.f + self.c


class Set:
    """A folder, and those of its views that rigcal used: the views that have a pose by
    themselves."""

    def __init__(self, folder):
        self.folder, self.name = folder, folder.resolve().name
        self.cameras = {line["camera"]: Camera(line) for line in table(folder / "cameras.csv")}
        seen = {}
        for line in table(folder / "observations.csv"):
            numbers = [float(line[name]) for name in ("X", "Y", "Z", "u", "v")]
            seen.setdefault((line["frame"], line["camera"]), []).append(numbers)
        self.seen = {view: np.array(points) for view, points in seen.items()}

    def take(self, poses):
        self.own = {view: poses[view] for view in self.seen if view in poses}
        self.views = sorted(self.own, key=lambda view: list(self.seen).index(view))
        self.frames = list(dict.fromkeys(frame for frame, _ in self.views))
        self.views.sort(key=lambda view: self.frames.index(view[0]))
        used = {camera for _, camera in self.views}
        self.used = [camera for camera in self.cameras if camera in used]

    def compose(self):
        cams, places = {self.used[0]: (np.eye(3), np.zeros(3))}, {}
        for _ in self.used:
            for frame, camera in self.views:
                own = self.own[frame, camera]
                if camera in cams and frame not in places:
                    places[frame] = times(inverse(cams[camera]), own)
                elif frame in places and camera not in cams:
                    cams[camera] = times(own, inverse(places[frame]))
        return cams, places

    def text(self):
        lines = [f"{len(self.used)} {len(self.frames)} {len(self.views)}"]
        lines += [self.cameras[camera].text() for camera in self.used]
        for frame, camera in self.views:
            R, t = self.own[frame, camera]
            points = self.seen[frame, camera]
            lines.append(f"{self.used.index(camera)} {self.frames.index(frame)} {len(points)}")
            lines += [" ".join(f"{x:.17g}" for x in row) for row in [[*R.ravel(), *t], *points]]
        return "\n".join(lines) + "\n"


def adjust(data):
    """The cameras and the sum of squares by SciPy."""
    cams, places = data.compose()
    if len(cams) < len(data.used):
        raise ValueError("its cameras are not connected")
    free = [cams[name] for name in data.used[1:]] + [places[name] for name in data.frames]
    rng = np.random.default_rng(1)
    distance = np.median([np.linalg.norm(own[1]) for own in data.own.values()])
    scale = np.tile([1, 1, 1, distance, distance, distance], len(free))

    def poses(x):
        moved = [(turn(d[:3]) @ R, t + d[3:]) for d, (R, t) in zip(x.reshape(-1, 6), free)]
        n = len(data.used) - 1
        return dict(zip(data.used, [cams[data.used[0]], *moved[:n]])), dict(zip(data.frames, moved[n:]))

    def residuals(x):
        at_cams, at_places = poses(x * scale)
        parts = []
        for frame, camera in data.views:
            R, t = times(at_cams[camera], at_places[frame])
            points = data.seen[frame, camera]
            parts.append((data.cameras[camera].project(points[:, :3] @ R.T + t) - points[:, 3:]).ravel())
        return np.concatenate(parts)

    x = rng.uniform(-DISTURB, DISTURB, scale.size)
    for _ in range(3):  # starts again where it stopped, because it ends a little early
        found = least_squares(residuals, x, jac="3-point", method="trf", x_scale="jac",
                              ftol=1e-15, xtol=1e-15, gtol=1e-15)
        x = found.x
    return poses(x * scale)[0], 2 * found.cost


def calibrate(program, data):
    """The cameras, the poses of the views with their sums, and the sum over the rig."""
    with tempfile.TemporaryDirectory() as out:
        run = subprocess.run([program, "calibrate", "--cameras", data.folder / "cameras.csv",
                              "--observations", data.folder / "observations.csv", "--out", out],
                             capture_output=True, text=True)
        if run.returncode not in (0, 1):
            raise ValueError(run.stderr.strip())
        out = pathlib.Path(out)
        rig = {line["camera"]: pose_of(line) for line in table(out / "rig.csv")}
        lines = table(out / "poses.csv")
        own = {(line["frame"], line["camera"]): pose_of(line) for line in lines}
        own_sum = sum(float(line["n"]) * float(line["rms_px"])**2 for line in lines)
        rest = [line for line in table(out / "residuals.csv") if line["du"]]
    if any(line["left_out"] == "1" for line in rest):
        raise ValueError("rigcal left points out")
    left = np.array([[float(line["du"]), float(line["dv"])] for line in rest])
    return rig, own, own_sum, np.sum(left**2), len(left), run.stdout


def differences(data, cams, others):
    """The largest differences of all cameras: degrees, and centres in parts of the
    distance."""
    distances = {}
    for (_, camera), (_, t) in data.own.items():
        distances.setdefault(camera, []).append(np.linalg.norm(t))
    turned, moved = 0, 0
    for name in data.used:
        (R, t), (Q, s) = cams[name], others[name]
        turned = max(turned, degrees_between(R, Q))
        moved = max(moved, np.linalg.norm(R.T @ t - Q.T @ s) / np.median(distances[name]))
    return turned, moved


def evaluations(program, data):
    beside = pathlib.Path(program).parent / "tests" / "bench_rig_views"
    run = subprocess.run([beside], input=data.text(), capture_output=True, text=True)
    if run.returncode != 0:
        raise ValueError(run.stderr.strip())
    lines = dict((line.split()[0], line.split()[1:]) for line in run.stdout.splitlines())
    return [int(lines[key][0]) for key in ("composed", "joined")], float(lines["joined"][1])


def judge(data, builds, with_reference):
    """The rows of the two tables, and whether a target is missed."""
    rows, is_missed, scipy_cams = [], False, None
    for real, program in builds.items():
        rig, own, own_sum, rig_sum, n, said = calibrate(program, data)
        if scipy_cams is None:
            data.take(own)
            scipy_cams, scipy_sum = adjust(data)
        if sorted(own) != sorted(data.own):
            raise ValueError(f"in {real} other views have a pose")
        turned, moved = differences(data, rig, scipy_cams)
        rms, best = np.sqrt(rig_sum / n), np.sqrt(scipy_sum / n)
        reference = ["", ""]
        if with_reference:
            lines = table(data.folder / "reference_rig.csv")
            others = {line["camera"]: pose_of(line) for line in lines}
            first = inverse(others[data.used[0]])
            others = {name: times(pose, first) for name, pose in others.items()}
            reference = [f"{x:.1e}" for x in differences(data, rig, others)]
        V, C, F = len(data.views), len(data.used), len(data.frames)
        between, within = 6 * (V - C - F + 1), 2 * n - 6 * V
        root = ""
        if between > 0:
            root = f"{np.sqrt((rig_sum - own_sum) / between / (own_sum / within)):.2f}"
            told = re.search(r"sqrt\(F\) ([0-9.]+)", said)
            if not told or abs(float(told[1]) - float(root)) > 0.02 * float(root):
                raise ValueError(f"rigcal tells another sqrt(F) than {root}")
        (composed, joined), seen_sum = evaluations(program, data)
        if abs(seen_sum / rig_sum - 1) > 1e-3:
            raise ValueError("bench_rig_views ends elsewhere")
        most = TARGETS[real]
        misses = [name for name, value, limit in
                  zip(("rotation", "position", "rms"), (turned, moved, abs(rms / best - 1)), most)
                  if not value <= limit]
        is_missed = is_missed or bool(misses)
        rows.append(f"| {data.name} | {real} | {C}, {F}, {V}, {n} | {turned:.1e} | {moved:.1e} | "
                    f"{reference[0]} | {reference[1]} | {rms:.6f} | {best:.6f} | {root} | "
                    f"{composed}, {joined} | {', '.join(misses) or 'none'} |")
    return rows, is_missed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folders", metavar="FOLDER", nargs="*", type=pathlib.Path)
    parser.add_argument("--double", default=ROOT / "build/gcc-double/rigcal", type=pathlib.Path)
    parser.add_argument("--float", default=ROOT / "build/gcc-float/rigcal", type=pathlib.Path)
    parser.add_argument("--no-reference", action="append", default=[], metavar="NAME")
    options = parser.parse_args()
    builds = {"double": options.double.resolve(), "float": getattr(options, "float").resolve()}
    is_missed = False
    print("| set | real | cameras, placements, views, points | SciPy: degrees | part of the distance | "
          "reference: degrees | part of the distance | rms, px | SciPy's | sqrt(F) | "
          "evaluations, composed, joined | missed |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |")
    for folder in options.folders or [ROOT / name for name in SETS]:
        data = Set(folder)
        with_reference = (folder / "reference_rig.csv").exists() and data.name not in options.no_reference
        try:
            rows, missed = judge(data, builds, with_reference)
        except ValueError as why:
            print(f"{data.name}: {why}", file=sys.stderr)
            is_missed = True
            continue
        print("\n".join(rows), flush=True)
        is_missed = is_missed or missed
    return 1 if is_missed else 0


if __name__ == "__main__":
    sys.exit(main())
