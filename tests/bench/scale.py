#!/usr/bin/env python3
"""A large rig through `rigcal calibrate`: time, memory, and whether the answer is right; a
Markdown table of BENCHMARKS.md.

    python3 tests/bench/scale.py RIGCAL                100 cameras, 200 placements, 50 points
    python3 tests/bench/scale.py RIGCAL short          20 cameras, 40 placements, 20 points
    python3 tests/bench/scale.py RIGCAL C F N          C cameras, F placements, N points

RIGCAL is the program. Every camera sees every point of every placement, with noise of
0.3 px. The script makes the files in a temporary folder, runs the program, and prints the
time of the processor, the largest resident memory and its ratio to the size of the observations' file. It
fails if the memory is above 3 times that size and 4 MB, if the residuals do not show the noise that was put in, or if
the poses are farther from the truth than their standard deviations allow. It does not judge
the time, which is the machine's.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

SIGMA_PX = 0.3
RATIO_MAX = 3.0
# Bytes that the program takes for any input: its code, libc, its buffers.
BASE_BYTES = 4e6


def look_at(centre, target):
    """cam_from_rig of a camera at `centre` whose axis goes through `target`."""
    z = (target - centre) / np.linalg.norm(target - centre)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.array([x, np.cross(z, x), z])
    return R, -R @ centre


def random_rotation(rng):
    q = rng.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def project(camera, X):
    """Pixels by Brown's lens. X is in the axes of the camera."""
    x, y = X[:, 0] / X[:, 2], X[:, 1] / X[:, 2]
    r2 = x * x + y * y
    radial = 1 + r2 * (camera["k1"] + r2 * camera["k2"])
    p1, p2 = camera["p1"], camera["p2"]
    xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([camera["fx"] * xd + camera["cx"], camera["fy"] * yd + camera["cy"]], 1)


def make_rig(rng, n_cameras, n_placements, n_points):
    cameras, poses = [], []
    for c in range(n_cameras):
        angle = 2 * np.pi * c / n_cameras
        centre = np.array([3 * np.cos(angle), 3 * np.sin(angle), rng.uniform(-0.8, 0.8)])
        poses.append(look_at(centre, rng.uniform(-0.1, 0.1, 3)))
        cameras.append({
            "width": 1280, "height": 960, "fx": round(900 + rng.uniform(-20, 20), 2),
            "fy": round(900 + rng.uniform(-20, 20), 2), "cx": 640.5, "cy": 478.25,
            "k1": round(-0.12 + rng.uniform(-0.01, 0.01), 4), "k2": 0.03,
            "p1": 0.0005, "p2": -0.0003})
    placements = [(random_rotation(rng), rng.uniform(-0.5, 0.5, 3))
                  for _ in range(n_placements)]
    target = np.round(rng.uniform(-0.3, 0.3, (n_points, 3)), 4)
    return cameras, poses, placements, target


def write_files(folder, rng, cameras, poses, placements, target):
    columns = list(cameras[0])
    with open(folder / "cameras.csv", "w") as file:
        file.write("camera," + ",".join(columns) + "\n")
        for c, camera in enumerate(cameras):
            file.write("cam%03d,%s\n" % (c, ",".join(str(camera[k]) for k in columns)))
    with open(folder / "observations.csv", "w") as file:
        file.write("frame,camera,point,X,Y,Z,u,v\n")
        points = ["p%02d,%.4f,%.4f,%.4f" % (k, *X) for k, X in enumerate(target)]
        for f, (R_f, t_f) in enumerate(placements):
            X_rig = target @ R_f.T + t_f
            for c, (camera, (R, t)) in enumerate(zip(cameras, poses)):
                uv = project(camera, X_rig @ R.T + t)
                uv += rng.normal(scale=SIGMA_PX, size=uv.shape)
                file.writelines("f%03d,cam%03d,%s,%.3f,%.3f\n" % (f, c, point, u, v)
                                for point, (u, v) in zip(points, uv))


def run(program, folder):
    """The time of the processor [s] and the largest resident memory [bytes]. /usr/bin/time
    starts the program, because the memory of a program that Python starts includes Python's
    own."""
    with open(folder / "summary.txt", "w") as out:
        status = subprocess.run(
            ["/usr/bin/time", "-f", "%U %M", "-o", folder / "used.txt",
             program, "calibrate", "--cameras", folder / "cameras.csv",
             "--observations", folder / "observations.csv", "--out", folder / "out"],
            stdout=out, check=False).returncode
    if status != 0:
        sys.exit("rigcal calibrate failed: exit status %d" % status)
    of_processor, kilobytes = (folder / "used.txt").read_text().split()
    return float(of_processor), 1024 * int(kilobytes)


def check_answer(folder, poses):
    """What is wrong with rig.csv and residuals.csv, or None."""
    with open(folder / "out/rig.csv") as file:
        header = file.readline().strip().split(",")
        rows = [line.strip().split(",") for line in file]
    if [row[0] for row in rows] != ["cam%03d" % c for c in range(len(poses))]:
        return "rig.csv has not all cameras"
    at_R, at_S = header.index("R11"), header.index("S11")
    R_0, t_0 = poses[0]
    chi_square = 0.0
    for row, (R, t) in zip(rows[1:], poses[1:]):
        numbers = np.array([float(x) for x in row[at_R:at_R + 12]])
        # the truth in the frame of camera 0
        R_true = R @ R_0.T
        t_true = t - R_true @ t_0
        turn = numbers[:9].reshape(3, 3) @ R_true.T
        d = np.concatenate([[(turn[2, 1] - turn[1, 2]) / 2, (turn[0, 2] - turn[2, 0]) / 2,
                             (turn[1, 0] - turn[0, 1]) / 2], numbers[9:] - t_true])
        Sigma = np.zeros((6, 6))
        Sigma[np.tril_indices(6)] = [float(x) for x in row[at_S:at_S + 21]]
        Sigma = Sigma + np.tril(Sigma, -1).T
        chi_square += d @ np.linalg.solve(Sigma, d)
    mean = chi_square / (6 * (len(poses) - 1))
    print("| chi square of the cameras over its freedom | %.3f |" % mean)
    # Errors of the cameras are correlated through camera 0, so the mean scatters.
    if not mean < 4:
        return "the cameras are farther from the truth than their sigmas tell"
    sums, n = 0.0, 0
    with open(folder / "out/residuals.csv") as file:
        column = file.readline().strip().split(",").index("du")
        for line in file:
            fields = line.split(",")
            sums += float(fields[column]) ** 2 + float(fields[column + 1]) ** 2
            n += 2
    rms = np.sqrt(sums / n)
    print("| residuals, px of one coordinate | %.4f |" % rms)
    if not abs(rms / SIGMA_PX - 1) < 0.05:
        return "the residuals do not show the noise of %.2g px" % SIGMA_PX
    return None


def main(arguments):
    sizes = (100, 200, 50)
    if arguments[1:] == ["short"]:
        sizes = (20, 40, 20)
    elif len(arguments) == 4:
        sizes = tuple(int(x) for x in arguments[1:])
    elif len(arguments) != 1:
        sys.exit(__doc__)
    rng = np.random.default_rng(20)
    rig = make_rig(rng, *sizes)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_files(folder, rng, *rig)
        input_bytes = (folder / "observations.csv").stat().st_size
        of_processor, memory = run(arguments[0], folder)
        ratio = memory / input_bytes
        print("| %d cameras, %d placements, %d points | |\n| --- | ---: |" % sizes)
        print("| time of the processor | %.1f s |" % of_processor)
        print("| `observations.csv` | %.1f MB |" % (input_bytes / 1e6))
        print("| memory of the program | %.1f MB |" % (memory / 1e6))
        print("| memory over `observations.csv` | %.2f |" % ratio)
        wrong = check_answer(folder, rig[1])
        if wrong is None and memory > RATIO_MAX * input_bytes + BASE_BYTES:
            wrong = "it takes more than %.0f times the input" % RATIO_MAX
        if wrong is not None:
            sys.exit("scale: " + wrong)


if __name__ == "__main__":
    main(sys.argv[1:])
