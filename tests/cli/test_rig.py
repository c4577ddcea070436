"""calibrate's rig: its poses, covariances, sqrt(F), --hold and --prior."""
import csv
import os
import pty
import re
import subprocess
import unittest

import numpy as np

from cli_support import (BIN, CAVITY, ENTRIES, FLOAT, RIG_ADDED, SCENE, STEPPED, STEREO, CliTest, angle_deg,
                         camera_row, cameras, compose, content, invert, made_up, measured,
                         observed_views, read, relative, rigcal, rotation, transform,
                         transforms, write)

STILL = np.eye(3), np.zeros(3)


def covariance(row):
    S = np.zeros((6, 6))
    S[np.tril_indices(6)] = [float(row[k]) for k in ENTRIES]
    return S + np.tril(S, -1).T


def moved(pose, x):
    return rotation(*x[:3]) @ pose[0], pose[1] + x[3:]


def slope(function, h):
    """The derivative by central differences. h: the step of each number."""
    return np.stack([(function(e) - function(-e)) / (2 * k)
                     for k, e in zip(h, np.diag(h))], 1)


def step_of(pose, start):
    """The small step (w, dt) between two poses."""
    W = pose[0] @ start[0].T
    return np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1],
                     *2 * (pose[1] - start[1])]) / 2


class Adjusted:
    """A rig that was written, and its least squares by differences, as bundle adjustments
    do them: all cameras but the held ones, all targets."""

    def __init__(self, folder, out, held):
        self.rig = transforms(os.path.join(out, "rig.csv"), "camera")
        self.targets = transforms(os.path.join(out, "targets.csv"), "frame")
        self.poses = transforms(os.path.join(out, "poses.csv"), "camera", "frame")
        self.views = observed_views(os.path.join(folder, "observations.csv"))
        self.lens = cameras(folder)
        self.free = [c for c in self.rig if c not in held]
        self.at = {("camera", c): 6 * i for i, c in enumerate(self.free)}
        for f in self.targets:
            self.at["frame", f] = len(self.at) * 6
        self.n = 6 * len(self.at)
        self.g, self.H = np.zeros(self.n), np.zeros((self.n, self.n))
        self.sum = self.own = 0.0
        self.n_points = sum(len(X) for X, _ in self.views.values())
        for camera, frame in self.views:
            self.add(camera, frame)
        self.freedom = 2 * self.n_points - self.n
        self.within = 2 * self.n_points - 6 * len(self.views)
        self.between = self.freedom - self.within
        if self.between > 0:
            self.F = (self.sum - self.own) / self.between / (self.own / self.within)

    def errors(self, camera, frame, pose):
        X, uv = self.views[camera, frame]
        return (self.lens[camera].project(X @ pose[0].T + pose[1]) - uv).ravel()

    def add(self, camera, frame):
        far = np.linalg.norm(self.poses[camera, frame][1])
        h = 1e-6 * np.array([1, 1, 1, far, far, far])
        e = self.errors(camera, frame, compose(self.rig[camera], self.targets[frame]))
        J_c = slope(lambda x: self.errors(camera, frame, compose(
            moved(self.rig[camera], x), self.targets[frame])), h)
        J_f = slope(lambda x: self.errors(camera, frame, compose(
            self.rig[camera], moved(self.targets[frame], x))), h)
        J = np.zeros((len(e), self.n))
        J[:, self.at["frame", frame]:][:, :6] = J_f
        if ("camera", camera) in self.at:
            J[:, self.at["camera", camera]:][:, :6] = J_c
        self.g += J.T @ e
        self.H += J.T @ J
        self.sum += e @ e
        e = self.errors(camera, frame, self.poses[camera, frame])
        self.own += e @ e

    def scaled(self, M):
        d = 1 / np.sqrt(np.diag(self.H))
        return d[:, None] * np.linalg.inv(d[:, None] * M * d) * d

    def noise(self):
        """The noise that the sigmas of the rig are for, without --sigma."""
        noise = np.sqrt(self.own / self.within)
        return noise * max(1, np.sqrt(self.F)) if self.between > 0 else noise

    def cameras_covariance(self):
        """The covariance for noise of one pixel, with rows for held cameras."""
        C = self.scaled(self.H)

        def block(a, b):
            a, b = self.at.get(("camera", a)), self.at.get(("camera", b))
            return np.zeros((6, 6)) if a is None or b is None else C[a:a + 6, b:b + 6]
        return block

    def pair_covariance(self, a, b):
        block = self.cameras_covariance()
        start = relative(self.rig[b], self.rig[a])
        far = max(1e-3, np.linalg.norm(start[1]))
        h = 1e-6 * np.array([1, 1, 1, far, far, far])
        J = np.hstack([
            slope(lambda x: step_of(relative(self.rig[b], moved(self.rig[a], x)), start), h),
            slope(lambda x: step_of(relative(moved(self.rig[b], x), self.rig[a]), start), h)])
        C = np.block([[block(a, a), block(a, b)], [block(b, a), block(b, b)]])
        return J @ C @ J.T


class RigTest(CliTest):
    def close(self, found, known, part):
        """Compares covariances. The tolerance of an entry is relative to its two sigmas."""
        s = np.sqrt(np.diag(known))
        np.testing.assert_allclose(found / np.outer(s, s), known / np.outer(s, s),
                                   atol=part)

    def rows(self, name, *keys):
        return {tuple(r[k] for k in keys) if len(keys) > 1 else r[keys[0]]: r
                for r in read(self.result(name))}

    # Simulated rigs: three cameras, five placements.
    CAMERAS = {"a": STILL, "b": (rotation(0, 0.3, 0.05), np.array([-1.2, 0.1, 0.2])),
               "c": (rotation(0.1, -0.4, 0), np.array([1.4, 0, 0.3]))}
    PLACES = {str(i): (rotation(0.3 * i - 0.5, 0.4 - 0.2 * i, 0.1 * i),
                       np.array([0.2 * i - 0.4, 0.1 * i, 6 + 0.3 * i])) for i in range(5)}

    def made(self, noise_px=0.1, seed=1, spoil=None, shared=None, places=None):
        """A folder with the files of a rig. `spoil` changes the lines of observations."""
        places = places or self.PLACES
        shared = shared or {f: "abc" for f in places}
        table, text = made_up({n: camera_row(n) for n in self.CAMERAS}, self.CAMERAS,
                              places, shared)
        rng = np.random.default_rng(seed)
        head, *lines = text.splitlines()
        fields = [line.split(",") for line in lines]
        for f in fields:
            f[6:] = [repr(float(u) + rng.normal(0, noise_px)) for u in f[6:]]
        if spoil:
            spoil(fields)
        write(self.folder, "cameras.csv", table)
        write(self.folder, "observations.csv",
              "\n".join([head, *(",".join(f) for f in fields)]) + "\n")
        return self.folder


class TestAgainstBundleAdjustment(RigTest):
    def check_reference(self, folder):
        self.calibrate_well(folder)
        for name, keys in (("rig.csv", ["camera"]), ("targets.csv", ["frame"]),
                           ("pairs.csv", ["camera_a", "camera_b"])):
            found = transforms(self.result(name), *keys)
            known = transforms(os.path.join(folder, "reference_" + name), *keys)
            self.assertEqual(sorted(found), sorted(known))
            for key, (R, t) in known.items():
                angle = angle_deg(R, found[key][0])
                part = np.linalg.norm(t - found[key][1]) / max(np.linalg.norm(t), 1e-3)
                measured(f"{name} {key}: {angle:.1e} deg, {100 * part:.1e} %")
                self.assertLess(angle, 0.01 if FLOAT else 1e-6)
                self.assertLess(part, 2e-4 if FLOAT else 1e-7)

    def test_a_stereo_pair_of_seven_placements(self):
        self.check_reference(STEREO)

    def test_of_one_placement_the_poses_composed(self):
        for folder in (CAVITY, STEPPED, SCENE):
            with self.subTest(folder=os.path.basename(folder)):
                self.check_reference(folder)

    def check_least_squares(self, folder, *options, held=None):
        """Compares all that is written with normal equations by difference quotients."""
        run = self.calibrate_well(folder, *options)
        rig = Adjusted(folder, self.out, held or [next(iter(cameras(folder)))])
        C = rig.scaled(rig.H)
        # At the optimum the remaining step is 0, in parts of each sigma.
        left = np.abs(C @ rig.g) / np.sqrt(np.diag(C)) / np.sqrt(rig.sum / rig.freedom)
        measured(f"left {left.max():.1e} sigma")
        self.assertLess(left.max(), 0.05 if FLOAT else 1e-4)
        noise = rig.noise()
        block = rig.cameras_covariance()
        part = 0.02 if FLOAT else 1e-4
        for name, row in self.rows("rig.csv", "camera").items():
            S = covariance(row)
            if name in rig.free:
                self.close(S, noise**2 * block(name, name), part)
            else:
                np.testing.assert_array_equal(S, np.zeros((6, 6)))
            self.check_sigmas(row, part)
        for (a, b), row in self.rows("pairs.csv", "camera_a", "camera_b").items():
            self.close(covariance(row), noise**2 * rig.pair_covariance(a, b), part)
            self.check_sigmas(row, part)
        return run, rig

    def check_sigmas(self, row, part):
        """sigma_rot_deg and sigma_pos follow from the covariance; sigma_pos is that of the
        centre."""
        S, pose = covariance(row), transform(row)
        far = max(1e-3, np.linalg.norm(pose[1]))
        J = slope(lambda x: invert(moved(pose, x))[1],
                  1e-6 * np.array([1, 1, 1, far, far, far]))
        np.testing.assert_allclose(
            [float(row["sigma_rot_deg"]), float(row["sigma_pos"])],
            [np.degrees(np.sqrt(np.trace(S[:3, :3]))), np.sqrt(np.trace(J @ S @ J.T))],
            rtol=10 * part, atol=1e-12)

    def test_covariances_of_the_stereo_pair(self):
        run, rig = self.check_least_squares(STEREO)
        self.assertGreater(rig.F, 1)
        self.assertIn(f"sqrt(F) {np.sqrt(rig.F):.2f}: the views disagree", run.stdout)
        self.assertIn(f"multiplied by sqrt(F), {np.sqrt(rig.F):.2f}\n", run.stdout)
        self.assertIn(f"F has {rig.between} and {rig.within} degrees of freedom", run.stdout)
        self.assertRegex(run.stdout, r"(?m)^rig: 14 views, 756 points, sigma "
                         rf"{np.sqrt(rig.sum / rig.freedom):.3g} px of one coordinate$")

    def test_covariances_of_one_placement(self):
        run, _ = self.check_least_squares(CAVITY)
        self.assertIn("sqrt(F) is not known", run.stdout)

    def test_covariances_of_a_chain_of_cameras(self):
        shared = {"0": "ab", "1": "ab", "2": "bc", "3": "bc", "4": "ab"}
        self.check_least_squares(self.made(shared=shared))

    def test_sqrt_F_below_one_does_not_shrink_the_sigmas(self):
        for seed in range(1, 20):
            folder = self.made(seed=seed)
            run, rig = self.check_least_squares(folder)
            if rig.F < 1:
                self.assertNotIn("multiplied", run.stdout)
                return
        self.fail("F of 19 rigs is above 1")

    def test_rms_of_views_and_cameras(self):
        run, rig = self.check_least_squares(STEREO)
        of_camera = {}
        for camera, frame in rig.views:
            e = rig.errors(camera, frame, compose(rig.rig[camera], rig.targets[frame]))
            of_camera.setdefault(camera, []).append(e)
            self.assertRegex(run.stdout, rf"(?m)^{camera} +{frame} +54 +\d\.\d+ +"
                             rf"{np.sqrt(2 * np.mean(e**2)):.3f} ")
        for camera, e in of_camera.items():
            self.assertRegex(run.stdout, rf"(?m)^{camera} +"
                             rf"{np.sqrt(2 * np.mean(np.concatenate(e)**2)):.3f}  .* .* ")

    def test_largest_residuals_come_first(self):
        text = self.calibrate_well(STEREO).stdout
        shown = re.findall(r"(?m)^(left|right) +(\d\d) +[\d.]+ +([\d.]+)  (\d+)$", text)
        worst = {}
        for r in read(self.result("residuals.csv")):
            key = r["camera"], r["frame"]
            worst[key] = max(worst.get(key, (0, "")), (float(r["error_px"]), r["point"]))
        known = sorted(((e, *key, point) for key, (e, point) in worst.items()), reverse=True)
        self.assertEqual(shown, [(c, f, f"{e:.3f}", p) for e, c, f, p in known[:5]])


class TestDisagreement(RigTest):
    SENTENCE = re.compile(r"The views fit \(([\d.]+) px\) but the rig does not \(([\d.]+) times "
                          r"the noise\)\.")

    def moved_for_c(self, far):
        """The target has moved before camera c sees it, in another direction each time."""
        late = {f: (R, t + far * np.array([np.cos(2 * i), np.sin(2 * i), 0]))
                for i, (f, (R, t)) in enumerate(self.PLACES.items())}
        self.made()
        plain = content(self.folder, "observations.csv").splitlines()
        self.made(places=late, seed=2)
        moved_lines = content(self.folder, "observations.csv").splitlines()
        write(self.folder, "observations.csv", "\n".join(
            b if ",c," in b else a for a, b in zip(plain, moved_lines)) + "\n")

    def test_a_camera_that_is_late_is_told(self):
        self.moved_for_c(0.005)
        run = self.calibrate_well(self.folder)
        found = self.SENTENCE.search(run.stdout)
        rig = Adjusted(self.folder, self.out, ["a"])
        self.assertAlmostEqual(float(found[2]) / np.sqrt(rig.F), 1, delta=0.01)
        within = 2 * rig.n_points - 6 * len(rig.views)
        self.assertAlmostEqual(float(found[1]) / np.sqrt(rig.own / within), 1, delta=0.05)

    def test_a_camera_that_is_very_late_is_left_out(self):
        self.moved_for_c(0.05)
        run = self.calibrate_set(self.folder)
        self.assertEqual(run.returncode, 1)
        self.assertTrue(run.stderr.startswith(
            "rigcal: camera c contradicts the others in 5 of 5 frames, where it is left out: "),
            run.stderr)
        self.assertEqual(list(self.rows("rig.csv", "camera")), ["a", "b"])

    def test_noise_alone_is_not_told(self):
        for seed in range(5):
            run = self.calibrate_well(self.made(seed=seed))
            self.assertIsNone(self.SENTENCE.search(run.stdout))


class TestRobustRig(RigTest):
    def test_what_is_left_out_does_not_count_in_the_rig(self):
        def wrong(fields):
            fields[3][6] = repr(float(fields[3][6]) + 40)
            fields[40][7] = repr(float(fields[40][7]) - 30)

        def absent(fields):
            del fields[40], fields[3]
        outputs = []
        for spoil, options in ((wrong, ["--robust"]), (absent, [])):
            self.assertEqual(self.calibrate_set(self.made(spoil=spoil),
                                                *options).returncode, 0)
            outputs.append([content(self.out, name)
                            for name in ("rig.csv", "targets.csv", "pairs.csv")])
        self.close_text(*outputs)

    def close_text(self, a, b):
        for one, other in zip(a, b):
            for p, q in zip(read(one), read(other)):
                for key in p:
                    if key not in ("camera", "camera_a", "camera_b", "frame") and p[key] + q[key]:
                        self.assertAlmostEqual(float(p[key]), float(q[key]),
                                               delta=1e-3 if FLOAT else 1e-8)


class TestHold(RigTest):
    def test_one_camera_held_is_the_frame_and_pairs_are_the_same(self):
        self.made()
        self.calibrate_well(self.folder)
        free = self.rows("pairs.csv", "camera_a", "camera_b")
        run = self.calibrate_well(self.folder, "--hold", "b")
        self.assertIn("centre in the frame of b\n", run.stdout)
        rig = self.rows("rig.csv", "camera")
        np.testing.assert_array_equal(transform(rig["b"])[0], np.eye(3))
        np.testing.assert_array_equal(transform(rig["b"])[1], np.zeros(3))
        np.testing.assert_array_equal(covariance(rig["b"]), np.zeros((6, 6)))
        self.assertGreater(float(rig["a"]["sigma_pos"]), 0)
        for key, row in self.rows("pairs.csv", "camera_a", "camera_b").items():
            self.close(covariance(row), covariance(free[key]), 0.02 if FLOAT else 1e-4)
            np.testing.assert_allclose(transform(row)[1], transform(free[key])[1],
                                       atol=1e-3 if FLOAT else 1e-7)

    def test_several_held_stay_where_the_file_says(self):
        self.made()
        self.calibrate_well(self.folder)
        head, a, b, c = content(self.out, "rig.csv").splitlines()
        # Removes the covariances, and moves b by hand.
        fields = b.split(",")
        fields[10] = repr(float(fields[10]) + 0.004)
        prior = write(self.folder, "prior.csv", "\n".join(
            ",".join(line[:13]) for line in (head.split(","), a.split(","), fields)))
        run = self.calibrate_well(self.folder, "--hold", "a", "--hold", "b",
                                  "--prior", prior)
        self.assertIn(f"centre in the frame of {prior}\n", run.stdout)
        rig = self.rows("rig.csv", "camera")
        np.testing.assert_allclose(transform(rig["b"])[1],
                                   [float(x) for x in fields[10:13]], rtol=1e-6)
        for name in "ab":
            np.testing.assert_array_equal(covariance(rig[name]), np.zeros((6, 6)))
        adjusted = Adjusted(self.folder, self.out, ["a", "b"])
        C = adjusted.scaled(adjusted.H)
        self.assertLess((np.abs(C @ adjusted.g) / np.sqrt(np.diag(C))).max(),
                        0.05 if FLOAT else 1e-4)


class TestPrior(RigTest):
    SIGMA = 0.1

    def with_prior(self, shift, is_joint):
        """A prior of cameras b and c that differs from the free answer by `shift` sigma.
        is_joint: the file has the covariance between them."""
        self.made()
        self.calibrate_well(self.folder, "--sigma", str(self.SIGMA))
        free = Adjusted(self.folder, self.out, ["a"])
        C = free.cameras_covariance()
        s = np.sqrt(np.concatenate([np.diag(C(n, n)) for n in "bc"])) * self.SIGMA
        rng = np.random.default_rng(3)
        A = rng.normal(size=(12, 16)) * s[:, None] / 3
        x, S = shift * s * rng.choice([-1, 1], 12), A @ A.T
        text = content(self.out, "rig.csv").splitlines()
        lines = [",".join(line.split(",")[:36]) for line in text[:2]]
        if is_joint:
            lines[0] += "".join(f",S{i}{j}@b" for i in range(1, 7) for j in range(1, 7))
        for name, at in (("b", slice(0, 6)), ("c", slice(6, 12))):
            R, t = moved(free.rig[name], x[at])
            numbers = [*R.ravel().tolist(), *t.tolist(), 0, 0,
                       *S[at, at][np.tril_indices(6)].tolist()]
            if is_joint and name == "c":
                numbers += S[6:, :6].ravel().tolist()
            lines.append(",".join([name, *map(repr, numbers)]))
        width = lines[0].count(",")
        lines = [line + "," * (width - line.count(",")) for line in lines]
        path = write(self.folder, "prior.csv", "\n".join(lines) + "\n")
        self.calibrate_well(self.folder, "--sigma", str(self.SIGMA), "--prior", path)
        if not is_joint:
            S[6:, :6] = S[:6, 6:] = 0
        return free, x, S

    def check_prior(self, is_joint):
        free, x, S_prior = self.with_prior(0.3, is_joint)
        H, g = free.H / self.SIGMA**2, np.zeros(free.n)
        at = np.concatenate([free.at["camera", n] + np.arange(6) for n in "bc"])
        H[np.ix_(at, at)] += np.linalg.inv(S_prior)
        g[at] += np.linalg.solve(S_prior, x)
        d = 1 / np.sqrt(np.diag(H))
        C = d[:, None] * np.linalg.inv(d[:, None] * H * d) * d
        step = C @ g
        rig = self.rows("rig.csv", "camera")
        factors = []
        for name in "bc":
            at = free.at["camera", name]
            s = np.sqrt(np.diag(C))[at:at + 6]
            found = step_of(transform(rig[name]), free.rig[name]) / s
            measured(f"{name}: {np.round(found, 3)}")
            np.testing.assert_allclose(found, step[at:at + 6] / s, atol=0.05)
            S = covariance(rig[name])
            factors.append(S[0, 0] / C[at, at])
            self.close(S / factors[-1], C[at:at + 6, at:at + 6], 0.01)
        self.assertGreater(min(factors), 1 - 1e-3)  # F, or 1
        self.assertAlmostEqual(factors[0], factors[1], delta=0.01)
        np.testing.assert_array_equal(covariance(rig["a"]), np.zeros((6, 6)))

    def test_prior_and_observations_are_weighed_by_their_covariances(self):
        self.check_prior(is_joint=False)

    def test_the_covariance_between_the_priors_of_two_cameras_counts(self):
        self.check_prior(is_joint=True)

    def test_a_joint_covariance_that_is_not_one_is_refused(self):
        """Each block could be one, and no correlation exceeds 1. But b and c have one axis
        in common, which is correlated with two others in a way that nothing can be."""
        self.with_prior(0, is_joint=True)
        path = os.path.join(self.folder, "prior.csv")
        rows = list(csv.reader(content(self.folder, "prior.csv").splitlines()))
        at = {name: rows[0].index(name) for name in rows[0]}
        b, c = rows[2], rows[3]
        for row in (b, c):  # correlations: 0.9 of axes 1 and 2
            s = [float(row[at[f"S{i}{i}"]]) ** 0.5 for i in range(1, 7)]
            for i in range(1, 7):
                for j in range(1, i):
                    row[at[f"S{i}{j}"]] = repr(0.9 * s[0] * s[1] if i == 2 else 0.0)
        s_b, s_c = (float(row[at["S11"]]) ** 0.5 for row in (b, c))
        for i in range(1, 7):
            for j in range(1, 7):
                c[at[f"S{i}{j}@b"]] = "0"
        c[at["S11@b"]] = repr(0.9 * s_b * s_c)
        c[at["S22@b"]] = repr(-0.9 * (float(b[at["S22"]]) * float(c[at["S22"]])) ** 0.5)
        write(self.folder, "prior.csv", "\n".join(",".join(row) for row in rows) + "\n")
        run = self.calibrate_set(self.folder, "--sigma", str(self.SIGMA), "--prior", path)
        self.assertEqual(run.returncode, 2)
        self.assertIn("are no covariance together", run.stderr)

    def test_rig_csv_is_read_as_it_is_written(self):
        self.made(seed=4)
        self.calibrate_well(self.folder, "--sigma", "0.1")
        first = write(self.folder, "first.csv", content(self.out, "rig.csv"))
        known = {r["camera"]: r for r in read(first)}
        self.made(seed=5)
        run = self.calibrate_well(self.folder, "--sigma", "0.1", "--prior", first)
        self.assertIn(f"centre in the frame of {first}\n", run.stdout)
        rig = self.rows("rig.csv", "camera")
        for name in "bc":  # twice the observations
            ratio = float(rig[name]["sigma_pos"]) / float(known[name]["sigma_pos"])
            measured(f"{name}: {ratio:.3f}")
            self.assertGreater(ratio, 0.55)
            self.assertLess(ratio, 0.85)

    def test_groups_that_only_the_prior_joins(self):
        shared = {"0": "ab", "1": "ab", "2": "c", "3": "c", "4": "c"}
        self.made()
        self.calibrate_well(self.folder, "--sigma", "0.1")
        prior = write(self.folder, "prior.csv", content(self.out, "rig.csv"))
        self.made(shared=shared)
        run = self.calibrate_set(self.folder, "--sigma", "0.1", "--prior", prior)
        self.assertEqual(run.returncode, 1)
        self.assertIn(f"camera c shares no frame with a, nor with a camera that does: only "
                      f"{prior} says how they lie", run.stderr)
        self.assertEqual(list(self.rows("rig.csv", "camera")), ["a", "b", "c"])
        self.assertEqual(list(self.rows("pairs.csv", "camera_a", "camera_b")), [("a", "b")])
        self.assertEqual(sorted(self.rows("targets.csv", "frame")), list("01234"))


class TestWrongUse(RigTest):
    def refuses(self, message, *options):
        before = self.files()
        run = self.calibrate_set(self.folder, *options)
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        self.assertIn(message, run.stderr)
        self.assertEqual(self.files(), before)

    def test_wrong_use_is_named(self):
        self.made()
        self.calibrate_well(self.folder, "--sigma", "0.1")
        text = content(self.out, "rig.csv")
        rig = write(self.folder, "rig.csv", text)
        lines = text.splitlines()
        bare = write(self.folder, "bare.csv", "\n".join(
            ",".join(line.split(",")[:13]) for line in lines))
        cells = lines[2].split(",")
        cells[15] = "-" + cells[15]
        bad = write(self.folder, "bad.csv", "\n".join([lines[0], ",".join(cells)]))
        cells[15] = "1e-30"
        flat = write(self.folder, "flat.csv", "\n".join([lines[0], ",".join(cells)]))
        part = write(self.folder, "part.csv", text.replace("S43", "X43", 1))
        self.refuses("--hold d: this camera is not in", "--hold", "d")
        self.refuses("--hold a is given twice", "--hold", "a", "--hold", "a")
        self.refuses("--hold of several cameras needs --prior FILE",
                     "--hold", "a", "--hold", "b")
        self.refuses("--prior needs --sigma", "--prior", rig)
        self.refuses(f"{bare}:2: camera a has no covariance", "--prior", bare,
                     "--sigma", "0.1")
        self.refuses("a camera of --hold has no line in", "--prior", write(
            self.folder, "other.csv", "\n".join([lines[0], lines[2]])), "--hold", "a")
        self.refuses(f"{bad}:2: S11 to S66 are no covariance", "--prior", bad,
                     "--sigma", "0.1")
        self.refuses(f"{flat}:2: S11 to S66 are no covariance", "--prior", flat,
                     "--sigma", "0.1")
        self.refuses("there is no column S43", "--prior", part, "--sigma", "0.1")
        self.refuses("cannot read", "--prior", self.folder + "/none.csv")
        for option in (["--hold", "a"], ["--prior", rig]):
            self.refuses("do not go with --method paper", *option, "--method", "paper")

    def test_by_the_published_procedure_no_sigma_is_known(self):
        run = self.calibrate_well(STEREO, "--method", "paper")
        self.assertNotIn("sqrt(F)", run.stdout)
        for name in ("rig.csv", "pairs.csv"):
            for row in read(self.result(name)):
                self.assertEqual({row[k] for k in RIG_ADDED}, {""})


class TestProgress(RigTest):
    def run_on_terminal(self):
        master, slave = pty.openpty()
        with subprocess.Popen(
                [BIN, "calibrate", "--cameras", self.folder + "/cameras.csv",
                 "--observations", self.folder + "/observations.csv"],
                stdout=subprocess.PIPE, stderr=slave) as run:
            os.close(slave)
            shown = b""
            try:
                while data := os.read(master, 65536):
                    shown += data
            except OSError:  # this is how a terminal ends
                pass
            out = run.stdout.read().decode()
        os.close(master)
        self.assertEqual(run.returncode, 0)
        return out, shown.decode()

    def test_long_work_is_shown_on_a_terminal_only(self):
        places = {f"{k}{i}": (R, t + [0, 0, 0.02 * k]) for k in range(4)
                  for i, (R, t) in enumerate(self.PLACES.values())}
        self.made(places=places)  # 60 views
        plain = self.calibrate_well(self.folder).stdout  # and stderr is empty
        out, shown = self.run_on_terminal()
        self.assertEqual(out, plain)
        self.assertIn("rigcal: view 60 of 60", shown)
        self.assertIn("rigcal: adjusting the rig of 60 views, step 1", shown)
        self.assertTrue(shown.endswith("\r\033[K"))  # and it was removed

    def test_short_work_is_not(self):
        self.made()
        self.assertEqual(self.run_on_terminal()[1], "")


if __name__ == "__main__":
    unittest.main()
