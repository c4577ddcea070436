"""What the tests of the command line share.

RIGCAL_BIN: the rigcal to test, build/gcc-double/rigcal if not given.
RIGCAL_ROOT: the project's folder, if not this file's.
"""
import csv
import io
import os
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = os.environ.get("RIGCAL_ROOT") or os.path.dirname(os.path.dirname(
    os.path.dirname(os.path.abspath(__file__))))
BIN = os.environ.get("RIGCAL_BIN") or os.path.join(
    ROOT, "build", "gcc-double", "rigcal")
SANITIZED = "asan" in os.path.basename(os.path.dirname(os.path.abspath(BIN)))
STEREO = os.path.join(ROOT, "examples", "data", "opencv_stereo")
CAVITY = os.path.join(ROOT, "examples", "data", "openptv_cavity")
STEPPED = os.path.join(ROOT, "examples", "data", "myptv_stepped")
SCENE = os.path.join(ROOT, "tests", "data", "pose2sim_scene")
OUTPUTS = ["poses.csv", "rig.csv", "targets.csv", "pairs.csv", "residuals.csv", "faults.csv",
           "rig.bin", "summary.json"]
ADDED = ["sigma_rot_deg", "sigma_pos", "second_rms_px", "probability", "verdict"]
ENTRIES = [f"S{i}{j}" for i in range(1, 7) for j in range(1, i + 1)]
RIG_ADDED = ["sigma_rot_deg", "sigma_pos", *ENTRIES]
NOISE = ["sigma_px", "noise_px", "sqrt_F"]
MATRIX = [f"R{i}{j}" for i in "123" for j in "123"]


def sound(run):
    """The run, unless a sanitizer stopped it: its exit status would be 1 as well."""
    for word in ("Sanitizer", "runtime error"):
        if word in (run.stderr or ""):
            raise AssertionError(run.stderr)
    return run


def rigcal(*arguments, **options):
    return sound(subprocess.run([BIN, *arguments], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, timeout=3600,
                                **options))


def with_fault(fault, *arguments, ignored=()):
    """rigcal, one of whose calls fails or meets a signal; see fault.c."""
    def set_signals():  # which a shell ignores that runs this in the background
        for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN if number in ignored
                          else signal.SIG_DFL)
    if not FAULT_LIBRARY:
        folder = tempfile.TemporaryDirectory()
        path = os.path.join(folder.name, "fault.so")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", path, os.path.join(
            ROOT, "tests", "cli", "fault.c"), "-ldl"], check=True)
        FAULT_LIBRARY.extend([path, folder])  # which goes with the program
    return rigcal(*arguments, preexec_fn=set_signals, env={
        **os.environ, "FAULT": fault, "LD_PRELOAD": FAULT_LIBRARY[0],
        "ASAN_OPTIONS": "verify_asan_link_order=0"})


FAULT_LIBRARY = []
FLOAT = "float" in rigcal("--version").stdout
ROUNDING = 1e-5 if FLOAT else 1e-10  # absolute for entries of a rotation, otherwise
                                     # relative


def measured(text):
    if "-v" in sys.argv or "--verbose" in sys.argv:
        print(f"\n    {text}", end=" ", file=sys.stderr)


# ---- files, and mathematics written without the library -----------------------

def read(path_or_text):
    if "\n" in path_or_text:
        return list(csv.DictReader(io.StringIO(path_or_text)))
    with open(path_or_text, newline="") as file:
        return list(csv.DictReader(file))


def content(folder, name):
    """The text of a file; of a binary file, one character for each byte."""
    encoding = "latin-1" if name.endswith(".bin") else None
    with open(os.path.join(folder, name), newline="", encoding=encoding) as file:
        return file.read()


def write(folder, name, text):
    path = os.path.join(folder, name)
    data = text if isinstance(text, bytes) else text.encode()
    with open(path, "wb") as file:
        file.write(data)
    return path


def transform(row):
    R = np.array([float(row[k]) for k in MATRIX]).reshape(3, 3)
    return R, np.array([float(row[k]) for k in ("tx", "ty", "tz")])


def transforms(path, *keys):
    return {tuple(r[k] for k in keys) if len(keys) > 1 else r[keys[0]]:
            transform(r) for r in read(path)}


def compose(c_from_b, b_from_a):
    return c_from_b[0] @ b_from_a[0], c_from_b[0] @ b_from_a[1] + c_from_b[1]


def invert(b_from_a):
    return b_from_a[0].T, -b_from_a[0].T @ b_from_a[1]


def relative(b_from_w, a_from_w):
    return compose(b_from_w, invert(a_from_w))


def angle_deg(Ra, Rb):
    half = np.linalg.norm(Ra - Rb) / np.sqrt(8)
    return np.degrees(2 * np.arcsin(min(1.0, half)))


def rotation(x, y, z):
    """A rotation by a rotation vector (Rodrigues)."""
    w = np.array([x, y, z], float)
    angle = np.linalg.norm(w)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float) / max(angle, 1e-9)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


class Camera:
    """Brown's lens with OpenCV's coefficients, or the fisheye."""

    def __init__(self, row):
        value = {k: float(v) for k, v in row.items()
                 if k not in ("camera", "lens")}
        self.size = np.array([value["width"], value["height"]])
        self.f = np.array([value["fx"], value["fy"]])
        self.c = np.array([value["cx"], value["cy"]])
        self.k = [value.get(f"k{i}", 0.0) for i in range(1, 7)]
        self.p = [value.get("p1", 0.0), value.get("p2", 0.0)]
        self.fisheye = row.get("lens") == "fisheye"

    def distort(self, xy):
        x, y = xy[..., 0], xy[..., 1]
        r2 = x * x + y * y
        k, p = self.k, self.p
        if self.fisheye:
            r = np.sqrt(r2)
            t = np.arctan(r)
            s = t * (1 + k[0] * t**2 + k[1] * t**4 + k[2] * t**6
                     + k[3] * t**8) / np.where(r > 0, r, 1)
            return xy * np.where(r > 0, s, 1)[..., None]
        d = ((1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2])))
             / (1 + r2 * (k[3] + r2 * (k[4] + r2 * k[5]))))
        return np.stack([x * d + 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x),
                         y * d + p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y], -1)

    def project(self, X_c):
        X_c = np.asarray(X_c, float)
        return self.f * self.distort(X_c[..., :2] / X_c[..., 2:]) + self.c

    def straight(self, X_c):
        """The pixel without distortion."""
        X_c = np.asarray(X_c, float)
        return self.f * X_c[..., :2] / X_c[..., 2:] + self.c

    def ray(self, uv):
        """The ray (x, y, 1) of a pixel, by Newton's method with difference quotients."""
        goal = (np.asarray(uv, float) - self.c) / self.f
        xy = goal.copy()
        for _ in range(50):
            h = 1e-7
            e = self.distort(xy) - goal
            J = np.stack([(self.distort(xy + [h, 0]) - goal - e) / h,
                          (self.distort(xy + [0, h]) - goal - e) / h], -1)
            xy = xy - np.linalg.solve(J, e[..., None])[..., 0]
        return np.append(xy, 1.0)


def cameras(folder):
    return {r["camera"]: Camera(r)
            for r in read(os.path.join(folder, "cameras.csv"))}


def observed_views(path):
    views = {}
    for r in read(path):
        X, uv = views.setdefault((r["camera"], r["frame"]), ([], []))
        X.append([float(r[k]) for k in "XYZ"])
        uv.append([float(r[k]) for k in "uv"])
    return {k: (np.array(X), np.array(uv)) for k, (X, uv) in views.items()}


class CliTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.out = os.path.join(self.folder, "out")

    def calibrate(self, cameras_csv, observations_csv, out=None, *more):
        return rigcal("calibrate", "--cameras", cameras_csv,
                      "--observations", observations_csv,
                      "--out", out or self.out, *more)

    def calibrate_set(self, folder, *more):
        return self.calibrate(os.path.join(folder, "cameras.csv"),
                              os.path.join(folder, "observations.csv"),
                              None, *more)

    def calibrate_well(self, folder, *more):
        run = self.calibrate_set(folder, *more)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return run

    def files(self, folder=None):
        """Names and contents of all files in a folder and its subfolders."""
        found = {}
        for place, folders, names in os.walk(folder or self.out):
            for name in folders:
                found[os.path.join(place, name)] = None
            for name in names:
                found[os.path.join(place, name)] = content(place, name)
        return found

    def result(self, name):
        return os.path.join(self.out, name)


# ---- a rig made up ----------------------------------------------------------------

def made_up(camera_rows, cams_from_world, targets, shared):
    """The files of a rig without noise. `shared` says which cameras see which frame."""
    rng = np.random.default_rng(7)
    X = np.round(rng.uniform(-1, 1, (12, 3)), 3)
    lines = ["frame,camera,point,X,Y,Z,u,v"]
    for frame, names in shared.items():
        for name in names:
            R, t = compose(cams_from_world[name], targets[frame])
            uv = Camera(camera_rows[name]).project(X @ R.T + t)
            lines += [f"{frame},{name},p{i},{x[0]},{x[1]},{x[2]},{p[0]!r},{p[1]!r}"
                      for i, (x, p) in enumerate(zip(X, uv.tolist()))]
    head = list(next(iter(camera_rows.values())))
    table = [",".join(head)] + [",".join(str(r[k]) for k in head)
                                for r in camera_rows.values()]
    return "\n".join(table) + "\n", "\n".join(lines) + "\n"


def camera_row(name, lens="brown", **coefficients):
    row = dict(camera=name, width=1280, height=960, fx=900.5, fy=905.25, cx=640,
               cy=470, lens=lens, k1=0, k2=0, p1=0, p2=0, k3=0, k4=0, k5=0, k6=0)
    row.update(coefficients)
    return row


# ---- changes to the text of a file ------------------------------------------------

def at_line(number, change):
    """Applies change to one line, counted from 1."""
    def apply(text):
        lines = text.split("\n")
        lines[number - 1] = change(lines[number - 1])
        return "\n".join(lines)
    return apply


def field(column, value):
    def change(line):
        fields = line.split(",")
        fields[column] = value
        return ",".join(fields)
    return change


def again(number, before):
    """Adds a copy of a line in place of another line."""
    def apply(text):
        lines = text.split("\n")
        lines.insert(before - 1, lines[number - 1])
        return "\n".join(lines)
    return apply
