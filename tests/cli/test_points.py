#!/usr/bin/env python3
"""Points and bands from the rig.csv that calibrate wrote: with the error of the calibration,
and wrong views named. Derivatives here are by differences, matrices dense."""
import os
import unittest

import numpy as np

import test_rig
from cli_support import (CAVITY, FLOAT, STEREO, Camera, at_line, cameras, content, field,
                         observed_views, read, rigcal, transforms, write)
from test_rig import covariance, moved, slope

LINES = [f"S{i}{j}" for i in (1, 2, 3) for j in range(1, i + 1)]


def between(row, name):
    """The covariance of a camera with camera `name`, from its line."""
    return np.array([[float(row[f"S{i}{j}@{name}"]) for j in range(1, 7)]
                     for i in range(1, 7)])


def point_covariance(row):
    S = np.zeros((3, 3))
    S[np.tril_indices(3)] = [float(row[k]) for k in LINES]
    return S + np.tril(S, -1).T


class MeasureTest(test_rig.RigTest):
    def triangulate(self, folder, *more, rig=None, observations=None):
        return rigcal("triangulate", "--cameras", folder + "/cameras.csv", "--rig",
                      rig or self.result("rig.csv"), "--observations",
                      observations or folder + "/observations.csv", *more)


class TestJoint(MeasureTest):
    """Three cameras, the first of them held. The other two have a covariance."""

    def joint(self):
        rows = {row["camera"]: row for row in read(self.result("rig.csv"))}
        cross = between(rows["c"], "b")
        return rows, np.block([[covariance(rows["b"]), cross.T],
                               [cross, covariance(rows["c"])]])

    def test_cross_covariances_are_those_of_the_adjustment(self):
        self.made()
        self.calibrate_well(self.folder)
        adjusted = test_rig.Adjusted(self.folder, self.out, ["a"])
        rows, joint = self.joint()
        block = adjusted.cameras_covariance()
        C = np.block([[block("b", "b"), block("b", "c")],
                      [block("c", "b"), block("c", "c")]]) * adjusted.noise()**2
        scale = np.sqrt(np.diag(C))
        np.testing.assert_allclose(joint / np.outer(scale, scale),
                                   C / np.outer(scale, scale), atol=0.02 if FLOAT else 1e-3)
        noise = float(rows["a"]["noise_px"])
        self.assertAlmostEqual(noise, np.sqrt(adjusted.own / adjusted.within),
                               delta=1e-3 * noise)
        self.assertAlmostEqual(float(rows["b"]["sqrt_F"]), np.sqrt(adjusted.F),
                               delta=2e-3 * np.sqrt(adjusted.F))

    def test_points_have_the_error_of_noise_and_calibration(self):
        self.made()
        self.calibrate_well(self.folder)
        rows, joint = self.joint()
        lens, rig = cameras(self.folder), transforms(self.result("rig.csv"), "camera")
        noise = float(rows["a"]["noise_px"])
        run = self.triangulate(self.folder)
        self.assertIn("noise of a pixel coordinate, by ", run.stderr)
        for row in read(run.stdout)[::17]:
            self.assertEqual((row["ncams"], row["left_out"]), ("3", ""))
            X = np.array([float(row[k]) for k in "XYZ"])

            def pixels(P, d=np.zeros(18)):
                return np.concatenate([
                    lens[c].project((lambda T: T[0] @ P + T[1])(
                        moved(rig[c], d[6 * i:6 * i + 6]))) for i, c in enumerate("abc")])
            A = slope(lambda e: pixels(X + e), np.full(3, 1e-6))
            B = slope(lambda e: pixels(X, e), np.full(18, 1e-6))[:, 6:]
            G = np.linalg.pinv(A)
            S = G @ (noise**2 * np.eye(6) + B @ joint @ B.T) @ G.T
            found = point_covariance(row)
            np.testing.assert_allclose(found, S, atol=(0.02 if FLOAT else 1e-3) *
                                       np.abs(S).max())
            for k, name in enumerate("XYZ"):
                self.assertAlmostEqual(float(row["sigma_" + name]), np.sqrt(found[k, k]),
                                       delta=1e-5 * np.sqrt(found[k, k]))
            self.assertEqual(float(row["freedom"]), 3)
            self.assertLess(float(row["chi2"]), 30)

    def test_a_rig_without_the_cross_covariances_counts_as_exact(self):
        self.made()
        self.calibrate_well(self.folder)
        text = [line.split(",")[:39] for line in content(self.out, "rig.csv").splitlines()]
        self.assertEqual(text[0][-1], "sqrt_F")
        rig = write(self.folder, "cut.csv", "\n".join(map(",".join, text)) + "\n")
        whole, cut = self.triangulate(self.folder), self.triangulate(self.folder, rig=rig)
        self.assertIn("has no covariance of all its cameras: they count as exact",
                      cut.stderr)
        self.assertNotIn("count as exact", whole.stderr)
        for a, b in zip(read(whole.stdout), read(cut.stdout)):
            self.assertGreater(float(a["sigma_X"]), float(b["sigma_X"]))

    def test_lines_may_come_in_any_order(self):
        self.made()
        self.calibrate_well(self.folder)
        head, *lines = content(self.out, "rig.csv").splitlines()
        rig = write(self.folder, "turned.csv", "\n".join([head, *lines[::-1]]) + "\n")
        for a, b in zip(read(self.triangulate(self.folder).stdout),
                        read(self.triangulate(self.folder, rig=rig).stdout)):
            np.testing.assert_allclose(point_covariance(a), point_covariance(b),
                                       rtol=0.02 if FLOAT else 1e-6, atol=1e-12)

    def test_what_is_wrong_with_a_rig_is_told(self):
        self.made()
        self.calibrate_well(self.folder)
        text = content(self.out, "rig.csv")
        head = text.split("\n")[0].split(",")
        for change, words in (
                (at_line(4, field(head.index("S22@b"), "9")),
                 "4: S22@b is more than the variances of both allow"),
                (at_line(4, field(head.index("S22@b"), "x")), "4: .*S22@b"),
                (at_line(4, field(head.index("S33"), "-1")), "4: S11 to S66 are no cov"),
                (at_line(3, field(head.index("sigma_px"), "0")), "3: sigma_px is from"),
                (at_line(2, field(head.index("noise_px"), "-2")), "2: noise_px is from"),
                (lambda t: t.replace("S35@b", "T35"), "1: there is no column S35@b")):
            path = write(self.folder, "bad.csv", change(text))
            run = self.triangulate(self.folder, rig=path)
            self.assertEqual((run.returncode, run.stdout), (2, ""), words)
            self.assertRegex(run.stderr, words)


class TestWrongViews(MeasureTest):
    def test_a_wrong_view_is_left_out_and_named(self):
        self.calibrate_well(CAVITY)
        run = self.triangulate(CAVITY)
        self.assertEqual(run.returncode, 0)
        right = {row["point"]: row for row in read(run.stdout)}
        head, *lines = content(CAVITY, "observations.csv").splitlines()
        at = next(i for i, line in enumerate(lines) if right[line.split(",")[2]]["ncams"] == "4")
        fields = lines[at].split(",")
        fields[-1] = repr(float(fields[-1]) + 25)
        lines[at] = ",".join(fields)
        path = write(self.folder, "observations.csv", "\n".join([head, *lines]) + "\n")
        run = self.triangulate(CAVITY, observations=path)
        self.assertEqual(run.returncode, 1)
        self.assertIn(f"frame {fields[0]}, point {fields[2]}: left out, because it contradicts "
                      f"the others: camera {fields[1]}", run.stderr)
        found = {row["point"]: row for row in read(run.stdout)}
        for point, row in found.items():
            if point == fields[2]:
                self.assertEqual((row["ncams"], row["left_out"]), ("3", fields[1]))
                for k in "XYZ":
                    self.assertAlmostEqual(float(row[k]), float(right[point][k]), delta=0.5)
            else:
                self.assertEqual(row, right[point])

    def test_without_a_covariance_nothing_is_left_out(self):
        rows = read(self.triangulate(CAVITY, rig=CAVITY + "/reference_rig.csv").stdout)
        self.assertEqual({row["left_out"] for row in rows}, {""})
        self.assertEqual({row["chi2"] for row in rows}, {""})


class TestBand(MeasureTest):
    def line(self, pixel, *more, rig=None):
        return rigcal("line", "--cameras", STEREO + "/cameras.csv", "--rig",
                      rig or self.result("rig.csv"), "--from", "left", "--to", "right",
                      "--pixel", f"{pixel[0]!r},{pixel[1]!r}", *more)

    def test_true_matches_are_among_the_candidates_and_in_the_spans(self):
        self.calibrate_well(STEREO)
        views = observed_views(STEREO + "/observations.csv")
        left, right = views["left", "03"][1], views["right", "03"][1]
        path = write(self.folder, "candidates.csv", "u,v\n" + "".join(
            f"{u!r},{v!r}\n" for u, v in right.tolist()))
        inside = spanned = 0
        for i, uv in enumerate(left.tolist()):
            run = self.line(uv, "--probability", "0.99", "--candidates", path)
            self.assertEqual(run.returncode, 0, run.stderr)
            rows = read(run.stdout)
            found = [row for row in rows if row["quantity"] == "candidate"]
            self.assertLess(len(found), len(right) / 2)
            own = [row for row in found if int(row["v1"]) == i + 2]
            inside += len(own)
            for row in own:
                self.assertLessEqual(float(row["v4"]), 6.64)
                np.testing.assert_allclose([float(row["v2"]), float(row["v3"])], right[i],
                                           rtol=1e-6)
            spans = [[int(row[k]) for k in ("v1", "v2", "v3")] for row in rows
                     if row["quantity"] == "span"]
            u, v = np.rint(right[i])
            spanned += any(s[0] == v and s[1] - 1 <= u <= s[2] + 1 for s in spans)
        self.assertGreaterEqual(inside, 0.97 * len(left))
        self.assertGreaterEqual(spanned, 0.97 * len(left))

    def test_the_band_is_wider_for_more_probability(self):
        self.calibrate_well(STEREO)
        widths = []
        for probability in ("0.9", "0.99", "0.999"):
            rows = read(self.line((300.0, 200.0), "--probability", probability).stdout)
            widths.append([float(row["v3"]) for row in rows if row["quantity"] == "band"])
        ratio = np.array(widths[1]) / widths[0]
        np.testing.assert_allclose(ratio, 2.5758 / 1.6449, rtol=1e-3)
        self.assertTrue(np.all(np.array(widths[2]) > widths[1]))
        plain = [row["quantity"] for row in read(self.line((300.0, 200.0)).stdout)]
        self.assertIn("band", plain)
        self.assertNotIn("span", plain)

    def test_what_is_missing_is_told(self):
        self.calibrate_well(STEREO)
        reference = STEREO + "/reference_rig.csv"
        bad = write(self.folder, "bad.csv", "u,w\n1,2\n")
        odd = write(self.folder, "odd.csv", "u,v\n1,2\n3,x\n")
        for more, rig, words in (
                (["--probability", "0.9"], reference, "--probability needs the noise of a "),
                (["--candidates", odd], reference, "--candidates needs the noise of a pix"),
                (["--probability", "1"], None, "--probability is from 0.001 to 0.999999"),
                (["--candidates", bad], None, "bad.csv:1: there is no column v"),
                (["--candidates", odd], None, "odd.csv:3: "),
                (["--candidates", "none.csv"], None, "none.csv")):
            run = self.line((300.0, 200.0), *more, rig=rig)
            self.assertEqual(run.returncode, 2, words)
            self.assertIn(words, run.stderr)
        run = self.line((300.0, 200.0), "--sigma", "0.3", rig=reference)
        self.assertEqual(run.returncode, 0)
        self.assertIn("for noise of 0.3 px of left and 0.3 px of right", run.stderr)
        self.assertNotIn("band", [row["quantity"] for row in read(
            self.line((300.0, 200.0), rig=reference).stdout)])


if __name__ == "__main__":
    unittest.main()
