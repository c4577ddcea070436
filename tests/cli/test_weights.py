"""calibrate's --weigh: points count by column sigma_px."""
import os
import unittest

import numpy as np

from cli_support import (FLOAT, SANITIZED, STEREO, angle_deg, content, measured, read, relative, transforms,
                         write)
from test_rig import Adjusted, RigTest, covariance


def noises(path):
    """The rms of each view's points over that of an ordinary point."""
    rows = read(path)
    usual = sorted(float(r["sigma_px"]) for r in rows)[len(rows) // 2]
    views = {}
    for r in rows:
        views.setdefault((r["camera"], r["frame"]), []).append(float(r["sigma_px"]) / usual)
    return {key: np.repeat(values, 2) for key, values in views.items()}


class Weighed(Adjusted):
    """The same least squares by differences, with each error divided by its noise."""

    def __init__(self, folder, out, held):
        self.noise_of = noises(os.path.join(folder, "observations.csv"))
        super().__init__(folder, out, held)

    def errors(self, camera, frame, pose):
        return super().errors(camera, frame, pose) / self.noise_of[camera, frame]


class TestWeights(RigTest):
    def weighed(self, spread=6.0, seed=1, noise_px=0.1):
        """The files of a rig. Every third point has more noise than the others."""
        folder = self.made(noise_px=0, seed=seed)
        path = os.path.join(folder, "observations.csv")
        head, *lines = content(folder, "observations.csv").splitlines()
        rng = np.random.default_rng(seed)
        made = []
        for k, line in enumerate(lines):
            fields = line.split(",")
            sigma = spread if k % 3 == 1 else 1.0
            fields[6:] = [repr(float(x) + rng.normal(0, sigma * noise_px)) for x in fields[6:]]
            made.append(",".join([*fields, repr(sigma)]))
        write(folder, "observations.csv", "\n".join([head + ",sigma_px", *made]) + "\n")
        return folder, path

    def changed(self, change):
        """observations.csv with a different column sigma_px."""
        head, *lines = content(self.folder, "observations.csv").splitlines()
        lines = [",".join([*line.split(",")[:8], change(k)]) for k, line in enumerate(lines)]
        write(self.folder, "observations.csv", "\n".join([head, *lines]) + "\n")

    def test_poses_and_rig_are_weighed_least_squares(self):
        folder, _ = self.weighed()
        run = self.calibrate_well(folder, "--weigh")
        self.assertIn("\npoints are weighed by column sigma_px;", run.stdout)
        rig = Weighed(folder, self.out, ["a"])
        C = rig.scaled(rig.H)
        left = np.abs(C @ rig.g) / np.sqrt(np.diag(C)) / np.sqrt(rig.sum / rig.freedom)
        measured(f"left {left.max():.1e} sigma")
        self.assertLess(left.max(), 0.05 if FLOAT else 1e-4)
        plain = Adjusted(folder, self.out, ["a"])  # the optimum differs
        self.assertGreater((np.abs(C @ plain.g) / np.sqrt(np.diag(C))).max(), 1)
        block, noise = rig.cameras_covariance(), rig.noise()
        self.assertAlmostEqual(noise, 0.1, delta=0.02)
        for name, row in self.rows("rig.csv", "camera").items():
            if name in rig.free:
                self.close(covariance(row), noise**2 * block(name, name),
                           0.02 if FLOAT else 1e-4)
        for (camera, frame), pose in rig.poses.items():  # each view by itself
            h = 1e-6 * np.array([1, 1, 1, 6, 6, 6])
            e = rig.errors(camera, frame, pose)
            J = np.stack([(rig.errors(camera, frame, self.moved(pose, x)) - rig.errors(
                camera, frame, self.moved(pose, -x))) / (2 * h[k])
                for k, x in enumerate(np.diag(h))], 1)
            step = np.linalg.lstsq(J, e, rcond=None)[0]
            sigma = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
            self.assertLess(np.abs(step / sigma).max() / 0.1, 0.2 if FLOAT else 1e-3)

    @staticmethod
    def moved(pose, x):
        from test_rig import moved
        return moved(pose, x)

    @unittest.skipIf(SANITIZED, "the numbers are those of the build without sanitizers")
    def test_covariances_hold_what_they_say(self):
        """The errors of 60 rigs in units of their covariance: chi square of 6 degrees has
        the mean 6. Weighted rigs are nearer to the truth than rigs in which all points
        count alike."""
        true = relative(self.CAMERAS["b"], self.CAMERAS["a"])
        chi2, off = [], {"--weigh": [], "": []}
        for seed in range(60):
            folder, _ = self.weighed(seed=seed)
            for option, list_ in off.items():
                run = self.calibrate_set(folder, *filter(None, [
                    option, "--sigma", "0.1" if option else "0.35"]))
                self.assertEqual(run.returncode, 0, run.stderr)
                found = transforms(self.result("rig.csv"), "camera")["b"]
                list_.append(angle_deg(found[0], true[0]))
                if option:
                    W = found[0] @ true[0].T
                    x = np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1],
                                  *2 * (found[1] - true[1])]) / 2
                    S = covariance(self.rows("rig.csv", "camera")["b"])
                    chi2.append(x @ np.linalg.solve(S, x))
        rms = {option: np.sqrt(np.mean(np.square(v))) for option, v in off.items()}
        measured(f"chi square {np.mean(chi2):.2f}, {rms}")
        # The factor sqrt(F), at least 1, makes covariances a little larger.
        self.assertLess(abs(np.mean(chi2) - 5.6), 1.4)  # 3 standard errors: sqrt(12 / 60) each
        self.assertLess(np.mean(np.array(chi2) > 12.59), 0.15)  # 5 % of them
        self.assertLess(rms["--weigh"], 0.7 * rms[""])

    def test_only_ratios_of_the_column_count(self):
        folder, _ = self.weighed()
        self.calibrate_well(folder, "--weigh")
        first = self.files()
        self.changed(lambda k: "24" if k % 3 == 1 else "4")
        self.calibrate_well(folder, "--weigh")
        self.assertEqual(self.files(), first)
        self.changed(lambda k: "0.3")
        self.calibrate_well(folder, "--weigh")
        alike = transforms(self.result("rig.csv"), "camera")
        run = self.calibrate_well(folder)
        for name, (R, t) in transforms(self.result("rig.csv"), "camera").items():
            np.testing.assert_allclose(R, alike[name][0], atol=1e-4 if FLOAT else 1e-9)
            np.testing.assert_allclose(t, alike[name][1], atol=1e-4 if FLOAT else 1e-9)
        self.assertIn("\nall points count alike: column sigma_px is not used (--weigh", run.stdout)
        run = self.calibrate_well(STEREO)
        self.assertNotIn("sigma_px", run.stdout)

    def test_robust_looks_at_errors_over_their_noise(self):
        folder, _ = self.weighed(spread=60.0)
        self.calibrate_set(folder, "--weigh", "--robust", "--sigma", "0.1")
        left_out = [r for r in read(self.result("residuals.csv")) if r["left_out"] == "1"]
        self.assertLess(len(left_out), 4)
        self.calibrate_set(folder, "--robust", "--sigma", "0.1")
        left_out = [r for r in read(self.result("residuals.csv")) if r["left_out"] == "1"]
        self.assertGreater(len(left_out), 30)

    def test_what_is_wrong_is_named(self):
        folder, path = self.weighed()
        head, *lines = content(folder, "observations.csv").splitlines()
        for value, text in (("0", "3: column sigma_px: 0 is not a noise in pixels, from 1e-06"),
                            ("-1", "3: column sigma_px: -1 is not"),
                            ("nan", "3: column sigma_px: "), ("", "3: column sigma_px"),
                            ("1e7", "3: column sigma_px: 1e+07 is not"), ("x", "3: column sigma_px")):
            with self.subTest(value=value):
                bad = lines[:1] + [",".join([*lines[1].split(",")[:8], value])] + lines[2:]
                write(folder, "observations.csv", "\n".join([head, *bad]) + "\n")
                run = self.calibrate_set(folder, "--weigh")
                self.assertEqual(run.returncode, 2)
                self.assertIn(f"{path}:{text}", run.stderr)
                self.assertEqual(self.calibrate_set(folder).returncode, 0)  # as before
        run = self.calibrate_set(STEREO, "--weigh")
        self.assertEqual(run.returncode, 2)
        self.assertIn("observations.csv:1: there is no column sigma_px", run.stderr)
        run = self.calibrate_set(STEREO, "--weigh", "--method", "paper")
        self.assertEqual(run.returncode, 2)
        self.assertIn("--weigh does not go with --method paper", run.stderr)


if __name__ == "__main__":
    unittest.main()
