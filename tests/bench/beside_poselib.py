#!/usr/bin/env python3
"""rigcal beside PoseLib, the nearest peer, on the same random scenes: a Markdown table of
BENCHMARKS.md. By hand: it makes an environment, build/venv-poselib, with PyPI's poselib.

    beside_poselib.py [SCENES]   scenes a line (1000)

One answer: PoseLib's p3p of three points far apart, the root that fits all points best, refined.
All roots: each of them refined, best first. Estimate: estimate_absolute_pose, what its users call
(RANSAC, 3 px). All three refine with the squared loss. Wrong: the first pose's sum of squared
errors is more than 1e-4 px^2 above the least that anybody found, a refinement from the truth
included. Time: of a processor, of one call of estimate_absolute_pose from Python over one of
rigcal.solve_pose, each the median of the scenes; the fixed cost of a call is in both.
"""
import os
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
VENV = ROOT / "build/venv-poselib"
POSELIB = "2.0.5"
F, SIZE, NOISE = 800.0, (1280, 960), 0.5
TARGETS = [("tag", 4), ("planar", 4), ("planar", 8), ("planar", 50), ("near-planar", 8), ("general", 4),
           ("general", 8), ("general", 50)]


def enter_environment() -> None:
    """Runs this script again with the environment's Python, which it makes first."""
    python = VENV / "bin/python"
    if pathlib.Path(sys.prefix) == VENV:
        return
    if not python.exists():
        subprocess.run(["/usr/bin/python3", "-m", "venv", VENV], check=True)
    subprocess.run([python, "-m", "pip", "install", "-q", f"poselib=={POSELIB}", "./port/python"],
                   cwd=ROOT, check=True)
    os.execv(python, [str(python), *sys.argv])


def target_of(rng, family, n):
    import numpy as np
    if family == "tag":
        return np.array([[-.5, .5, 0], [.5, .5, 0], [.5, -.5, 0], [-.5, -.5, 0]])
    thick = {"planar": 0, "near-planar": 0.05, "general": 1}[family]
    return rng.uniform(-.5, .5, (n, 3)) * [1, 1, thick]


def scene_of(rng, family, n):
    """Points, pixels, and the true pose (R, t): 3 to 30 sizes away, flat targets tilted by 60
    degrees at most, any other turn."""
    import numpy as np
    X = target_of(rng, family, n)
    if family == "general":
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
    else:
        tilt, about, roll = rng.uniform(0, np.pi / 3), rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi)
        q = product([np.cos(roll / 2), 0, 0, np.sin(roll / 2)],
                    product([np.cos(tilt / 2), np.cos(about) * np.sin(tilt / 2), np.sin(about) * np.sin(tilt / 2), 0],
                            [0, 1, 0, 0]))  # turns its front towards the camera
    depth = np.exp(rng.uniform(np.log(3), np.log(30)))
    t = depth * np.array([*rng.uniform(-.3, .3, 2), 1])
    X_c = X @ matrix(q).T + t
    uv = F * X_c[:, :2] / X_c[:, 2:] + np.array(SIZE) / 2 + rng.normal(0, NOISE, (n, 2))
    return X, uv, matrix(q), t


def product(a, b):
    import numpy as np
    return np.array([a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                     a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                     a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                     a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]])


def matrix(q):
    import numpy as np
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def squares(X, uv, R, t):
    import numpy as np
    X_c = X @ R.T + t
    if not (X_c[:, 2] > 0).all():
        return np.inf
    return float(((F * X_c[:, :2] / X_c[:, 2:] + np.array(SIZE) / 2 - uv) ** 2).sum())


def main() -> int:
    import warnings

    import numpy as np
    import poselib
    import rigcal
    warnings.simplefilter("ignore")
    scenes = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    camera = rigcal.Camera.from_matrix([[F, 0, SIZE[0] / 2], [0, F, SIZE[1] / 2], [0, 0, 1]], size=SIZE)
    peer = {"model": "PINHOLE", "width": SIZE[0], "height": SIZE[1], "params": [F, F, SIZE[0] / 2, SIZE[1] / 2]}
    squared = {"loss_type": "TRIVIAL"}

    def ours(X, uv):
        try:
            pose = rigcal.solve_pose(camera, X, uv)
        except rigcal.Error:
            return []
        return [(p.cam_from_world.R, p.cam_from_world.t) for p in (pose, *pose.others)]

    def roots(X, uv):
        centred = X - X.mean(0)
        a = int((centred ** 2).sum(1).argmax())
        b = int(((X - X[a]) ** 2).sum(1).argmax())
        c = int((np.cross(X - X[a], X[b] - X[a]) ** 2).sum(1).argmax())
        rays = np.column_stack([(uv[[a, b, c]] - np.array(SIZE) / 2) / F, np.ones(3)])
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        return poselib.p3p(rays, X[[a, b, c]])

    def refined(X, uv, pose):
        pose, _ = poselib.refine_absolute_pose(uv, X, pose, peer, squared)
        return pose.R, pose.t

    def one_answer(X, uv):
        found = roots(X, uv)
        return [refined(X, uv, min(found, key=lambda p: squares(X, uv, p.R, p.t)))] if found else []

    def all_roots(X, uv):
        found = [refined(X, uv, pose) for pose in roots(X, uv)]
        return sorted(found, key=lambda p: squares(X, uv, *p))

    def estimate(X, uv):
        pose, _ = poselib.estimate_absolute_pose(uv, X, peer, {"max_reproj_error": 3.0}, squared)
        return [(pose.R, pose.t)]

    methods = {"rigcal": ours, "one answer": one_answer, "all roots": all_roots, "estimate": estimate}
    print(f"{scenes} scenes a line, {NOISE} px, {F:.0f} px focal length, 3 to 30 sizes away; PoseLib {POSELIB}\n")
    print("| target | points | wrong: rigcal | one answer | all roots | estimate | time of estimate |\n| --- |"
          + " ---: |" * 6)
    for family, n in TARGETS:
        rng = np.random.default_rng(2026)
        spent, wrong = {name: [] for name in methods}, dict.fromkeys(methods, 0)
        for _ in range(scenes):
            X, uv, R, t = scene_of(rng, family, n)
            answers = {}
            for name, method in methods.items():
                start = time.process_time()
                answers[name] = method(X, uv)
                spent[name].append(time.process_time() - start)
            sums = {name: [squares(X, uv, *p) for p in found] for name, found in answers.items()}
            truth = poselib.CameraPose()
            truth.R, truth.t = R, t
            least = min(s for found in sums.values() for s in [*found, squares(X, uv, *refined(X, uv, truth))])
            for name, found in sums.items():
                wrong[name] += not found or found[0] > least + 1e-4
        print(f"| {family} | {n} | {' | '.join(map(str, wrong.values()))} | "
              f"{statistics.median(spent['estimate']) / statistics.median(spent['rigcal']):.1f} |", flush=True)
    return 0


if __name__ == "__main__":
    enter_environment()
    sys.exit(main())
