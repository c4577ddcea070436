"""calibrate's --sigma and --robust, and residuals.csv."""
import os
import re
import unittest

import numpy as np

from cli_support import (CAVITY, FLOAT, STEREO, Camera, CliTest, camera_row, cameras,
                         compose, content, observed_views, read, rigcal, rotation,
                         transforms, write)

POSE = rotation(0.2, -0.4, 0.1), np.array([0.1, -0.4, 4])


class OptionsTest(CliTest):
    def one_view(self, X, uv, *more, camera=camera_row("cam")):
        """Calibrates a camera that sees X at uv. Returns the line of poses.csv."""
        lines = ["frame,camera,point,X,Y,Z,u,v"] + [
            f"0,cam,p{i}," + ",".join(repr(x) for x in [*x_w, *px])
            for i, (x_w, px) in enumerate(zip(np.asarray(X).tolist(),
                                              np.asarray(uv).tolist()))]
        table = [",".join(camera), ",".join(str(v) for v in camera.values())]
        run = self.calibrate(write(self.folder, "c.csv", "\n".join(table)),
                             write(self.folder, "o.csv", "\n".join(lines)), None, *more)
        self.assertIn(run.returncode, (0, 1))
        return run, read(self.result("poses.csv"))[0] if os.path.exists(self.out) else None


class TestSigma(OptionsTest):
    def columns(self, *more):
        run = self.calibrate_set(STEREO, *more)
        self.assertEqual(run.returncode, 1 if run.stderr else 0)
        rows = read(self.result("poses.csv"))
        return run, {k: np.array([float(r[k]) for r in rows])
                     for k in ("n", "rms_px", "sigma_rot_deg", "sigma_pos")}

    def test_uncertainties_are_for_the_noise_that_is_given(self):
        run, estimated = self.columns()
        self.assertIn("for noise as large as its residuals\n", run.stdout)
        # The estimate from the residuals: sum(du^2 + dv^2) / (2 n - 6).
        noise = estimated["rms_px"] * np.sqrt(estimated["n"] /
                                              (2 * estimated["n"] - 6))
        for sigma in (0.2, 0.5):
            run, given = self.columns("--sigma", str(sigma))
            self.assertEqual(run.stderr, "")
            self.assertIn(f"for noise of {sigma} px\n", run.stdout)
            for name in ("sigma_rot_deg", "sigma_pos"):
                np.testing.assert_allclose(given[name], estimated[name] * sigma / noise,
                                           rtol=1e-3 if FLOAT else 1e-6)

    def test_the_fit_is_judged_by_it(self):
        run, _ = self.columns("--sigma", "0.05")
        self.assertRegex(run.stderr, r"\Arigcal: --sigma 0\.05 is too small: 14 of 14 views "
                         r"fit worse than that, most to 0\.1\d+ px\nrigcal:   state the noise")

    def test_three_points_have_uncertainties_when_it_is_given(self):
        X = [[0, 0, 0], [1, 0, 0], [0, 1, 0.2]]
        uv = Camera(camera_row("cam")).project(X @ POSE[0].T + POSE[1])
        _, row = self.one_view(X, uv)
        self.assertEqual((row["sigma_rot_deg"], row["sigma_pos"]), ("", ""))
        _, row = self.one_view(X, uv, "--sigma", "0.3")
        self.assertGreater(float(row["sigma_rot_deg"]), 0.01)
        self.assertGreater(float(row["sigma_pos"]), 0.001)

    def test_robust_leaves_out_what_is_four_times_as_far(self):
        X = np.random.default_rng(3).uniform(-0.5, 0.5, (20, 3))
        uv = Camera(camera_row("cam")).project(X @ POSE[0].T + POSE[1])
        uv[4] += [5, 0]
        for more, n in (((), 19), (("--sigma", "0.5"), 19), (("--sigma", "2"), 20),
                        (("--sigma", "0.5", "--threshold", "9"), 20)):
            with self.subTest(options=more):
                _, row = self.one_view(X, uv, "--robust", *more)
                self.assertEqual(int(row["n"]), n)

    def test_one_range_for_both_commands(self):
        files = ["--cameras", STEREO + "/cameras.csv", "--observations",
                 STEREO + "/observations.csv"]
        for sigma in ("0", "-1", "1e-7", "1e7", "nan", "x", "1,2", ""):
            told = [rigcal(*command, *files, "--sigma", sigma) for command in (
                ["calibrate"], ["triangulate", "--rig", STEREO + "/reference_rig.csv"])]
            for run in told:
                self.assertEqual((run.returncode, run.stdout), (2, ""), sigma)
                self.assertIn(f'not "{sigma}"', run.stderr)
            self.assertEqual(told[0].stderr, told[1].stderr)
        run = self.calibrate_set(STEREO, "--sigma", "1e-6")
        self.assertEqual(run.returncode, 1)  # no view fits as well as that
        self.assertTrue(run.stderr.startswith("rigcal: --sigma 1e-06 is too small: 14 of 14"))

    def test_it_does_not_go_with_the_published_procedure(self):
        for option in (["--sigma", "1"], ["--robust"]):
            run = self.calibrate_set(STEREO, "--method", "paper", *option)
            self.assertEqual((run.returncode, run.stdout), (2, ""))
            self.assertIn(f"{option[0]} does not go with --method paper", run.stderr)


class TestLeftOut(OptionsTest):
    def test_a_view_has_one_line_however_many_are_left_out(self):
        X = np.random.default_rng(3).uniform(-0.5, 0.5, (40, 3))
        uv = Camera(camera_row("cam")).project(X @ POSE[0].T + POSE[1])
        for k in range(9):
            uv[k] += [20 + 5 * k, 0]
        run, row = self.one_view(X, uv, "--robust")
        self.assertEqual(row["n"], "31")
        first, second = run.stderr.splitlines()
        self.assertEqual(first, "rigcal: camera cam in frame 0: --robust leaves out 9 of 40 "
                                "points: p8 (60 px off), p7 (55 px off), p6 (50 px off), "
                                "p5 (45 px off), p4 (40 px off) and 4 more")
        self.assertEqual(second, f"rigcal: {self.out}/residuals.csv lists all of them")
        out = [r["point"] for r in read(self.result("residuals.csv"))
               if r["left_out"] == "1"]
        self.assertEqual(out, [f"p{k}" for k in range(9)])

    def test_without_out_it_is_told_how_to_get_all(self):
        self.one_view(*self.scene(8), "--robust")
        run = rigcal("calibrate", "--cameras", self.folder + "/c.csv", "--observations",
                     self.folder + "/o.csv", "--robust")
        self.assertRegex(run.stderr, "with --out FOLDER, FOLDER/residuals.csv lists all")

    def scene(self, n_wrong):
        X = np.random.default_rng(3).uniform(-0.5, 0.5, (40, 3))
        uv = Camera(camera_row("cam")).project(X @ POSE[0].T + POSE[1])
        uv[:n_wrong] += 30
        return X, uv

    def test_a_few_are_all_named(self):
        run, _ = self.one_view(*self.scene(5), "--robust")
        self.assertEqual(run.stderr.count("\n"), 1)
        self.assertEqual(run.stderr.count(" px off)"), 5)
        self.assertNotIn("more", run.stderr)

    def test_a_point_behind_the_camera_is_the_first(self):
        X, uv = self.scene(2)
        X[7] = POSE[0].T @ (np.array([0, 0, -3]) - POSE[1])
        run, _ = self.one_view(X, uv, "--robust")
        self.assertIn("3 of 40 points: p7 (where the camera cannot see it), p",
                      run.stderr)
        row = read(self.result("residuals.csv"))[7]
        self.assertEqual([row[k] for k in ("point", "du", "dv", "error_px", "left_out")],
                         ["p7", "", "", "", "1"])

    def test_views_of_few_points_are_told(self):
        X, uv = self.scene(0)
        run, row = self.one_view(X[:4], uv[:4], "--robust")
        self.assertEqual(row["n"], "4")
        self.assertIn("--robust takes 5 points in a view: in 1 view of fewer all points "
                      "count", run.stderr)


class TestResiduals(CliTest):
    def check(self, folder, *more):
        self.assertEqual(self.calibrate_set(folder, *more).returncode, 0)
        camera = cameras(folder)
        poses = {(r["camera"], r["frame"]): r for r in read(self.result("poses.csv"))}
        rig = transforms(self.result("rig.csv"), "camera")
        targets = transforms(self.result("targets.csv"), "frame")
        rows = {}
        for r in read(self.result("residuals.csv")):
            rows.setdefault((r["camera"], r["frame"]), []).append(r)
        self.assertEqual(list(rows), list(poses))
        views = observed_views(folder + "/observations.csv")
        for key, (X, uv) in views.items():
            R, t = compose(rig[key[0]], targets[key[1]])
            wanted = uv - camera[key[0]].project(X @ R.T + t)
            found = np.array([[float(r["du"]), float(r["dv"])] for r in rows[key]])
            error = np.array([float(r["error_px"]) for r in rows[key]])
            counts = np.array([r["left_out"] == "0" for r in rows[key]])
            names = ("X", "Y", "Z", "observed_u", "observed_v")
            given = np.array([[float(r[k]) for k in names] for r in rows[key]])
            np.testing.assert_allclose(given, np.hstack([X, uv]),
                                       rtol=1e-6 if FLOAT else 1e-9)
            np.testing.assert_allclose(found, wanted, atol=0.05 if FLOAT else 1e-6)
            np.testing.assert_allclose(error, np.hypot(*found.T), rtol=1e-5)
            self.assertEqual(int(poses[key]["n"]), counts.sum())
            # No pose fits the view better than its own.
            self.assertLess(float(poses[key]["rms_px"]),
                            np.sqrt(np.mean(error[counts]**2)) + 1e-4)
        return counts

    def test_they_are_those_of_the_rig(self):
        self.check(STEREO)
        self.check(CAVITY)
        self.check(CAVITY, "--method", "paper")

    def test_those_left_out_are_among_them(self):
        self.check(STEREO, "--robust", "--threshold", "0.4")
        self.assertIn(",1\n", content(self.out, "residuals.csv"))

    def test_points_keep_the_order_of_the_observations(self):
        self.calibrate_well(STEREO)
        told = [(r["frame"], r["camera"], r["point"])
                for r in read(self.result("residuals.csv"))]
        given = [(r["frame"], r["camera"], r["point"])
                 for r in read(STEREO + "/observations.csv")]
        self.assertEqual(told, sorted(given, key=lambda k: (k[1] != "left", k[0])))


if __name__ == "__main__":
    unittest.main()
