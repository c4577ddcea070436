"""monitor: simulated rigs that are calibrated, watched and bumped."""
import os
import re
import shutil
import tempfile
import unittest

import numpy as np

from cli_support import (Camera, CliTest, camera_row, compose, invert, measured, read, relative,
                         rigcal, rotation, transforms, write)

NOISE = 0.3
HEAD = "time_s,camera_a,u_a,v_a,camera_b,u_b,v_b"


def rig_poses(n):
    """cam_from_world of cameras on an arc of 3 m about (0, 0, 3), looking at it."""
    poses = {}
    for i, a in enumerate(np.linspace(-0.4, 0.4, n)):
        o = np.array([3 * np.sin(a), 0.2 * (-1) ** i, 3 - 3 * np.cos(a)])
        R = rotation(0, a, 0)
        poses["abcdefgh"[i]] = R, -R @ o
    return poses


def observations(poses, rng, n_boards=12):
    """Boards of 24 points that all cameras see, with noise."""
    X = np.array([[x, y, 0] for y in range(4) for x in range(6)]) * 0.12 - [0.3, 0.18, 0]
    lines = ["frame,camera,point,X,Y,Z,u,v"]
    for frame in range(n_boards):
        board = rotation(*rng.normal(0, 0.4, 3)), rng.uniform(-0.4, 0.4, 3) + [0, 0, 3]
        for name, pose in poses.items():
            R, t = compose(pose, board)
            uv = Camera(camera_row(name)).project(X @ R.T + t) + rng.normal(0, NOISE, (24, 2))
            lines += [f"f{frame},{name},{i},{x[0]},{x[1]},0,{p[0]},{p[1]}"
                      for i, (x, p) in enumerate(zip(X, uv))]
    return "\n".join(lines) + "\n"


def frame(poses, rng, n=20, wrong=0.05):
    """n points of the scene, each of them seen by two cameras."""
    names, seen = list(poses), []
    for _ in range(n):
        a, b = rng.permutation(names)[:2]
        X = rng.uniform(-0.8, 0.8, 3) + [0, 0, 3]
        uv = {}
        for c in (a, b):
            R, t = poses[c]
            uv[c] = Camera(camera_row(c)).project(R @ X + t) + rng.normal(0, NOISE, 2)
        if rng.random() < wrong:
            uv[b] = uv[b] + rng.uniform(-30, 30, 2)
        seen.append((a, uv[a], b, uv[b]))
    return seen


def matches(poses_of, n_frames, rng, start=0.0, n=20):
    lines = [HEAD]
    for f in range(n_frames):
        lines += [f"{start + f / 30:.6f},{a},{u[0]:.5f},{u[1]:.5f},{b},{v[0]:.5f},{v[1]:.5f}"
                  for a, u, b, v in frame(poses_of(f), rng, n)]
    return "\n".join(lines) + "\n"


def turned(poses, name, w):
    return {k: ((rotation(*w) @ p[0], rotation(*w) @ p[1]) if k == name else p)
            for k, p in poses.items()}


class Monitor(CliTest):
    """Calibrates each rig once."""
    folders = {}

    def rig(self, n):
        if n not in self.folders:
            folder = tempfile.TemporaryDirectory()
            rng = np.random.default_rng(n)
            poses = rig_poses(n)
            head = list(camera_row("a"))
            rows = [head] + [list(map(str, camera_row(c).values())) for c in poses]
            write(folder.name, "cameras.csv", "\n".join(map(",".join, rows)) + "\n")
            write(folder.name, "observations.csv", observations(poses, rng))
            run = rigcal("calibrate", "--cameras", os.path.join(folder.name, "cameras.csv"),
                         "--observations", os.path.join(folder.name, "observations.csv"),
                         "--sigma", str(NOISE), "--out", os.path.join(folder.name, "out"))
            self.assertEqual(run.returncode, 0, run.stderr)
            self.folders[n] = folder, poses
        folder, poses = self.folders[n]
        return os.path.join(folder.name, "out", "rig.csv"), poses

    def watch(self, rig, text, *more):
        path = write(self.folder, "matches.csv", text)
        return rigcal("monitor", "--rig", rig, "--matches", path, *more)

    def fails(self, text, *arguments):
        run = rigcal("monitor", *arguments)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn(text, run.stderr)
        return run

    # ---- what is seen -------------------------------------------------------------

    def test_a_still_rig_raises_no_alarm_and_a_line_a_frame_is_printed(self):
        rig, poses = self.rig(3)
        run = self.watch(rig, matches(lambda f: poses, 60, np.random.default_rng(1), 1.7e9))
        self.assertEqual(run.returncode, 0, run.stderr)
        rows = read(run.stdout)
        self.assertEqual(len(rows), 60)
        for f, row in enumerate(rows):
            self.assertAlmostEqual(float(row["time_s"]), 1.7e9 + f / 30, places=2)
            self.assertEqual(row["rows"], "20")
            self.assertLess(float(row["evidence"]), 0)
            self.assertEqual((row["alarm"], row["probability"]), ("0", ""))
        self.assertIn("no alarm in 60 frames with 1200 matches", run.stderr)
        self.assertRegex(run.stderr, r"a turn of camera [abc] by less than 0\.\d+ degrees")
        self.assertAlmostEqual(float(rows[-1]["noise"]), 1.03, delta=0.07)

    def test_the_camera_that_was_bumped_is_named_and_solved_anew(self):
        rig, poses = self.rig(3)
        for moved in "abc":
            w = np.radians([0.2, -0.25, 0.15])
            after = turned(poses, moved, w)
            run = self.watch(rig, matches(lambda f: after if f >= 40 else poses, 90,
                                          np.random.default_rng(ord(moved)), n=30), "--arl0", "10000")
            self.assertEqual(run.returncode, 1, run.stderr)
            self.assertRegex(run.stderr, f"alarm at [12]\\.\\d+ s: camera {moved} moved "
                             r"\(probability (0\.99|1)")
            rows = read(run.stdout)
            self.assertTrue(all(r["alarm"] == "0" for r in rows[:40]))
            self.assertTrue(any(r["alarm"] == "1" and r["camera"] == moved for r in rows[40:]))
            self.assertEqual(rows[-1]["alarm"], "0")
            # the present poses, seen from the other cameras
            now = {c: pose_in(rows[-1], c) for c in "abc"}
            for other in "abc".replace(moved, ""):
                seen = relative(now[moved], now[other])
                true = relative(after[moved], after[other])
                start = relative(poses[moved], poses[other])
                off, was = angle(seen, true), angle(start, true)
                measured(f"{moved} from {other}: off by {off:.3f} of {was:.3f} degrees")
                sigma = np.hypot(*(float(rows[-1][f"{c}.sigma_rot_deg"]) for c in (moved, other)))
                self.assertLess(off, 4 * sigma)
                self.assertLess(off, was / 3)
            told = float(re.search(r"It turned by (\S+) degrees", run.stderr)[1])
            self.assertAlmostEqual(told, 0.354, delta=0.1)

    def test_two_cameras_and_matches_alone_are_told_that_nothing_tells_which(self):
        rig, poses = self.rig(2)
        after = turned(poses, "b", np.radians([0.3, 0.1, 0.2]))
        run = self.watch(rig, matches(lambda f: after if f >= 30 else poses, 80,
                                      np.random.default_rng(5)), "--arl0", "10000")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("a camera moved, and nothing shows which: a or b. A turn of", run.stderr)
        self.assertNotIn("probability", run.stderr)

    def test_a_camera_without_matches_is_blind(self):
        rig, poses = self.rig(3)
        two = {k: poses[k] for k in "ab"}
        run = self.watch(rig, matches(lambda f: two, 30, np.random.default_rng(6)))
        self.assertEqual(run.returncode, 0)
        self.assertIn("camera c is blind", run.stderr)
        self.assertEqual(read(run.stdout)[-1]["n_blind"], "1")

    def test_observations_with_times_are_matches_in_the_order_of_time(self):
        rig, poses = self.rig(3)
        rng = np.random.default_rng(7)
        seen = write(self.folder, "o.csv", observations(poses, rng, 6))
        times = write(self.folder, "t.csv", "frame,time_s\n" + "".join(
            f"f{f},{10 - f}\n" for f in range(6)))
        run = rigcal("monitor", "--rig", rig, "--observations", seen, "--times", times)
        self.assertEqual(run.returncode, 0, run.stderr)
        rows = read(run.stdout)
        self.assertEqual([float(r["time_s"]) for r in rows], [5, 6, 7, 8, 9, 10])
        self.assertEqual({r["rows"] for r in rows}, {"48"})  # 24 points: matches of a with
                                                             # b, and of b with c

    def test_the_time_of_a_frame_is_the_mean_of_its_cameras(self):
        rig, poses = self.rig(3)
        seen = write(self.folder, "o.csv", observations(poses, np.random.default_rng(7), 3))
        times = write(self.folder, "t.csv", "frame,camera,time_s\n" + "".join(
            f"f{f},{c},{10 - f + late}\n" for f in range(3) for c, late in zip("abc", (0, 0.25, 0.5))))
        run = rigcal("monitor", "--rig", rig, "--observations", seen, "--times", times)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual([float(r["time_s"]) for r in read(run.stdout)], [8.25, 9.25, 10.25])

    def test_poses_wander_where_a_walk_is_given(self):
        rig, poses = self.rig(3)
        text = matches(lambda f: poses, 30, np.random.default_rng(8))
        still = read(self.watch(rig, text).stdout)[-1]
        walk = read(self.watch(rig, text, "--walk", "0.05,0.001").stdout)[-1]
        self.assertGreater(float(walk["b.sigma_rot_deg"]), 1.2 * float(still["b.sigma_rot_deg"]))

    # ---- what is wrong ------------------------------------------------------------

    def test_wrong_use_is_told(self):
        rig, _ = self.rig(2)
        self.fails("monitor needs --rig", "--matches", "m.csv")
        self.fails("--matches, or --observations with --times", "--rig", rig)
        self.fails("--observations and --times go together", "--rig", rig, "--observations", "o")
        self.fails("give the rig.csv", "--rig", "rig.txt", "--matches", "m.csv")
        self.fails("--arl0 is from 100 to 1e+09, not \"3\"", "--rig", rig, "--matches", "m.csv",
                   "--arl0", "3")
        self.fails("--common is from 0 to 1, not \"2\"", "--rig", rig, "--matches", "m.csv",
                   "--common", "2")
        self.fails("--walk takes 2 numbers", "--rig", rig, "--matches", "m.csv", "--walk", "1")

    def test_a_fault_of_the_matches_is_told_with_its_line(self):
        rig, _ = self.rig(2)
        good = "0,a,640,470,b,640,470\n"
        for line, what in (("0,a,1,1,x,1,1", "camera x is not in"),
                           ("0,a,1,1,a,1,1", "camera_a and camera_b are both a"),
                           ("-1,a,1,1,b,1,1", "time_s is -1, before the 0"),
                           ("soon,a,1,1,b,1,1", "time_s is \"soon\""),
                           ("0,a,one,1,b,1,1", "u_a")):
            path = write(self.folder, "m.csv", HEAD + "\n" + good + line + "\n")
            self.fails(what, "--rig", rig, "--matches", path)
            self.assertIn("m.csv:3", self.fails(what, "--rig", rig, "--matches", path).stderr)
        path = write(self.folder, "m.csv", "time_s,camera_a\n0,a\n")
        self.fails("camera_b", "--rig", rig, "--matches", path)
        seen = write(self.folder, "o.csv", "frame,camera,point,u,v\nf1,a,1,9,9\n")
        times = write(self.folder, "t.csv", "frame,time_s\nf2,0\n")
        self.fails("has no time_s of frame f1", "--rig", rig, "--observations", seen,
                   "--times", times)

    def test_a_fault_of_the_stored_rig_is_told(self):
        rig, _ = self.rig(2)
        out = os.path.join(self.folder, "copy")
        shutil.copytree(os.path.dirname(rig), out)
        copy, stored = os.path.join(out, "rig.csv"), os.path.join(out, "rig.bin")
        matches_path = write(self.folder, "m.csv", HEAD + "\n0,a,640,470,b,640,470\n")
        with open(stored, "rb") as file:
            data = file.read()
        write(out, "rig.bin", data[:-9] + b"x" + data[-8:])
        self.fails("rig.bin: ", "--rig", copy, "--matches", matches_path)
        os.remove(stored)
        self.fails("which calibrate --out writes", "--rig", copy, "--matches", matches_path)
        write(out, "rig.bin", data)
        other, _ = self.rig(3)
        shutil.copy(other, copy)
        self.fails("are not of one calibration", "--rig", copy, "--matches", matches_path)


def pose_in(row, camera):
    numbers = np.array([float(row[f"{camera}.{k}"]) for k in
                        [f"R{i}{j}" for i in "123" for j in "123"] + ["tx", "ty", "tz"]])
    return numbers[:9].reshape(3, 3), numbers[9:]


def angle(a, b):
    """Degrees between two rotations."""
    R = compose(a, invert(b))[0]
    return np.degrees(np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2)


if __name__ == "__main__":
    unittest.main()
