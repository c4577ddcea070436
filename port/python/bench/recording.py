"""A real recording of cameras with clocks of their own: its rig against plain least squares
of SciPy, the verdict, and its two halves against each other.

    python recording.py --cameras cameras.csv --observations observations.csv \\
        --times times.csv
    python recording.py --cameras cameras.toml --videos cam0.mp4 cam1.mp4 --charuco 4x5 \\
        --square 0.054 --marker 0.0405 --inverted [--times timestamps.csv]

It prints a Markdown table, and ends with status 1 where a limit is not held. It is run by
hand where such a recording is.
"""

from __future__ import annotations

import argparse
import itertools
import platform
import sys
import warnings

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import rigcal
from rigcal.detect.command import add_target, sources_of, target_of
from rigcal.detect.sources import read_times

RMS_PART, HALVES_DEG, HALVES_PART = 1e-3, 0.6, 0.025  # limits


def project(camera, P):
    """Pixels of points in front of a camera, without the library."""
    x, y = (P[:, :2] / P[:, 2:]).T
    k1, k2, p1, p2, k3 = (*camera.dist, 0, 0, 0, 0, 0)[:5]
    if len(camera.dist) > 5 or camera.lens != "brown":
        raise SystemExit("recording.py knows lenses of Brown with up to five coefficients")
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.column_stack([camera.fx * u + camera.cx, camera.fy * v + camera.cy])


class Plain:
    """Cameras and places of the target, by least squares over all points that count."""

    def __init__(self, rig, cameras):
        rows = [row for row in rig.residuals if not row["left_out"]]
        self.names = list(rig.cameras)
        self.frames = sorted({row["frame"] for row in rows})
        self.camera = np.array([self.names.index(row["camera"]) for row in rows])
        self.frame = np.array([self.frames.index(row["frame"]) for row in rows])
        self.X = np.array([[row[k] for k in ("X", "Y", "Z")] for row in rows])
        self.uv = np.array([[row["u"], row["v"]] for row in rows])
        self.of_rig = np.sqrt(np.mean([row["error_px"] ** 2 for row in rows]))
        self.cameras = [cameras[name] for name in self.names]
        poses = [rig.cameras[n].cam_from_rig for n in self.names[1:]]
        poses += [rig.targets[f] for f in self.frames]
        self.start = np.concatenate([np.r_[T.rvec, T.t] for T in poses])

    def residuals(self, unknowns):
        poses = np.vstack([np.zeros(6), unknowns.reshape(-1, 6)])
        n = len(self.names)
        R, t = Rotation.from_rotvec(poses[:, :3]), poses[:, 3:]
        P = R[n + self.frame].apply(self.X) + t[n + self.frame]
        P = R[self.camera].apply(P) + t[self.camera]
        out = np.empty_like(self.uv)
        for k, camera in enumerate(self.cameras):
            out[self.camera == k] = project(camera, P[self.camera == k])
        return (out - self.uv).ravel()

    def rms(self):
        """returns the rms [px] of a point, from a start with errors"""
        rng = np.random.default_rng(1)
        found = least_squares(
            self.residuals, self.start + rng.normal(0, 1e-3, len(self.start)),
            x_scale="jac", xtol=1e-12, ftol=1e-12, max_nfev=1000,
        )  # fmt: skip
        return np.sqrt(2 * found.cost / len(self.X))


def part_of(found, keep):
    rows = np.isin(found["frame"], list(keep))
    return {name: np.asarray(found[name])[rows] for name in list(found)}


def by_time(found, times):
    """Names of frames in the order of their mean times."""
    names = sorted(set(np.asarray(found["frame"]).tolist()))
    mean = {n: np.mean([t for (f, _), t in times.items() if f == n]) for n in names}
    return sorted(names, key=lambda n: mean[n])


def apart(a, b):
    """The largest rotation between two rigs [deg], and the largest shift as a part of the
    distance."""
    turns, parts = [], []
    for p, q in itertools.combinations([n for n in a.cameras if n in b.cameras], 2):
        A, B = a.pair(p, q).transform, b.pair(p, q).transform
        turns.append(np.degrees(Rotation.from_matrix(A.R @ B.R.T).magnitude()))
        lengths = np.linalg.norm(A.t), np.linalg.norm(B.t)
        parts.append(abs(lengths[0] / lengths[1] - 1))
    return max(turns), max(parts)


def quiet(*given, **how):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rigcal.Caveat)
        return rigcal.calibrate(*given, **how)


def read(given):
    """Loads the cameras and what they saw."""
    cameras = rigcal.load_cameras(given.cameras)
    if given.videos:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rigcal.Caveat)
            found = rigcal.detect(
                sources_of(given.videos), target_of(given), times=given.times,
                every=given.every, cameras=cameras,
            )  # fmt: skip
        return cameras, found
    found = rigcal.Detections.load(given.observations)
    found.times = read_times(given.times)
    return cameras, found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    add_target(parser)
    parser.add_argument("--videos", nargs="+")
    parser.add_argument("--observations")
    parser.add_argument("--sigma-time", type=float, default=0.02)
    given = parser.parse_args()
    cameras, found = read(given)
    times = found.times
    order = by_time(found, times)
    print(
        f"{len(found.views)} views, {len(order)} frames, {len(found)} points; rigcal "
        f"{rigcal.__version__}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}\n"
    )
    print("| | measured | limit |\n| --- | ---: | ---: |")
    plain = quiet(cameras, found)
    against = Plain(plain, cameras)
    least = against.rms()
    part = against.of_rig / least - 1
    print(f"| rms of the rig [px] | {against.of_rig:.5f} | |")
    print(f"| views left out | {len(plain.left_out)} | |")
    print(f"| rms by plain least squares of SciPy [px] | {least:.5f} | |")
    print(f"| difference | {100 * part:.4f} % | 0.1 % |")
    is_held = abs(part) < RMS_PART
    print(f"| sqrt(F) | {plain.sqrt_f:.2f} | |")
    rig = quiet(cameras, found, clocks=True)
    clocks = ", ".join(f"{n} {1e3 * c.offset:.0f}" for n, c in rig.clocks.items())
    print(f"| sqrt(F) with clocks; their offsets [ms] | {rig.sqrt_f:.2f}; {clocks} | |")
    middle = len(order) // 2
    for name, how in (
        ("as found", {}),
        ("clocks", {"clocks": True}),
        (f"clocks, sigma_time {given.sigma_time:g} s",
         {"clocks": True, "sigma_time": given.sigma_time}),
    ):  # fmt: skip
        halves = [quiet(cameras, part_of(found, keep), times=times, **how)
                  for keep in (order[:middle], order[middle:])]  # fmt: skip
        turn, length = apart(*halves)
        n_left = " and ".join(str(len(half.left_out)) for half in halves)
        limit = ""
        if name == "clocks":
            limit = f"{HALVES_DEG} deg, {100 * HALVES_PART:g} %"
            is_held = is_held and turn < HALVES_DEG and length < HALVES_PART
        print(f"| halves apart, {name} | {turn:.2f} deg, {100 * length:.1f} % | {limit} |")
        print(f"| their views left out | {n_left} | |")
    print("\nThe verdict without clocks:\n")
    print(plain.cause)
    return 0 if is_held else 1


if __name__ == "__main__":
    sys.exit(main())
