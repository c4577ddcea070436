"""calibrate says why the views of a rig disagree, estimates clocks, and considers intrinsics."""
import os
import re
import unittest

import numpy as np

from cli_support import (FLOAT, OUTPUTS, STEREO, Camera, CliTest, angle_deg, camera_row, compose,
                         content, measured, read, rigcal, rotation, transforms, write)

NAMES = "abcd"
POSES = {"a": (np.eye(3), np.zeros(3)),
         "b": (rotation(0, 0.3, 0.05), np.array([-0.3, 0.02, 0.05])),
         "c": (rotation(0.1, -0.4, 0), np.array([0.4, 0.1, 0.1])),
         "d": (rotation(-0.3, 0.1, 0.1), np.array([-0.1, -0.3, 0.1]))}
BOARD = np.array([[j * 0.05, i * 0.05, 0.0] for i in range(4) for j in range(5)])
FPS, BURSTS, BURST = 30, 8, 3


class Path:
    """A board held by hand: sines about a pose, with 0.35 m/s and 0.8 rad/s."""

    def __init__(self, rng):
        self.R = rotation(*rng.uniform(-0.4, 0.4, 3))
        self.t = np.array([*rng.uniform(-0.1, 0.1, 2), rng.uniform(0.8, 1.1)])
        self.rate = rng.uniform(0.4, 1.2, (6, 3)) * 2 * np.pi
        self.phase = rng.uniform(0, 2 * np.pi, (6, 3))
        self.size = rng.normal(size=(6, 3))
        speed = np.sqrt(((self.size * self.rate)**2).sum(1) / 2)
        self.size[:3] *= 0.8 / np.sqrt((speed[:3]**2).sum())
        self.size[3:] *= 0.35 / np.sqrt((speed[3:]**2).sum())

    def at(self, time):
        d = (self.size * np.sin(self.rate * time + self.phase)).sum(1)
        R = rotation(*d[:3]) @ self.R
        return R, self.t + d[3:] - R @ BOARD.mean(0)


class Recorded(CliTest):
    """Four cameras, eight bursts of three frames of a board that moves, noise of 0.3 px."""

    def record(self, late=None, seed=3, moving=True, lines=None, bent=0.0):
        """late: for each camera, by how many seconds its pictures are later than their
        stamps"""
        rng = np.random.default_rng(seed)
        late = late or {}
        self.cameras = {n: camera_row(n) for n in NAMES}
        self.rows, self.times = [], []
        X = BOARD + np.array([0, 0, bent]) * (1 - ((BOARD[:, :1] - 0.1) / 0.1)**2)
        for burst in range(BURSTS):
            path = Path(rng)
            for i in range(BURST):
                time, frame = i / FPS, str(100 * burst + i)
                for name in NAMES:
                    R, t = path.at(time + late.get(name, 0) if moving else 0)
                    R, t = compose(POSES[name], (R, t))
                    uv = Camera(self.cameras[name]).project(X @ R.T + t)
                    uv += rng.normal(0, 0.3, uv.shape)
                    self.rows += [[frame, name, f"p{k}", *x, *p]
                                  for k, (x, p) in enumerate(zip(BOARD, uv))]
                    self.times.append([frame, name, 10.0 * burst + time + 5])
        self.cameras.update(lines or {})

    def files_of_recording(self):
        head = list(self.cameras["a"])
        self.cameras_csv = write(self.folder, "cameras.csv", "\n".join(
            [",".join(head), *(",".join(str(r[k]) for k in head)
                               for r in self.cameras.values())]) + "\n")
        self.observations_csv = write(self.folder, "observations.csv", "\n".join(
            ["frame,camera,point,X,Y,Z,u,v",
             *(",".join(str(x) for x in r) for r in self.rows)]) + "\n")
        self.times_csv = write(self.folder, "times.csv", "\n".join(
            ["frame,camera,time_s", *(",".join(str(x) for x in r) for r in self.times)]) + "\n")

    def run_recording(self, *options):
        self.files_of_recording()
        run = self.calibrate(self.cameras_csv, self.observations_csv, None, *options)
        measured(self.verdict(run))
        return run

    def run_with_times(self, *options):
        self.files_of_recording()
        return self.run_recording("--times", self.times_csv, *options)

    @staticmethod
    def verdict(run):
        lines = run.stdout.splitlines()
        starts = [k for k, line in enumerate(lines) if line.startswith("sqrt(F)")]
        ends = [k for k, line in enumerate(lines) if line.startswith("+- of the rig")]
        return "\n".join(lines[starts[0]:ends[0]]) if starts and ends else ""

    def assert_no_view_is_named(self, run):
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertNotIn("left out", run.stdout)
        self.assertLessEqual({r["verdict"] for r in read(self.result("poses.csv"))},
                             {"fits", "unchecked"})

    def off_by(self):
        """The largest errors of a camera [deg, mm]."""
        found = transforms(self.result("rig.csv"), "camera")
        return (max(angle_deg(found[n][0], POSES[n][0]) for n in NAMES),
                max(1000 * np.linalg.norm(found[n][1] - POSES[n][1]) for n in NAMES))


class TestReasons(Recorded):
    def test_a_good_rig_agrees(self):
        self.record()
        run = self.run_with_times()
        self.assert_no_view_is_named(run)
        self.assertIn("The views agree with one rig", self.verdict(run))
        self.assertNotIn("Most likely", run.stdout)

    def test_clocks_are_named_and_no_view(self):
        self.record({"b": 0.012, "d": -0.007})
        run = self.run_with_times()
        self.assert_no_view_is_named(run)
        self.assertIn("Most likely the clocks", self.verdict(run))
        self.assertIn("--clocks", self.verdict(run))
        first = read(self.result("faults.csv"))[0]
        self.assertEqual((first["fault"], first["explains"]), ("clocks", "1"))
        self.assertAlmostEqual(float(first["value1"]), 0.012, delta=0.001)
        self.assertAlmostEqual(float(first["value3"]), -0.007, delta=0.001)

    def test_without_times_clocks_are_not_tested_and_never_the_reason(self):
        self.record({"b": 0.012})
        verdict = self.verdict(self.run_recording())
        self.assertIn("Clocks could not be tested: no times are given", verdict)
        self.assertNotIn("Most likely", verdict)
        self.assertIn("--times FILE", verdict)

    def test_a_still_target_says_nothing_of_clocks(self):
        self.record({"b": 0.012}, moving=False)
        run = self.run_with_times("--clocks")
        self.assert_no_view_is_named(run)
        rows = {r["camera"]: r for r in read(self.result("clocks.csv"))}
        self.assertEqual([rows[n]["state"] for n in NAMES], ["held", "still", "still", "still"])
        self.assertIn("held: the target hardly moves", run.stdout)

    def test_intrinsics_of_another_camera_are_named_and_no_view(self):
        for factor in (0.8, 1.03, 1.27):
            other = dict(camera_row("c"))
            other["fx"], other["fy"] = factor * other["fx"], factor * other["fy"]
            self.record(lines={"c": other})
            run = self.run_recording()
            self.assert_no_view_is_named(run)
            self.assertIn("Most likely the focal length of c", self.verdict(run))
            first = read(self.result("faults.csv"))[0]
            self.assertEqual((first["fault"], first["camera"], first["explains"]), ("focal", "c", "1"))
            self.assertAlmostEqual(float(first["value1"]), 1 / factor - 1, delta=0.07)

    def test_a_bent_board_is_no_reason(self):
        self.calibrate_well(STEREO)
        faults = read(self.result("faults.csv"))
        self.assertEqual((faults[0]["fault"], faults[0]["explains"]), ("bent", "0"))
        self.assertTrue(0.1e-3 < abs(float(faults[0]["value2"])) < 0.25e-3)
        verdict = self.verdict(self.calibrate_well(STEREO))
        self.assertIn("The board is bent", verdict.replace("One thing is wrong, the", "The"))
        self.assertIn("Neighbouring points err together (0.32", verdict)
        self.assertNotIn("Most likely", verdict)


class TestClocks(Recorded):
    LATE = {"b": 0.012, "c": 0.004, "d": -0.007}

    def clocks(self):
        return {r["camera"]: r for r in read(self.result("clocks.csv"))}

    def test_clocks_are_estimated(self):
        self.record(self.LATE)
        self.run_with_times()
        before = self.off_by()
        run = self.run_with_times("--clocks")
        self.assert_no_view_is_named(run)
        clocks = self.clocks()
        for name, late in self.LATE.items():
            self.assertAlmostEqual(float(clocks[name]["offset"]), late, delta=6e-4)
            self.assertLess(float(clocks[name]["sigma_offset"]), 3e-4)
            self.assertEqual(clocks[name]["state"], "free")
        self.assertEqual(clocks["a"]["state"], "held")
        self.assertIn("late by [ms]", run.stdout)
        self.assertLess(float(self.verdict(run).split()[1].rstrip(":")), 1.2)
        after = self.off_by()
        self.assertTrue(after[0] < before[0] / 5 and after[1] < before[1] / 5, (before, after))

    def test_frames_are_paired_anew_and_that_is_said(self):
        self.record({"b": 1 / FPS + 0.004})
        run = self.run_with_times("--clocks")
        self.assertIn("frames are paired anew: a picture of b belongs to the frame that is 1 later "
                      "than its own", run.stdout)
        self.assertEqual(self.clocks()["b"]["paired_later"], "1")
        self.assertAlmostEqual(float(self.clocks()["b"]["offset"]), 1 / FPS + 0.004, delta=1e-3)
        self.assertLess(self.off_by()[1], 2)

    def test_frame_numbers_are_times_when_asked(self):
        self.record({"b": 0.3 / FPS})
        run = self.run_recording("--times", "frames", "--clocks")
        self.assert_no_view_is_named(run)
        self.assertAlmostEqual(float(self.clocks()["b"]["offset"]), 0.3, delta=0.02)
        self.assertIn("late by [frames]", run.stdout)

    def test_stamps_that_differ_are_known_and_no_clock_is_late(self):
        self.record({"b": 0.012})
        for row in self.times:
            row[2] += 0.012 if row[1] == "b" else 0
        run = self.run_with_times()
        self.assert_no_view_is_named(run)
        self.assertIn("The views agree with one rig", self.verdict(run))

    def test_a_clock_that_runs_fast(self):
        self.record()
        rng = np.random.default_rng(5)
        drift = 2e-4  # over 70 s: 14 ms
        self.rows = []
        for burst in range(BURSTS):
            path = Path(rng)
            for i in range(BURST):
                stamp = 10.0 * burst + i / FPS
                for name in NAMES:
                    late = drift * (stamp - 35) if name == "c" else 0
                    R, t = compose(POSES[name], path.at(i / FPS + late))
                    uv = Camera(self.cameras[name]).project(BOARD @ R.T + t)
                    uv += rng.normal(0, 0.3, uv.shape)
                    self.rows += [[str(100 * burst + i), name, f"p{k}", *x, *p]
                                  for k, (x, p) in enumerate(zip(BOARD, uv))]
        run = self.run_with_times("--clocks", "--drift")
        self.assertIn("drift [ppm]", run.stdout)
        self.assertAlmostEqual(1e6 * float(self.clocks()["c"]["drift"]), 200, delta=15)

    def test_noise_of_times(self):
        self.record()
        rng = np.random.default_rng(6)
        for row in self.times:
            row[2] += rng.normal(0, 0.004)
        plain = float(self.verdict(self.run_with_times()).split()[1].rstrip(":"))
        with_it = float(self.verdict(self.run_with_times("--sigma-time", "0.004"))
                        .split()[1].rstrip(":"))
        self.assertGreater(plain, 1.5)
        self.assertLess(with_it, 1.25)
        run = self.run_with_times("--sigma-time", "0.004")
        self.assertIn("The views agree with one rig", self.verdict(run))

    def test_a_late_clock_is_named_although_times_are_noisy(self):
        self.record({"b": 0.03})
        rng = np.random.default_rng(7)
        for row in self.times:
            row[2] += rng.normal(0, 0.004)
        run = self.run_with_times("--sigma-time", "0.004")
        first = read(self.result("faults.csv"))[0]
        self.assertEqual((first["fault"], first["camera"], first["explains"]), ("clock", "b", "1"))
        self.assertAlmostEqual(float(first["value1"]), 0.03, delta=4 * float(first["sigma1"]))
        self.assertLess(float(first["sigma1"]), 0.0015)
        self.assertIn("Most likely the clock of b: its pictures are later", self.verdict(run))
        run = self.run_with_times("--sigma-time", "0.004", "--clocks")
        self.assertIn("The views agree with one rig", self.verdict(run))
        seen = {(r["fault"], r["camera"]): r for r in read(self.result("faults.csv"))}
        self.assertEqual(seen["clock", "b"]["value1"], "")


class TestIntrinsics(Recorded):
    SIGMAS = ["sigma_rot_deg", "sigma_pos"]

    def test_zeros_change_nothing(self):
        self.record()
        plain = self.run_recording().stdout, self.files()
        zeros = self.run_recording("--intrinsics-sigma", "0,0,0,0,0").stdout, self.files()
        self.assertEqual(plain, zeros)

    def test_uncertainties_contain_them_and_poses_do_not_change(self):
        self.record()
        self.run_recording()
        plain = read(self.result("rig.csv")), read(self.result("pairs.csv"))
        run = self.run_recording("--intrinsics-sigma", "0.003,0.001,3,0.01,0.03")
        self.assertIn("intrinsics", self.verdict(run) + run.stdout)
        for before, after in zip(plain, (read(self.result("rig.csv")),
                                         read(self.result("pairs.csv")))):
            for a, b in zip(before, after):
                self.assertEqual([a[k] for k in a if k[0] in "Rt"], [b[k] for k in b if k[0] in "Rt"])
                if a.get("camera") != "a":
                    for k in self.SIGMAS:
                        self.assertGreater(float(b[k]), 5 * float(a[k]))


class TestEstimatedIntrinsics(Recorded):
    """Cameras whose file is wrong by two standard deviations in f, and by one in the
    centre."""
    SIGMAS = "0.003,0.001,3,0.01,0.03"
    ON = ["--intrinsics-sigma", SIGMAS, "--estimate-intrinsics"]

    def record_off(self):
        lines = {}
        for k, name in enumerate(NAMES):
            lines[name] = dict(camera_row(name))
            for f in "fx", "fy":
                lines[name][f] *= 1 + 0.006 * (-1)**k
            lines[name]["cx"] += 3
        self.record(lines=lines)

    def test_what_they_explain_of_F_does_not_scale_the_covariances(self):
        self.record_off()
        said = re.compile(r"multiplied by sqrt\(F\), (\d\.\d+)(.*)")
        plain = said.search(self.run_recording().stdout)
        few = said.search(self.run_recording("--intrinsics-sigma", "0.001,0,0,0,0").stdout)
        self.assertEqual((plain[2], few[2]), ("", ", less what uncertain intrinsics explain of it"))
        self.assertLessEqual(float(few[1]), float(plain[1]))
        all_of_it = self.run_recording("--intrinsics-sigma", self.SIGMAS).stdout
        self.assertIsNone(said.search(all_of_it))
        self.assertIn("and for intrinsics that are uncertain by", all_of_it)

    def test_the_recording_moves_them_towards_the_truth(self):
        self.record_off()
        self.run_recording("--intrinsics-sigma", self.SIGMAS)
        self.assertFalse(os.path.exists(self.result("cameras.csv")))
        before = self.off_by()
        run = self.run_recording(*self.ON)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        after = self.off_by()
        self.assertLess(after[1], 0.7 * before[1])
        self.assertIn("intrinsics estimated, with their deviations as a prior", run.stdout)
        self.assertRegex(run.stdout, r"\n  b: moved f by 0\.\d+ \+- 0\.\d+ %.*; it could not determine .*k2\n")
        found = {r["camera"]: r for r in read(self.result("cameras.csv"))}
        self.assertEqual(list(found), list(NAMES))
        left = [abs(float(found[n]["fx"]) / camera_row(n)["fx"] - 1) for n in NAMES]
        self.assertLess(max(left), 0.8 * 0.006)
        self.assertLess(np.mean(left), 0.5 * 0.006)

    def test_what_is_written_is_a_camera_file(self):
        self.record_off()
        self.run_recording(*self.ON)
        changed = content(self.out, "cameras.csv")
        path = write(self.folder, "changed.csv", changed)
        before = transforms(self.result("rig.csv"), "camera")
        run = self.calibrate(path, self.observations_csv)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        after = transforms(self.result("rig.csv"), "camera")
        for name in NAMES:
            self.assertLess(np.linalg.norm(before[name][1] - after[name][1]), 2e-5)

    def test_deviations_of_zero_move_nothing(self):
        self.record_off()
        plain = self.run_recording().returncode, content(self.out, "rig.csv")
        run = self.run_recording("--intrinsics-sigma", "0,0,0,0,0", "--estimate-intrinsics")
        self.assertEqual((run.returncode, content(self.out, "rig.csv")), plain)
        for r in read(self.result("cameras.csv")):
            self.assertAlmostEqual(float(r["fx"]), self.cameras[r["camera"]]["fx"], delta=1e-3)

    def test_options_that_it_needs_and_does_not_go_with(self):
        self.record()
        self.files_of_recording()
        for options, words in ((["--estimate-intrinsics"], "goes with --intrinsics-sigma"),
                               ([*self.ON, "--times", "frames"], "does not go with --times")):
            run = self.calibrate(self.cameras_csv, self.observations_csv, None, *options)
            self.assertEqual((run.returncode, run.stdout), (2, ""))
            self.assertIn(words, run.stderr)


class TestComplaints(Recorded):
    """Every wrong file or option is reported, and the message names what is wrong."""

    def setUp(self):
        super().setUp()
        self.record()

    def refused(self, words, *options, times=None):
        self.files_of_recording()
        if times is not None:
            write(self.folder, "times.csv", times)
        run = self.calibrate(self.cameras_csv, self.observations_csv, None, *options)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(run.stdout, "")
        self.assertFalse(os.path.exists(self.out))
        for word in words:
            self.assertIn(word, run.stderr)

    def refused_times(self, words, change):
        lines = [[str(x) for x in r] for r in self.times]
        change(lines)
        text = "\n".join(["frame,camera,time_s", *(",".join(x) for x in lines)]) + "\n"
        self.refused(words, "--times", os.path.join(self.folder, "times.csv"), times=text)

    def test_a_frame_without_a_time(self):
        def change(lines):
            del lines[5]  # frame 1 of b
        self.refused_times(["times.csv has no time of camera b in frame 1"], change)

    def test_a_frame_spelled_otherwise(self):
        def change(lines):
            for x in lines:
                x[0] = "0" + x[0]
        self.refused_times(["no time of camera a in frame 0", "It has frame 00"], change)

    def test_a_camera_twice(self):
        self.refused_times(["times.csv:98: camera a in frame 0 is on line 2 already"],
                           lambda lines: lines.append(["0", "a", "7"]))

    def test_an_unknown_camera(self):
        self.refused_times(["times.csv:3: camera x is not in"],
                           lambda lines: lines[1].__setitem__(1, "x"))

    def test_times_that_fall(self):
        def change(lines):
            lines[5][2] = "4.9"
        self.refused_times(["times.csv:7: camera b: frame 1 at 4.9 s is not later than frame 0 at 5 s"],
                           change)

    def test_times_that_are_equal(self):
        def change(lines):
            for x in lines[4:8]:
                x[2] = "5.0"
        self.refused_times(["frames 0 and 1 have the same time"], change)

    def test_text_for_a_number(self):
        for text, word in (("soon", "is not a number"), ("nan", "is not a number"),
                           ("inf", "is not a number"), ("", "column time_s is empty"),
                           ("1e999", "is too large")):
            self.refused_times(["times.csv:4: ", word],
                               lambda lines, text=text: lines[2].__setitem__(2, text))

    def test_another_file(self):
        self.files_of_recording()
        self.refused(["there is no column time_s: this looks like observations.csv, where times.csv "
                      "is wanted"], "--times", self.observations_csv)
        self.refused(["cannot read", "none.csv"], "--times", os.path.join(self.folder, "none.csv"))

    def test_frames_that_are_no_numbers(self):
        self.rows[0:20] = [["first", *r[1:]] for r in self.rows[0:20]]
        self.refused(["--times frames: the name of frame first is not a whole number"],
                     "--times", "frames")

    def test_options_that_need_others(self):
        self.refused(["--clocks goes with --times FILE"], "--clocks")
        self.refused(["--sigma-time goes with --times FILE"], "--sigma-time", "0.02")
        self.refused(["--drift goes with --clocks"], "--drift", "--times", "frames")
        self.refused(["do not go with --method paper"], "--times", "frames", "--method", "paper")

    def test_values_of_options(self):
        for value in ("-1", "soon", "nan", "inf", "2000"):
            self.refused(["--sigma-time"], "--times", "frames", f"--sigma-time={value}")
        for value, word in (("1,2", "takes 5 numbers"), ("0.003,0.001,3,0.01,x", "takes 5 numbers"),
                            ("-0.003,0.001,3,0.01,0.03", "F, of the focal length, is a part from 0"),
                            ("0.003,2,3,0.01,0.03", "ASPECT is a part from 0 to 0.5, not 2"),
                            ("0.003,0.001,inf,0.01,0.03", "takes 5 numbers"),
                            ("0.003,0.001,3,-1,0.03", "K1 is a number from 0 to 100, not -1"),
                            ("0.003,0.001,3,1e9,0.03", "K1 is a number from 0 to 100")):
            self.refused([word], f"--intrinsics-sigma={value}")

    def test_one_frame(self):
        self.rows, self.times = self.rows[:80], self.times[:4]
        run = self.run_with_times("--clocks")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual({r["state"] for r in read(self.result("clocks.csv"))}, {"held", "alone"})

    def test_times_of_frames_that_nobody_saw_do_not_count(self):
        self.record({"b": 0.012})
        self.run_with_times("--clocks")
        before = content(self.out, "rig.csv")
        self.times += [["5000", n, 1e4] for n in NAMES]
        self.run_with_times("--clocks")
        self.assertEqual(content(self.out, "rig.csv"), before)
        self.assertEqual(sorted(os.listdir(self.out)), sorted([*OUTPUTS, "clocks.csv"]))


if __name__ == "__main__":
    unittest.main()
