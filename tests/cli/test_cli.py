#!/usr/bin/env python3
"""The command line as a user meets it: good files, broken files, wrong use.

Runs the tests of this file, of every test_*.py beside it, and of every
tests/regression/cli_*.py. RIGCAL_BIN and RIGCAL_ROOT: see cli_support.py.
-v prints measured figures.
"""
import glob
import importlib.util
import os
import re
import subprocess
import threading
import unittest

import numpy as np

from cli_support import (ADDED, BIN, CAVITY, FLOAT, NOISE, OUTPUTS, RIG_ADDED, ROOT, ROUNDING,
                         SCENE, STEPPED, STEREO, Camera, CliTest, again, angle_deg, at_line, camera_row,
                         cameras, compose, content, field, made_up, measured,
                         observed_views, read, relative, rigcal, rotation, transform,
                         transforms, write)


# ---- calibrate, real data -------------------------------------------------------

class TestCalibrateRealData(CliTest):
    def test_stereo_pair_agrees_with_bundle_adjustment(self):
        self.calibrate_well(STEREO)
        pair = transforms(self.result("pairs.csv"), "camera_a", "camera_b")
        for name in ("reference_pairs.csv", "reference_stereocalibrate.csv"):
            key = ("camera_a", "camera_b") if "pairs" in name else ("camera",)
            known = transforms(os.path.join(STEREO, name), *key)
            R, t = known[("left", "right") if "pairs" in name else "right"]
            angle = angle_deg(R, pair["left", "right"][0])
            length = np.linalg.norm(t - pair["left", "right"][1])
            measured(f"{name}: {angle:.3f} deg, {1000 * length:.3f} mm")
            # stereoCalibrate ends at 1e-5 of its gradient, and with other sums of squares
            self.assertLess(angle, 0.01 if FLOAT else 1e-4)
            self.assertLess(length, 2e-5 if FLOAT else 1e-6)

    def check_poses(self, folder, angle_limit, part_limit, rms_limit, *more):
        self.calibrate_well(folder, *more)
        found, known = ({(r["camera"], r["frame"]): r for r in read(path)}
                        for path in (self.result("poses.csv"), os.path.join(
                            folder, "reference_poses.csv")))
        self.assertEqual(sorted(found), sorted(known))
        for key, row in known.items():
            (R, t), (R_found, t_found) = transform(row), transform(found[key])
            angle = angle_deg(R, R_found)
            part = np.linalg.norm(t - t_found) / np.linalg.norm(t)
            rms = float(found[key]["rms_px"]) / float(row["rms_px"]) - 1
            measured(f"{' '.join(key)}: {angle:.1e} deg, {100 * part:.1e} %, "
                     f"rms {100 * rms:+.1e} %")
            with self.subTest(view=key):
                self.assertLess(angle, angle_limit)
                self.assertLess(part, part_limit)
                self.assertLess(abs(rms), rms_limit)

    # The reference is the optimum, printed with nine digits. The difference has two causes:
    # rounding, and the place where the refinement ends. No sum of squares shows it.
    BEST = (0.01, 5e-5, 1e-3) if FLOAT else (1e-5, 2e-8, 1e-8)

    def test_poses_of_the_stereo_pair(self):
        self.check_poses(STEREO, *self.BEST)

    def test_poses_of_four_cameras_around_a_tank(self):
        self.check_poses(CAVITY, *self.BEST)

    def test_poses_of_three_cameras_at_a_tank(self):
        self.check_poses(STEPPED, *self.BEST)

    def test_poses_of_a_scene_picked_by_hand(self):
        self.check_poses(SCENE, *self.BEST)

    def test_published_procedure_for_the_stereo_pair(self):
        self.check_poses(STEREO, 2, 0.01, 0.2, "--method", "paper")
        for row in read(self.result("poses.csv")):
            self.assertEqual([row[k] for k in ADDED], [""] * 5)

    def test_published_procedure_for_four_cameras_around_a_tank(self):
        self.check_poses(CAVITY, 2, 0.01, 0.2, "--method", "paper")

    def test_published_procedure_for_three_cameras_at_a_tank(self):
        self.check_poses(STEPPED, 2, 0.01, 0.2, "--method", "paper")

    def test_published_procedure_for_a_scene_picked_by_hand(self):
        # Six points, 1 to 3 px of noise, nearly a plane: the distance is weak.
        self.check_poses(SCENE, 2, 0.03, 1, "--method", "paper")

    def check_sigma(self, folder, key):
        """The normal equations of the least squares, by difference quotients."""
        self.calibrate_well(folder)
        row = next(r for r in read(self.result("poses.csv"))
                   if (r["camera"], r["frame"]) == key)
        R, t = transform(row)
        X, uv = observed_views(os.path.join(folder, "observations.csv"))[key]
        camera = cameras(folder)[key[0]]
        scale = np.linalg.norm(t)

        def pose(x):
            return rotation(*x[:3]) @ R, t + scale * x[3:]

        def errors(x):
            R_x, t_x = pose(x)
            return (camera.project(X @ R_x.T + t_x) - uv).ravel()

        def centre(x):
            R_x, t_x = pose(x)
            return -R_x.T @ t_x

        def slope(function):
            return np.stack([(function(h) - function(-h)) / 2e-6
                             for h in 1e-6 * np.eye(6)], 1)
        e = errors(np.zeros(6))
        J = slope(errors)
        Sigma = e @ e / (len(e) - 6) * np.linalg.inv(J.T @ J)
        C = slope(centre)
        known = [np.degrees(np.sqrt(np.trace(Sigma[:3, :3]))),
                 np.sqrt(np.trace(C @ Sigma @ C.T))]
        found = [float(row[k]) for k in ADDED[:2]]
        measured(f"{' '.join(key)}: {found[0]:.3g} deg, {found[1]:.3g}")
        np.testing.assert_allclose(found, known, rtol=0.02 if FLOAT else 1e-5)

    def test_sigma_is_that_of_the_least_squares(self):
        self.check_sigma(STEREO, ("right", "07"))
        self.check_sigma(CAVITY, ("cam3", "0"))
        self.check_sigma(STEPPED, ("cam2", "0"))
        self.check_sigma(SCENE, ("cam03", "0"))

    def test_scene_picked_by_hand_agrees_with_an_independent_calibration(self):
        self.calibrate_well(SCENE)
        pairs = transforms(self.result("pairs.csv"), "camera_a", "camera_b")
        known = transforms(os.path.join(SCENE, "independent_pairs.csv"),
                           "camera_a", "camera_b")
        self.assertEqual(sorted(pairs), sorted(known))
        for key, (R, t) in known.items():
            angle = angle_deg(R, pairs[key][0])
            part = np.linalg.norm(t - pairs[key][1]) / np.linalg.norm(t)
            measured(f"{' '.join(key)}: {angle:.2f} deg, {100 * part:.2f} %")
            self.assertLess(angle, 2.4)
            self.assertLess(part, 0.037)

    def test_summary_tells_views_cameras_and_pairs(self):
        text = self.calibrate_well(STEREO).stdout
        self.assertEqual(len(re.findall(
            r"^(?:left|right) +\d\d +54 +0\.\d{3} +0\.\d{3} +0\.[234]\d* "
            r"+0\.0[3-9]\d* +0\.000\d+$", text, re.M)), 14)
        self.assertRegex(text, r"(?m)^right +0\.2\d\d +0\.157 +0\.0\d+ +0\.000\d+ +0\.08\d+ ")
        self.assertRegex(text, r"(?m)^left +right +0\.08\d+ +0\.50\d+ +0\.0\d+ "
                         r"+0\.000\d+ +0\.0\d+  over 7 placements$")

    @unittest.skipIf(FLOAT, "README shows what the double build prints")
    def test_readme_shows_what_is_printed(self):
        """Compares line by line, in this order. ... stands for lines left out."""
        shown = re.search(r"The first command prints this.*\n\n((?:    .*\n)+)",
                          content(ROOT, "README.md"))[1]
        printed = self.calibrate_well(STEREO).stdout.splitlines()
        self.assertGreater(shown.count("\n"), 6)
        for line in shown.splitlines():
            if line.strip() != "...":
                self.assertIn(line[4:], printed)
                del printed[:printed.index(line[4:]) + 1]

    def test_out_is_optional(self):
        with_out = self.calibrate_well(STEREO).stdout
        run = rigcal("calibrate", "--cameras", STEREO + "/cameras.csv",
                     "--observations", STEREO + "/observations.csv")
        self.assertEqual((run.returncode, run.stdout), (0, with_out))


class TestFilesWritten(CliTest):
    def check_consistent(self, folder):
        self.calibrate_well(folder)
        names = list(cameras(folder))
        poses = transforms(self.result("poses.csv"), "camera", "frame")
        rig = transforms(self.result("rig.csv"), "camera")
        targets = transforms(self.result("targets.csv"), "frame")
        pairs = transforms(self.result("pairs.csv"), "camera_a", "camera_b")

        for found in (poses, rig, targets, pairs):
            for R, _ in found.values():
                np.testing.assert_allclose(R @ R.T, np.eye(3), atol=ROUNDING)
                self.assertGreater(np.linalg.det(R), 0)
        self.assertEqual(list(rig), names)
        np.testing.assert_array_equal(rig[names[0]][0], np.eye(3))
        np.testing.assert_array_equal(rig[names[0]][1], np.zeros(3))
        self.assertEqual(len(pairs), len(names) * (len(names) - 1) // 2)
        for (a, b), found in pairs.items():
            R, t = relative(rig[b], rig[a])
            scale = np.linalg.norm(t)
            np.testing.assert_allclose(found[0], R, atol=2 * ROUNDING)
            np.testing.assert_allclose(found[1], t, atol=8 * ROUNDING * scale)
        self.assertEqual(sorted(targets), sorted({f for _, f in poses}))
        for (camera, frame), (R, t) in poses.items():
            R_rig, t_rig = compose(rig[camera], targets[frame])
            angle = angle_deg(R, R_rig)
            part = np.linalg.norm(t - t_rig) / np.linalg.norm(t)
            measured(f"{camera} {frame}: {angle:.3f} deg, {100 * part:.3f} %")
            self.assertLess(angle, 0.17)
            self.assertLess(part, 0.0012)

    def test_rig_pairs_targets_and_poses_are_consistent(self):
        for folder in (STEREO, CAVITY, STEPPED, SCENE):
            with self.subTest(folder=os.path.basename(folder)):
                self.check_consistent(folder)

    def test_columns_are_those_of_the_references(self):
        self.calibrate_well(STEREO)
        for name in OUTPUTS[:4]:
            ours = content(self.out, name).split("\n")[0]
            theirs = content(STEREO, "reference_" + name).split("\n")[0]
            added = {"poses.csv": ADDED, "targets.csv": [],
                     "rig.csv": RIG_ADDED + NOISE}.get(name, RIG_ADDED)
            self.assertEqual(ours, ",".join([theirs] + added))
            self.assertTrue(content(self.out, name).endswith("\n"))
        self.assertEqual(sorted(os.listdir(self.out)), sorted(OUTPUTS))

    def test_frames_keep_their_order_of_appearance(self):
        head, *lines = content(STEREO, "observations.csv").splitlines()
        lines.sort(key=lambda line: -int(line[:2]))
        path = write(self.folder, "observations.csv",
                     "\n".join([head, *lines]) + "\n")
        run = self.calibrate(STEREO + "/cameras.csv", path)
        self.assertEqual(run.returncode, 0)
        frames = [r["frame"] for r in read(self.result("targets.csv"))]
        self.assertEqual(frames, "14 12 09 07 05 03 01".split())

    def test_rms_is_that_of_the_pose(self):
        for folder in (STEREO, CAVITY):
            self.calibrate_well(folder)
            camera = cameras(folder)
            views = observed_views(os.path.join(folder, "observations.csv"))
            for row in read(self.result("poses.csv")):
                R, t = transform(row)
                X, uv = views[row["camera"], row["frame"]]
                error = camera[row["camera"]].project(X @ R.T + t) - uv
                rms = np.sqrt(np.mean(np.sum(error**2, 1)))
                self.assertEqual(int(row["n"]), len(X))
                self.assertAlmostEqual(rms, float(row["rms_px"]),
                                       delta=0.05 if FLOAT else 1e-6)


# ---- calibrate, rigs made up ------------------------------------------------------

class TestCalibrateMadeUp(CliTest):
    def setUp(self):
        super().setUp()
        self.rows = {r["camera"]: r for r in (
            camera_row("pinhole"),
            camera_row("fish", "fisheye", k1=-0.02, k2=0.004, k3=-0.001,
                       k4=0.0002, fx=500, fy=501),
            camera_row("rational", k1=0.3, k2=0.05, p1=0.001, p2=-0.002,
                       k3=0.01, k4=0.5, k5=0.1, k6=0.02),
            camera_row("barrel", k1=-0.2, k2=0.04))}
        self.world = {
            "pinhole": (rotation(0.1, -0.2, 0.05), np.array([0.1, 0.2, 5.0])),
            "fish": (rotation(-0.2, 0.4, 0.3), np.array([-0.3, 0.1, 4.0])),
            "rational": (rotation(0.5, 0.2, -0.4), np.array([0.2, -0.2, 6.0])),
            "barrel": (rotation(-0.4, -0.6, 1.2), np.array([0.0, 0.3, 5.5]))}
        self.targets = {
            f"f{i}": (rotation(0.3 * i, -0.5 * i, 0.2), np.array([0.1 * i, 0, 0]))
            for i in range(4)}

    def run_rig(self, shared):
        table, observations = made_up(self.rows, self.world, self.targets, shared)
        return self.calibrate(write(self.folder, "cameras.csv", table),
                              write(self.folder, "observations.csv",
                                    observations))

    def check_rig(self, names):
        rig = transforms(self.result("rig.csv"), "camera")
        self.assertEqual(list(rig), names)
        for name in names:
            R, t = relative(self.world[name], self.world[names[0]])
            angle = angle_deg(R, rig[name][0])
            length = np.linalg.norm(t - rig[name][1])
            measured(f"{name}: {angle:.1e} deg, {length:.1e}")
            self.assertLess(angle, 0.1 if FLOAT else 1e-6)
            self.assertLess(length, 0.01 if FLOAT else 1e-7)

    def test_every_lens_without_noise(self):
        run = self.run_rig({"f0": list(self.rows)})
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.check_rig(list(self.rows))

    def test_cameras_joined_through_others(self):
        run = self.run_rig({"f0": ["pinhole", "barrel"],
                            "f1": ["barrel", "fish"], "f2": ["fish", "rational"]})
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.check_rig(list(self.rows))
        self.assertEqual(len(read(self.result("targets.csv"))), 3)

    def test_two_groups_are_told_apart(self):
        run = self.run_rig({"f0": ["pinhole", "fish"],
                            "f1": ["rational", "barrel"]})
        self.assertEqual(run.returncode, 1)
        self.assertEqual(run.stderr.splitlines()[:2], [
            "rigcal: the cameras are disconnected, these groups share no frame: pinhole "
            "and fish; rational and barrel. rig.csv and pairs.csv have those of the group "
            "of pinhole only",
            "rigcal:   show the target to rational and pinhole together in a frame"])
        self.assertIn("frame f1 has no place in the frame of pinhole", run.stderr)
        self.assertIn("in the frame of pinhole", run.stdout)
        self.assertIn("in the frame of rational", run.stdout)
        self.check_rig(["pinhole", "fish"])
        self.assertEqual(len(read(self.result("poses.csv"))), 4)
        self.assertEqual([r["frame"] for r in read(self.result("targets.csv"))],
                         ["f0"])
        self.assertEqual(len(read(self.result("pairs.csv"))), 1)

    def test_camera_without_observations_is_named(self):
        run = self.run_rig({"f0": ["fish", "rational", "barrel"]})
        self.assertEqual(run.returncode, 1)
        self.assertIn("camera pinhole is not in the rig: there are no observations of it", run.stderr)
        self.check_rig(["fish", "rational", "barrel"])


class TestCaveats(CliTest):
    """Two cameras and three placements of a plate. In one of them the left camera sees four
    points that are close together."""

    ROWS = {name: camera_row(name) for name in ("left", "right")}
    RIGHT = (rotation(0.05, -0.7, 0.1), np.array([3.0, 0.1, 1.0]))

    def observations(self, seed):
        rng = np.random.default_rng(seed)
        grid = np.array([(x, y, 0) for x in range(5) for y in range(4)], float)
        lines, truth = ["frame,camera,point,X,Y,Z,u,v"], {}
        for frame in range(3):
            target = (rotation(0.5, 0.2 * frame - 0.4, 0.3 * frame),
                      np.array([-0.3, -0.2, 5 + 0.5 * frame]))
            for name in self.ROWS:
                truth[name, str(frame)] = target if name == "left" else \
                    compose(self.RIGHT, target)
                R, t = truth[name, str(frame)]
                X = 0.25 * grid
                uv = Camera(self.ROWS[name]).project(X @ R.T + t)
                uv = uv + 0.4 * rng.standard_normal(uv.shape)
                few = [0, 1, 4, 5] if (name, frame) == ("left", 2) else range(20)
                lines += [f"{frame},{name},{i}," + ",".join(
                    repr(x) for x in [*X[i].tolist(), *uv[i].tolist()])
                    for i in few]
        return lines, truth

    def run_on(self, lines):
        head = list(self.ROWS["left"])
        table = [head] + [[str(r[k]) for k in head] for r in self.ROWS.values()]
        run = self.calibrate(
            write(self.folder, "c.csv", "\n".join(",".join(r) for r in table)),
            write(self.folder, "o.csv", "\n".join(lines)))
        return run, {(r["camera"], r["frame"]): r
                     for r in read(self.result("poses.csv"))}

    def test_ambiguous_view_is_settled_by_other_frames(self):
        ambiguous = unlikely = 0
        for seed in range(40):
            lines, truth = self.observations(seed)
            run, poses = self.run_on(lines)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            row = poses["left", "2"]
            told = re.search(r"(?m)^left +2 +4 .*  ambiguous: 2nd pose "
                             r"([\d.]+) px, p ([\d.e-]+), settled by other frames$",
                             run.stdout)
            if "ambiguous" not in run.stdout:
                continue
            self.assertTrue(told, run.stdout)
            ambiguous += 1
            unlikely += float(row["probability"]) < 0.5
            self.assertLess(float(row["probability"]), 0.99)
            self.assertAlmostEqual(float(told[1]), float(row["second_rms_px"]),
                                   delta=0.006)
            self.assertAlmostEqual(float(told[2]) + float(row["probability"]), 1,
                                   delta=0.06)
            angle = angle_deg(transform(row)[0], truth["left", "2"][0])
            measured(f"p {float(row['probability']):.2f}: {angle:.1f} deg")
            self.assertLess(angle, 25)
        measured(f"{ambiguous} ambiguous, {unlikely} of them the less likely pose")
        self.assertGreater(ambiguous, 10)
        self.assertGreater(unlikely, 0)

    def test_ambiguous_view_alone_keeps_the_likeliest_pose(self):
        found = 0
        for seed in range(20):
            lines = [line for line in self.observations(seed)[0]
                     if line.startswith(("frame", "2,"))]
            run, poses = self.run_on(lines)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            told = re.search(r"(?m)^left +2 +4 .*  ambiguous: 2nd pose "
                             r"[\d.]+ px, p [\d.e-]+$", run.stdout)
            found += told is not None
            self.assertGreater(float(poses["left", "2"]["probability"]), 0.49)
        self.assertGreater(found, 4)

    def test_three_points_have_several_poses(self):
        lines = [line for line in self.observations(1)[0]
                 if not line.startswith("2,left,0,")]
        run, poses = self.run_on(lines)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertRegex(run.stdout, r"(?m)^left +2 +3 .* -  ambiguous: 2nd pose ")
        sigmas = [poses["left", "2"][k] for k in ADDED[:2]]
        self.assertEqual(sigmas, ["", ""])
        self.assertLess(float(poses["left", "2"]["second_rms_px"]), 0.01)
        self.assertNotIn("", [poses["right", "2"][k] for k in ADDED[:2]])


class TestWrongPoints(CliTest):
    """A dozen points in space, seen by two cameras. Some of them are wrong."""

    def observations(self, spoil):
        rng = np.random.default_rng(5)
        X = rng.uniform(-0.5, 0.5, (12, 3))
        lines = ["frame,camera,point,X,Y,Z,u,v"]
        for name, x in (("left", 0.3), ("right", -0.4)):
            uv = Camera(camera_row(name)).project(
                X @ rotation(0.2, x, 0.1).T + [0.1, x, 4])
            uv = uv + 0.3 * rng.standard_normal(uv.shape)
            if name == "right" or spoil == self.mirrored:
                X_told, uv = spoil(X.copy(), uv)
            else:
                X_told = X
            lines += [f"0,{name},p{i}," + ",".join(
                repr(x) for x in [*X_told[i].tolist(), *uv[i].tolist()])
                for i in range(12)]
        return lines

    def run_on(self, spoil, *more):
        rows = [camera_row(name) for name in ("left", "right")]
        table = [list(rows[0])] + [[str(r[k]) for k in rows[0]] for r in rows]
        return self.calibrate(
            write(self.folder, "c.csv", "\n".join(",".join(r) for r in table)),
            write(self.folder, "o.csv", "\n".join(self.observations(spoil))),
            None, *more)

    @staticmethod
    def none(X, uv):
        return X, uv

    @staticmethod
    def one(X, uv):
        uv[7] += [35, -20]
        return X, uv

    @staticmethod
    def three(X, uv):
        uv[[2, 5, 9]] = uv[[5, 9, 2]]
        return X, uv

    @staticmethod
    def mirrored(X, uv):
        return X * [1, -1, 1], uv

    def right(self):
        return transform(next(r for r in read(self.result("poses.csv"))
                              if r["camera"] == "right"))

    def test_the_point_to_blame_is_named(self):
        run = self.run_on(self.one)
        self.assertEqual(run.returncode, 0)
        told = re.search(r"camera right in frame 0: point p7 is wrong: without it "
                         r"the others fit to ([\d.]+) px rms, with it to ([\d.]+) "
                         r"px(?:; the view is left out of the rig)?\nrigcal:   correct it, "
                         r"remove its line, or use --robust\n", run.stderr)
        self.assertTrue(told, run.stderr)
        self.assertLess(float(told[1]), 0.7)
        self.assertGreater(float(told[2]), 3)
        self.assertNotIn("left", run.stderr)

    def test_causes_are_looked_for_in_the_first_views_that_fit_badly(self):
        lines = self.observations(self.one)
        right = [line for line in lines if ",right," in line]
        rows = [camera_row("right")]
        table = [list(rows[0])] + [[str(r[k]) for k in rows[0]] for r in rows]
        run = self.calibrate(
            write(self.folder, "c.csv", "\n".join(",".join(r) for r in table)),
            write(self.folder, "o.csv", "\n".join(
                [lines[0]] + [f"{frame}{line[1:]}" for frame in range(103)
                              for line in right])))
        self.assertEqual(run.returncode, 1, run.stderr)  # one camera, moved in each frame
        self.assertEqual(run.stderr.count("point p7 is wrong"), 100)
        self.assertIn("103 views fit badly: a cause was looked for in the first 100. ",
                      run.stderr)

    def test_a_mirrored_target_is_named(self):
        run = self.run_on(self.mirrored)
        self.assertIn("left-handed", run.stderr)
        self.assertNotIn("point p", run.stderr)

    def test_robust_leaves_wrong_points_out(self):
        self.run_on(self.none)
        truth = self.right()
        for more in ((), ("--threshold", "4", "--seed", "7")):
            run = self.run_on(self.three, "--robust", *more)
            self.assertEqual(run.returncode, 0)
            told = re.search("camera right in frame 0: --robust leaves out 3 of 12 "
                             "points: (.*)\n", run.stderr)[1]
            self.assertEqual(sorted(re.findall(r"(p\d+) \(\d+ px off\)", told)),
                             ["p2", "p5", "p9"])
            self.assertRegex(run.stdout, r"(?m)^right +0 +9 ")
            R, t = self.right()
            self.assertLess(angle_deg(R, truth[0]), 0.5)
            self.assertLess(np.linalg.norm(t - truth[1]), 0.03)

    def test_robust_without_wrong_points_changes_nothing(self):
        self.assertEqual(self.run_on(self.none).returncode, 0)
        plain = content(self.out, "poses.csv")
        run = self.run_on(self.none, "--robust")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(content(self.out, "poses.csv"), plain)

    def test_wrong_use(self):
        for more, word in ((["--threshold", "3"], "go with --robust"),
                           (["--seed", "3"], "go with --robust"),
                           (["--robust", "--method", "paper"], "--method paper"),
                           (["--robust", "--threshold", "0"], "--threshold"),
                           (["--robust", "--threshold", "x"], "--threshold"),
                           (["--robust", "--seed", "-1"], "--seed"),
                           (["--robust", "--seed", "1.5"], "--seed"),
                           (["--robust", "--seed", "4294967296"], "--seed")):
            run = self.run_on(self.none, *more)
            self.assertEqual(run.returncode, 2, more)
            self.assertIn(word, run.stderr)
            self.assertFalse(os.path.exists(self.out))


class TestUnsolvable(CliTest):
    def run_with(self, spoil, *options):
        """Calibrates after frame 03 of the right camera was spoiled."""
        head, *lines = content(STEREO, "observations.csv").splitlines()
        mine = [line for line in lines if line.startswith("03,right,")]
        rest = [line for line in lines if not line.startswith("03,right,")]
        path = write(self.folder, "observations.csv",
                     "\n".join([head, *rest, *spoil(mine)]) + "\n")
        return self.calibrate(STEREO + "/cameras.csv", path, None, *options)

    def check(self, run, reason):
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "camera right has no pose in frame 03")
        self.assertIn(reason, run.stderr)
        poses = read(self.result("poses.csv"))
        self.assertEqual(len(poses), 13)
        self.assertEqual(len(read(self.result("rig.csv"))), 2)
        self.assertEqual(len(read(self.result("targets.csv"))), 7)

    def test_too_few_points(self):
        self.check(self.run_with(lambda lines: lines[:2]), "sees 2 points there")

    def test_points_on_one_line(self):
        self.check(self.run_with(lambda lines: lines[:3]), "on one line")

    def test_pixel_that_no_ray_reaches(self):
        def spoil(lines):
            far = lines[5].split(",")
            return lines[:5] + [",".join(far[:6] + ["1e5", "-1e5"])] + lines[6:]
        run = self.run_with(spoil)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "camera right in frame 03: the lens model images no ray "
                                     "at the pixel of 1 of 54 points: 5;")
        poses = read(self.result("poses.csv"))
        self.assertEqual(len(poses), 14)
        spoiled = [row for row in poses if (row["camera"], row["frame"]) == ("right", "03")]
        self.assertEqual(spoiled[0]["n"], "53")
        self.assertLess(float(spoiled[0]["rms_px"]), 0.3)

    def test_several_pixels_that_no_ray_reaches(self):
        def spoil(lines):
            return [",".join(line.split(",")[:6] + ["1e5", "-1e5"]) if k % 9 == 0 else line
                    for k, line in enumerate(lines)]
        for robust in ((), ("--robust",)):
            run = self.run_with(spoil, *robust)
            self.assertEqual(run.returncode, 1)
            self.assertRegex(run.stderr, "pixels of 6 of 54 points: 0, 9, 18, 27, 36 and 1 more;")
            self.assertEqual(len(read(self.result("poses.csv"))), 14)
            self.assertNotIn("--robust leaves out 6", run.stderr)

    def test_pixels_outside_the_image_are_told(self):
        head, *lines = content(STEREO, "observations.csv").splitlines()
        for row, uv in ((9, ["-0.6", "5"]), (4, ["639.6", "5"]), (6, ["5", "479.6"]),
                        (7, ["5", "-0.4"]), (8, ["639.4", "479.4"])):
            lines[row] = ",".join(lines[row].split(",")[:6] + uv)
        path = write(self.folder, "o.csv", "\n".join([head, *lines]))
        run = self.calibrate(STEREO + "/cameras.csv", path)
        self.assertEqual(run.returncode, 1)  # the view contradicts the others
        self.assertEqual(run.stderr.split("\n")[0], f"rigcal: {path}: 3 pixels are outside "
                         "the image, the first on line 6: (639.6, 5) of camera left, "
                         "640 x 480. Check u, v, width and height")

    def test_frames_apart_are_named_in_one_line(self):
        lines = content(STEREO, "observations.csv").splitlines()
        for n_left, told in ((1, "frames 03, 05, 07, 09, 12 and 1 more have no place"),
                             (3, "frames 07, 09, 12, 14 have no place"),
                             (6, "frame 14 has no place")):
            frames = "01 03 05 07 09 12 14".split()
            mine = [f"{f},left," for f in frames[:n_left]]
            mine += [f"{f},right," for f in frames[n_left:]]
            run = self.calibrate(STEREO + "/cameras.csv", write(
                self.folder, "o.csv", "\n".join(
                    line for line in lines if line.startswith(("frame", *mine)))))
            self.assertEqual(run.returncode, 1)
            self.assertIn(f"rigcal: {told} in the frame of left: no camera joined to it "
                          "has a pose there\n", run.stderr)

    def test_nothing_can_be_solved(self):
        text = content(STEREO, "observations.csv").splitlines()[:3]
        run = self.calibrate(STEREO + "/cameras.csv",
                             write(self.folder, "o.csv", "\n".join(text)))
        self.assertEqual(run.returncode, 1)
        self.assertIn("camera left has no pose in frame 01", run.stderr)
        self.assertFalse(os.path.exists(self.out))


# ---- the form of files --------------------------------------------------------------

def permuted(text):
    rows = [line.split(",") for line in text.splitlines()]
    order = list(range(len(rows[0])))[::-1]
    lines = [",".join([row[i] for i in order] + [extra])
             for row, extra in zip(rows, ["note"] + ["-"] * len(rows))]
    return "\n".join(lines) + "\n"


class TestHarmlessForms(CliTest):
    FORMS = {
        "CRLF": lambda text: text.replace("\n", "\r\n"),
        "byte-order mark": lambda text: "\ufeff" + text,
        "blank lines": lambda text: "\n \n" + text.replace("\n", "\n\n\t\n"),
        # so that a block that is read at once ends at any place of a line
        "long blank lines": lambda text: text.replace("\n", "\n" + 4999 * " " + "\n"),
        "no last newline": lambda text: text.rstrip("\n"),
        "columns permuted": permuted,
        "all of it": lambda text: "\ufeff\r\n" + permuted(text).replace(
            "\n", "\r\n\r\n").rstrip("\r\n"),
    }

    def outputs(self, change):
        paths = [write(self.folder, name, change(content(STEREO, name)))
                 for name in ("cameras.csv", "observations.csv")]
        run = self.calibrate(*paths)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return [run.stdout] + [content(self.out, name) for name in OUTPUTS]

    def test_same_data_gives_the_same_bytes(self):
        plain = self.outputs(lambda text: text)
        for name, change in self.FORMS.items():
            with self.subTest(form=name):
                self.assertEqual(self.outputs(change), plain)

    def test_a_pipe_gives_the_same_bytes(self):
        plain = self.outputs(lambda text: text)
        cameras, pipe = os.path.join(STEREO, "cameras.csv"), os.path.join(self.folder, "pipe")
        text = content(STEREO, "observations.csv")
        os.mkfifo(pipe)

        def feed():
            with open(pipe, "w") as file:
                for begin in range(0, len(text), 1000):
                    file.write(text[begin:begin + 1000])
                    file.flush()

        feeder = threading.Thread(target=feed)
        feeder.start()
        run = self.calibrate(cameras, pipe)
        feeder.join()
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual([run.stdout] + [content(self.out, name) for name in OUTPUTS], plain)

    def test_coefficients_may_be_absent(self):
        table = content(CAVITY, "cameras.csv")
        rows = [line.split(",")[:7] for line in table.splitlines()]
        short = "\n".join(",".join(row) for row in rows) + "\n"
        run = self.calibrate(write(self.folder, "c.csv", short),
                             CAVITY + "/observations.csv")
        self.assertEqual(run.returncode, 0)

    def test_very_long_lines(self):
        wide = "".join(line + "," + "x" * 100000 + "\n"
                       for line in content(STEREO, "cameras.csv").splitlines())
        run = self.calibrate(write(self.folder, "c.csv", wide),
                             STEREO + "/observations.csv")
        self.assertEqual(run.returncode, 0)


# A change of a file, the line that the message must name, and the words of the message.
OBSERVATIONS_BROKEN = {
    "missing column": (at_line(1, lambda s: s.replace(",u,", ",w,")), 1,
                       "no column u"),
    "duplicate column": (at_line(1, lambda s: s.replace("point", "frame")), 1,
                         "column frame is there more than once"),
    "a field too few": (at_line(5, lambda s: s.rsplit(",", 1)[0]), 5,
                        "7 fields where the header has 8"),
    "a field too many": (at_line(6, lambda s: s + ",1"), 6, "9 fields"),
    "word": (at_line(4, field(6, "abc")), 4, 'column u: "abc" is not a number'),
    "number and more": (at_line(4, field(7, "1.5px")), 4, 'column v: "1.5px"'),
    "decimal comma": (at_line(4, field(7, "1;5")), 4, 'column v: "1;5"'),
    "blank before": (at_line(4, field(7, " 15")), 4, 'column v: " 15"'),
    "nan": (at_line(9, field(3, "nan")), 9, 'column X: "nan" is not a number'),
    "inf": (at_line(9, field(4, "-inf")), 9, 'column Y: "-inf"'),
    "hexadecimal": (at_line(9, field(5, "0x1p3")), 9, 'column Z: "0x1p3"'),
    "sign alone": (at_line(9, field(5, "-")), 9, 'column Z: "-"'),
    "point alone": (at_line(9, field(5, ".")), 9, 'column Z: "."'),
    "too large": (at_line(9, field(6, "1e999")), 9, "too large"),
    "no number": (at_line(3, field(6, "")), 3, "column u is empty"),
    "no id": (at_line(3, field(2, "")), 3, "column point is empty"),
    "blank in id": (at_line(3, field(0, "0 1")), 3, "column frame"),
    "quotes": (at_line(3, field(0, '"01"')), 3, "column frame"),
    "unknown camera": (at_line(12, field(1, "middle")), 12,
                       "camera middle is not in"),
    "seen twice": (again(2, 40), 40, "point 0 of this camera and frame is on line 2"),
    "other coordinates": (at_line(384, field(3, "0.9")), 384,
                          "point 4 has other coordinates .* line 6"),
    "header only": (lambda text: text.split("\n")[0] + "\n", 1, "no data"),
    "empty": (lambda text: "", 1, "no header"),
    "blank lines only": (lambda text: "\n\n\r\n", 1, "no header"),
    "NUL": (at_line(7, lambda s: s[:3] + "\0" + s[4:]), 7, "byte 0"),
    "UTF-16": (lambda text: text.encode("utf-16"), 1, "text in UTF-16"),
    "binary": (lambda text: bytes(range(256)) * 4, 1, "byte 0"),
    "old line ends": (lambda text: text.replace("\n", "\r"), 1, "line ends of old Macs"),
}
CAMERAS_BROKEN = {
    "missing column": (at_line(1, lambda s: s.replace("fx", "f")), 1,
                       "no column fx"),
    "duplicate column": (at_line(1, lambda s: s.replace("k2", "k1")), 1,
                         "column k1 is there more than once"),
    "focal zero": (at_line(2, field(3, "0")), 2, "column fx: .*positive"),
    "focal negative": (at_line(3, field(4, "-5")), 3, "column fy: .*positive"),
    "width zero": (at_line(3, field(1, "0")), 3, "column width"),
    "height broken": (at_line(3, field(2, "480.5")), 3, "column height"),
    "size absurd": (at_line(3, field(1, "1e7")), 3, "column width"),
    "duplicate camera": (at_line(3, field(0, "left")), 3,
                         "camera left is on line 2 already"),
    "unnamed camera": (at_line(3, field(0, "")), 3, "column camera is empty"),
    "nan": (at_line(2, field(7, "NaN")), 2, "column k1"),
    "unknown lens": (lambda text: "\n".join(
        line + ("," + ("lens" if i == 0 else "mirror"))
        for i, line in enumerate(text.splitlines())), 2,
        'column lens: "mirror"'),
    "fisheye with p1": (lambda text: "\n".join(
        line + ("," + ("lens" if i == 0 else "fisheye"))
        for i, line in enumerate(text.splitlines())), 2, "fisheye"),
    "header only": (lambda text: text.split("\n")[0], 1, "no data"),
}
RIG_BROKEN = {
    "missing column": (at_line(1, lambda s: s.replace("R23", "R32")), 1,
                       "R32|R23"),
    "unknown camera": (at_line(3, field(0, "middle")), 3, "middle is not in"),
    "duplicate camera": (at_line(3, field(0, "left")), 3, "left is on line 2"),
    "no rotation": (at_line(3, field(1, "0.99")), 3, "not a rotation"),
    "mirror": (at_line(2, field(9, "-1")), 2, "not a rotation"),
    "no number": (at_line(3, field(12, "x")), 3, 'column tz: "x"'),
}


class TestBrokenFiles(CliTest):
    def broken(self, name, source, change):
        return write(self.folder, name, change(content(source, name)))

    def complains(self, run, path, line, words):
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(run.stdout, "")
        self.assertRegex(run.stderr, rf"\A{re.escape(path)}:{line}: .*(?:{words})")
        self.assertEqual(run.stderr.count("\n"), 1)

    def writes_nothing(self, cameras_csv, observations_csv):
        """Calibrates without and with an earlier result in the folder."""
        first = self.calibrate(cameras_csv, observations_csv)
        self.assertFalse(os.path.exists(self.out))
        old = os.path.join(self.folder, "old")
        os.mkdir(old)
        for name in OUTPUTS:
            write(old, name, "as it was")
        second = self.calibrate(cameras_csv, observations_csv, old)
        self.assertEqual(sorted(os.listdir(old)), sorted(OUTPUTS))
        for name in OUTPUTS:
            self.assertEqual(content(old, name), "as it was")
            os.remove(os.path.join(old, name))
        os.rmdir(old)
        self.assertEqual(first.stderr, second.stderr)
        return first

    def test_broken_observations(self):
        for kind, (change, line, words) in OBSERVATIONS_BROKEN.items():
            with self.subTest(kind=kind):
                path = self.broken("observations.csv", STEREO, change)
                run = self.writes_nothing(STEREO + "/cameras.csv", path)
                self.complains(run, path, line, words)

    def test_broken_cameras(self):
        for kind, (change, line, words) in CAMERAS_BROKEN.items():
            with self.subTest(kind=kind):
                path = self.broken("cameras.csv", STEREO, change)
                run = self.writes_nothing(path, STEREO + "/observations.csv")
                self.complains(run, path, line, words)

    def test_broken_rig(self):
        for kind, (change, line, words) in RIG_BROKEN.items():
            with self.subTest(kind=kind):
                path = write(self.folder, "rig.csv",
                             change(content(STEREO, "reference_rig.csv")))
                run = rigcal("triangulate", "--cameras", STEREO + "/cameras.csv",
                             "--rig", path, "--observations",
                             STEREO + "/observations.csv")
                self.complains(run, path, line, words)

    def test_broken_targets(self):
        text = content(STEREO, "reference_targets.csv")
        path = write(self.folder, "targets.csv", again(3, 5)(text))
        run = rigcal("triangulate", "--cameras", STEREO + "/cameras.csv",
                     "--rig", STEREO + "/reference_rig.csv", "--observations",
                     STEREO + "/observations.csv", "--targets", path)
        self.complains(run, path, 5, "frame 03 is on line 3 already")

    def test_lines_are_counted_with_blank_ones_and_carriage_returns(self):
        change = at_line(4, field(6, "abc"))
        text = change(content(STEREO, "observations.csv"))
        path = write(self.folder, "observations.csv",
                     text.replace("\n", "\r\n\r\n"))
        run = self.calibrate(STEREO + "/cameras.csv", path)
        self.complains(run, path, 7, 'column u: "abc"')

    def test_lines_are_counted_in_a_file_read_in_parts(self):
        text = content(STEREO, "observations.csv").rstrip("\n")
        count = text.count("\n") + 1
        text = at_line(count, field(6, "abc"))(text)
        path = write(self.folder, "observations.csv",
                     text.replace("\n", "\n" + 4999 * " " + "\n"))
        run = self.calibrate(STEREO + "/cameras.csv", path)
        self.complains(run, path, 2 * count - 1, 'column u: "abc"')

    def test_unreadable_files(self):
        absent = os.path.join(self.folder, "absent.csv")
        for path in (absent, self.folder):
            run = self.calibrate(path, STEREO + "/observations.csv")
            self.assertEqual(run.returncode, 2)
            self.assertRegex(run.stderr, rf"{re.escape(path)}: \w")
            self.assertFalse(os.path.exists(self.out))

    def test_folder_that_cannot_be_written(self):
        occupied = write(self.folder, "occupied", "a file")
        for out in (occupied, os.path.join(occupied, "no", "such")):
            run = self.calibrate(STEREO + "/cameras.csv",
                                 STEREO + "/observations.csv", out)
            self.assertEqual(run.returncode, 2)
            self.assertIn(f"cannot write {occupied}: Not a directory", run.stderr)
        self.assertEqual(content(self.folder, "occupied"), "a file")

    def test_folder_where_one_file_cannot_be_replaced(self):
        os.makedirs(os.path.join(self.out, "targets.csv"))
        write(self.out, "poses.csv", "as it was")
        run = self.calibrate_set(STEREO)
        self.assertEqual(run.returncode, 2)
        self.assertIn("targets.csv", run.stderr)
        self.assertEqual(content(self.out, "poses.csv"), "as it was")
        self.assertEqual(sorted(os.listdir(self.out)),
                         ["poses.csv", "targets.csv"])


# ---- wrong use ------------------------------------------------------------------------

class TestUse(CliTest):
    LINE = ["line", "--cameras", STEREO + "/cameras.csv", "--rig",
            STEREO + "/reference_rig.csv", "--from", "left", "--to", "right",
            "--pixel", "300,200"]

    def refuses(self, arguments, *words):
        run = rigcal(*arguments)
        self.assertEqual((run.returncode, run.stdout), (2, ""), run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)

    def test_wrong_use_is_named_and_leads_to_help(self):
        both = ["--cameras", "c.csv", "--observations", "o.csv"]
        for arguments, word in (
                ([], "give a command"),
                (["calibrat"], 'no command "calibrat"'),
                (["help"], 'no command "help"'),
                (["calibrate"], "needs --cameras"),
                (["calibrate", "--cameras", "c.csv"], "needs --observations"),
                (["calibrate", *both, "--frob"], "has no option --frob"),
                (["calibrate", *both, "-xy"], "has no option -x"),
                (["calibrate", *both, "--help=me"], "--help=me"),
                (["calibrate", *both, "--rig", "r"], "has no option --rig"),
                (["calibrate", *both, "--out"], "--out needs a value"),
                (["line", "--method", "ml"], "has no option --method"),
                (["calibrate", *both, "extra"], 'takes options only, not "extra"'),
                (["triangulate", *both, "--robust"], "has no option --robust"),
                (["line", "--robust"], "has no option --robust"),
                (["calibrate", *both, "--robust", "--robust"], "given twice"),
                (["calibrate", *both, *both], "given twice"),
                (["triangulate", *both], "needs --rig"),
                (self.LINE[:-2], "needs --pixel"),
                (self.LINE + ["--depth", "1"], '"1"')):
            with self.subTest(arguments=arguments):
                self.refuses(arguments, word, "--help")

    def test_method(self):
        for method in ("", "p3p", "Paper", "ml,paper"):
            self.refuses(["calibrate", "--cameras", STEREO + "/cameras.csv",
                          "--observations", STEREO + "/observations.csv",
                          "--method", method], f'ml or paper, not "{method}"')

    def test_numbers_of_options(self):
        for pixel in ("300", "300,", "300,200,1", "a,b", "300 200", "nan,1"):
            self.refuses(self.LINE[:-1] + [pixel], "--pixel", pixel)
        for depth in ("1,1", "2,1", "0,1", "-1,1"):
            self.refuses(self.LINE + ["--depth", depth], "--depth", depth)
        for sigma in ("0", "-1", "x"):
            self.refuses(["triangulate", *self.LINE[1:5], "--observations",
                          STEREO + "/observations.csv", "--sigma", sigma],
                         "--sigma", sigma)

    def test_cameras_of_a_line(self):
        for option in ("left", "middle"):
            arguments = list(self.LINE)
            arguments[8] = option
            self.refuses(arguments, option)
        self.refuses(self.LINE[:-1] + ["640,10"], "outside the image")

    def test_help_and_version(self):
        for arguments in (["--help"], ["-h"], ["calibrate", "--help"],
                          ["line", "--help"]):
            run = rigcal(*arguments)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            for word in ("calibrate", "triangulate", "line", "--observations",
                         "--method", "--sigma", "--robust", "FORMAT.md"):
                self.assertIn(word, run.stdout)
        run = rigcal("--version")
        self.assertEqual(rigcal("line", "--version").stdout, run.stdout)
        self.assertRegex(run.stdout, r"\Arigcal \d+\.\d+\.\d+ \((double|float)\)\n")
        header = content(os.path.join(ROOT, "include"), "rigcal.h")
        numbers = re.findall(r"#define RIGCAL_VERSION_\w+ (\d+)", header)
        self.assertIn(" " + ".".join(numbers) + " ", run.stdout)

    @unittest.skipUnless(os.path.exists("/dev/full"), "needs /dev/full")
    def test_output_that_cannot_be_written(self):
        with open("/dev/full", "w") as full:
            run = subprocess.run([BIN, *self.LINE], stdout=full,
                                 stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertIn("standard output", run.stderr)


# ---- triangulate ----------------------------------------------------------------------

class TestTriangulate(CliTest):
    def triangulate(self, folder, rig, targets=None, observations=None, *more):
        arguments = ["triangulate", "--cameras", folder + "/cameras.csv",
                     "--rig", rig, "--observations",
                     observations or folder + "/observations.csv", *more]
        if targets:
            arguments += ["--targets", targets]
        return rigcal(*arguments)

    def points(self, run):
        return {(r["frame"], r["point"]): r for r in read(run.stdout)}

    def position(self, row):
        return np.array([float(row[k]) for k in "XYZ"])

    def sigma(self, row):
        return np.array([float(row["sigma_" + k]) for k in "XYZ"])

    def with_reference(self, folder, observations="observations.csv", *more):
        return self.triangulate(folder, folder + "/reference_rig.csv",
                                folder + "/reference_targets.csv",
                                os.path.join(folder, observations), *more)

    def test_agrees_with_the_reference_triangulation(self):
        for folder, name, limit in (
                (STEREO, "triangulation", 1e-8), (CAVITY, "triangulation", 1e-5),
                (CAVITY, "checkpoints", 1e-5), (STEPPED, "triangulation", 1e-5),
                (STEPPED, "checkpoints", 1e-5), (SCENE, "triangulation", 1e-7)):
            source = "checkpoints.csv" if name == "checkpoints" else \
                "observations.csv"
            run = self.with_reference(folder, source)
            self.assertEqual(run.returncode, 0, run.stderr[:500])
            found = self.points(run)
            known = {(r["frame"], r["point"]): r
                     for r in read(f"{folder}/reference_{name}.csv")}
            self.assertEqual(sorted(found), sorted(known))
            off = [np.linalg.norm(self.position(found[k]) - [
                float(r[c]) for c in ("Xt", "Yt", "Zt")])
                for k, r in known.items()]
            measured(f"{os.path.basename(folder)} {name}: {max(off):.1e} at most")
            self.assertLess(max(off), limit * (5000 if FLOAT else 1))
            for k, r in known.items():
                self.assertEqual(r["ncams"], found[k]["ncams"])
                self.assertAlmostEqual(float(r["rms_px"]),
                                       float(found[k]["rms_px"]),
                                       delta=0.01 if FLOAT else 1e-5)

    def board_rms(self, run):
        self.assertEqual(run.returncode, 0, run.stderr[:500])
        board = {(r["frame"], r["point"]): self.position(r)
                 for r in read(STEREO + "/observations.csv")}
        found = self.points(run)
        self.assertEqual(len(found), 378)
        off = [np.linalg.norm(self.position(r) - board[k])
               for k, r in found.items()]
        return np.sqrt(np.mean(np.square(off)))

    def test_corners_are_on_the_board(self):
        rms = self.board_rms(self.with_reference(STEREO))
        measured(f"with the reference rig {1000 * rms:.3f} mm rms")
        self.assertLess(rms, 6e-4)
        self.calibrate_well(STEREO)
        rms = self.board_rms(self.triangulate(
            STEREO, self.result("rig.csv"), self.result("targets.csv")))
        measured(f"with its own calibration {1000 * rms:.3f} mm rms")
        self.assertLess(rms, 1e-3)

    def test_frame_of_the_first_camera_without_targets(self):
        rig = STEREO + "/reference_rig.csv"
        in_rig = self.points(self.triangulate(STEREO, rig, None, None,
                                              "--sigma", "0.5"))
        in_target = self.points(self.with_reference(
            STEREO, "observations.csv", "--sigma", "0.5"))
        targets = transforms(STEREO + "/reference_targets.csv", "frame")
        for key, row in in_rig.items():
            R, t = targets[key[0]]
            np.testing.assert_allclose(
                R @ self.position(in_target[key]) + t, self.position(row),
                atol=1e-6 if FLOAT else 1e-9)
            # A rotation turns the ellipsoid but keeps the sum of its axes.
            np.testing.assert_allclose(
                np.linalg.norm(self.sigma(in_target[key])),
                np.linalg.norm(self.sigma(row)), rtol=1e-3 if FLOAT else 1e-9)

    def test_sigma_is_that_of_propagated_noise(self):
        found = self.points(self.triangulate(
            STEREO, STEREO + "/reference_rig.csv", None, None, "--sigma", "0.3"))
        rig = transforms(STEREO + "/reference_rig.csv", "camera")
        camera = cameras(STEREO)
        for key in list(found)[::40]:
            X = self.position(found[key])

            def pixels(point):
                return np.concatenate([camera[c].project(R @ point + t)
                                       for c, (R, t) in rig.items()])
            J = np.stack([(pixels(X + h) - pixels(X - h)) / 2e-6
                          for h in 1e-6 * np.eye(3)], 1)
            Sigma = 0.09 * np.linalg.inv(J.T @ J)
            np.testing.assert_allclose(self.sigma(found[key]),
                                       np.sqrt(np.diag(Sigma)),
                                       rtol=0.02 if FLOAT else 1e-4)

    def test_sigma_is_estimated_from_the_residuals(self):
        run = self.with_reference(CAVITY)
        rows = self.points(run)
        sse = sum(int(r["ncams"]) * float(r["rms_px"])**2 for r in rows.values())
        freedom = sum(2 * int(r["ncams"]) - 3 for r in rows.values())
        told = float(re.search(r"estimated from 58 points: (\S+)",
                               run.stderr).group(1))
        self.assertAlmostEqual(told, np.sqrt(sse / freedom), delta=1e-3)
        given = self.with_reference(CAVITY, "observations.csv", "--sigma",
                                    str(2 * told))
        self.assertIn("as given", given.stderr)
        for key, row in self.points(given).items():
            np.testing.assert_allclose(self.sigma(row),
                                       2 * self.sigma(rows[key]), rtol=1e-3)

    def test_coordinates_of_the_target_are_not_needed(self):
        rows = [line.split(",") for line in
                content(STEREO, "observations.csv").splitlines()]
        path = write(self.folder, "o.csv", "\n".join(
            ",".join(row[:3] + row[6:]) for row in rows))
        run = self.triangulate(STEREO, STEREO + "/reference_rig.csv", None, path)
        full = self.triangulate(STEREO, STEREO + "/reference_rig.csv")
        self.assertEqual((run.returncode, run.stdout), (0, full.stdout))

    def test_point_that_cannot_be_measured_is_named(self):
        text = content(STEREO, "observations.csv")
        far = next(i for i, line in enumerate(text.split("\n"), 1)
                   if line.startswith("01,right,2,"))
        path = write(self.folder, "o.csv", at_line(far, lambda line: ",".join(
            line.split(",")[:6] + ["1e5", "1e5"]))(text))
        run = self.with_reference(STEREO, path)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "frame 01, point 2 cannot be triangulated: ")
        self.assertEqual(len(self.points(run)), 377)

    def test_of_many_such_points_five_are_named(self):
        text = content(STEREO, "observations.csv").splitlines()
        for i, line in enumerate(text):
            if line.startswith("01,right,"):
                text[i] = ",".join(line.split(",")[:6] + ["1e5", "1e5"])
        run = self.with_reference(STEREO, write(self.folder, "o.csv", "\n".join(text)))
        self.assertEqual(run.returncode, 1)
        self.assertEqual(len(re.findall(r"frame 01, point \d+ cannot be", run.stderr)),
                         5)
        self.assertEqual(run.stderr.count("more points cannot be triangulated"), 1)
        self.assertEqual(len(self.points(run)), 324)

    def test_frame_without_a_place_is_named(self):
        text = content(STEREO, "reference_targets.csv").splitlines()
        path = write(self.folder, "t.csv", "\n".join(text[:-1]))
        run = self.triangulate(STEREO, STEREO + "/reference_rig.csv", path)
        self.assertEqual(run.returncode, 1)
        self.assertEqual(run.stderr.count("frame 14 has no place"), 1)
        self.assertEqual(len(self.points(run)), 324)

    def test_points_seen_once_are_left_out(self):
        text = content(STEREO, "reference_rig.csv").splitlines()
        path = write(self.folder, "r.csv", "\n".join(text[:2]))
        run = self.triangulate(STEREO, path)
        self.assertEqual(run.returncode, 1)
        self.assertIn("right is not in", run.stderr)
        self.assertIn("no point could be measured", run.stderr)
        self.assertEqual(len(run.stdout.splitlines()), 1)


# ---- line -----------------------------------------------------------------------------

def epiline(camera_b, b_from_a, ray):
    """The matching line in undistorted pixels of b, from two points of the ray."""
    R, t = b_from_a
    K = np.array([[camera_b.f[0], 0, camera_b.c[0]],
                  [0, camera_b.f[1], camera_b.c[1]], [0, 0, 1]])
    line = np.cross(K @ t, K @ (R @ ray))
    return line / np.linalg.norm(line[:2])


class TestLine(CliTest):
    def rows(self, run):
        self.assertIn(run.returncode, (0, 1), run.stderr)
        return {r["quantity"]: np.array([float(r[k]) for k in
                                         ("v1", "v2", "v3", "v4") if r[k]])
                for r in read(run.stdout)}

    def line(self, rig, pixel, *more, cameras_csv=STEREO + "/cameras.csv"):
        return rigcal("line", "--cameras", cameras_csv, "--rig", rig,
                      "--from", "left", "--to", "right",
                      "--pixel", f"{pixel[0]!r},{pixel[1]!r}", *more)

    def test_true_matches_lie_on_their_line(self):
        self.calibrate_well(STEREO)
        camera = cameras(STEREO)
        path = self.result("rig.csv")
        b_from_a = transforms(path, "camera")["right"]
        views = observed_views(STEREO + "/observations.csv")
        distances = []
        for frame in sorted({f for _, f in views}):
            left, right = views["left", frame][1], views["right", frame][1]
            for i, (uv_a, uv_b) in enumerate(zip(left.tolist(), right)):
                known = epiline(camera["right"], b_from_a, camera["left"].ray(uv_a))
                seen = camera["right"].straight(camera["right"].ray(uv_b))
                distances.append(known @ np.append(seen, 1))
                if i % 11 == 0:
                    found = self.rows(self.line(path, uv_a))["line"]
                    found = found * np.sign(found[:2] @ known[:2])
                    np.testing.assert_allclose(
                        found, known, rtol=0,
                        atol=0.05 if FLOAT else 1e-6)
        rms = np.sqrt(np.mean(np.square(distances)))
        measured(f"{len(distances)} matches: {rms:.3f} px rms, "
                 f"{max(map(abs, distances)):.3f} px at most")
        self.assertEqual(len(distances), 378)
        self.assertLess(rms, 0.4)
        self.assertLess(max(map(abs, distances)), 1.4)

    def test_ends_lie_on_the_line_and_on_the_border(self):
        rows = self.rows(self.line(STEREO + "/reference_rig.csv", (300, 200)))
        line, ends = rows["line"], rows["ends"].reshape(2, 2)
        self.assertAlmostEqual(np.hypot(line[0], line[1]), 1,
                               delta=1e-6 if FLOAT else 1e-11)
        np.testing.assert_allclose(ends @ line[:2] + line[2], 0,
                                   atol=1e-3 if FLOAT else 1e-8)
        size = cameras(STEREO)["right"].size
        for end in ends:
            border = np.min(np.abs(np.concatenate([end + 0.5, end - size + 0.5])))
            self.assertAlmostEqual(border, 0, delta=1e-3 if FLOAT else 1e-9)

    def test_ends_of_a_depth_range(self):
        rig = STEREO + "/reference_rig.csv"
        R, t = transforms(rig, "camera")["right"]
        camera = cameras(STEREO)
        pixel, depths = (500.25, 120.5), (0.25, 2.0)
        rows = self.rows(self.line(rig, pixel, "--depth", "0.25,2"))
        self.assertEqual(list(rows), ["line", "ends", "depth_ends",
                                      "depth_ends_image"])
        X = [R @ (z * camera["left"].ray(pixel)) + t for z in depths]
        tolerance = 0.02 if FLOAT else 1e-6
        np.testing.assert_allclose(rows["depth_ends"],
                                   camera["right"].straight(X).ravel(),
                                   atol=tolerance)
        np.testing.assert_allclose(rows["depth_ends_image"],
                                   camera["right"].project(X).ravel(),
                                   atol=tolerance)

    def made_up(self, t, R=np.eye(3)):
        head = content(STEREO, "reference_rig.csv").split("\n")[0]
        one = "left,1,0,0,0,1,0,0,0,1,0,0,0"
        two = "right," + ",".join(repr(float(x)) for x in [*R.ravel(), *t])
        rig = write(self.folder, "rig.csv", "\n".join([head, one, two]) + "\n")
        table = "camera,width,height,fx,fy,cx,cy\n" + "".join(
            f"{name},640,480,500,500,320,240\n" for name in ("left", "right"))
        return rig, write(self.folder, "cameras.csv", table)

    def test_the_image_of_the_other_camera_is_named(self):
        rig, table = self.made_up([0, 0, -1])
        run = self.line(rig, (320.0, 240.0), cameras_csv=table)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "line: .*other camera's centre")

    def test_line_outside_the_image_is_named(self):
        rig, table = self.made_up([-1, 0, 0], rotation(1.0, 0, 0))
        run = self.line(rig, (320.0, 240.0), cameras_csv=table)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, "ends: .*does not cross the image")
        self.assertEqual(list(self.rows(run)), ["line"])

    def test_depths_behind_the_other_camera_are_named(self):
        rig, table = self.made_up([0.1, 0, -1])
        run = self.line(rig, (300.0, 200.0), "--depth", "0.5,3", cameras_csv=table)
        self.assertEqual(run.returncode, 1)
        self.assertIn("depth_ends: ", run.stderr)
        self.assertIn("camera right cannot see all of that depth range",
                      run.stderr)
        self.assertIn("depth_ends_image", self.rows(run))
        run = self.line(rig, (300.0, 200.0), "--depth", "0.2,0.5",
                        cameras_csv=table)
        self.assertEqual(run.returncode, 1)
        self.assertIn("depth_ends_image: ", run.stderr)


# ---- the other files --------------------------------------------------------------

def load_tests(loader, tests, _):
    here = os.path.dirname(os.path.abspath(__file__))
    for path in sorted(glob.glob(os.path.join(here, "test_*.py")) + glob.glob(
            os.path.join(here, "..", "regression", "cli_*.py"))):
        if os.path.samefile(path, __file__):
            continue
        name = os.path.splitext(os.path.basename(path))[0]
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        tests.addTests(loader.loadTestsFromModule(module))
    return tests


if __name__ == "__main__":
    unittest.main()
