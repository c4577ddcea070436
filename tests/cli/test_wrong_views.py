"""calibrate survives wrong views: the first line says what is wrong, the second what to do."""
import itertools
import unittest

import numpy as np

from cli_support import (FLOAT, STEREO, Camera, CliTest, angle_deg, camera_row, compose,
                         content, measured, read, rotation, transforms, write)

FRAMES = ["01", "03", "05", "07", "09", "12", "14"]
COLUMNS = ["frame", "camera", "point", "X", "Y", "Z", "u", "v"]


class WrongViews(CliTest):
    def run_rows(self, rows, cameras_csv, *options):
        path = write(self.folder, "observations.csv", "\n".join(
            [",".join(COLUMNS), *(",".join(str(r[k]) for k in COLUMNS) for r in rows)]) + "\n")
        return self.calibrate(cameras_csv, path, None, *options)

    def verdicts(self):
        return {(r["camera"], r["frame"]): r["verdict"] for r in read(self.result("poses.csv"))}


def views_of(rows):
    views = {}
    for r in rows:
        views.setdefault((r["camera"], r["frame"]), []).append(r)
    return views


def reverse(view):
    """The pixels of one view in reverse order."""
    for r, pixel in zip(view, [(r["u"], r["v"]) for r in view][::-1]):
        r["u"], r["v"] = pixel


class TestStereo(WrongViews):
    CAMERAS = STEREO + "/cameras.csv"

    def rows(self):
        return read(STEREO + "/observations.csv")

    def test_one_view_reversed_both_of_its_placement_are_named(self):
        for frame in FRAMES:
            self.run_rows([r for r in self.rows() if r["frame"] != frame], self.CAMERAS)
            known = read(self.result("rig.csv"))[1]
            for camera in ("left", "right"):
                with self.subTest(camera=camera, frame=frame):
                    rows = self.rows()
                    reverse(views_of(rows)[camera, frame])
                    run = self.run_rows(rows, self.CAMERAS)
                    self.check_reversed(run, camera, frame, known)

    def check_reversed(self, run, camera, frame, known):
        first, second, *more = run.stderr.splitlines()
        self.assertEqual(run.returncode, 1)
        self.assertTrue(first.startswith(
            f"rigcal: frame {frame}: cameras left and right contradict each other, one of the "
            "two is wrong, and both are left out: "), first)
        self.assertRegex(first, f"the points of ({camera}|left or right) are numbered in "
                         "reverse, as if the target were turned by 180 degrees$")
        self.assertIn("number the points from the other end", second)
        self.assertEqual(more, [])
        self.assertEqual(run.stdout.splitlines()[0], f"left out of the rig: left in {frame}, "
                         f"right in {frame} (2 of 14 views)")
        self.assertEqual(self.verdicts(), {
            (c, f): "one_of_two" if f == frame else "fits"
            for c in ("left", "right") for f in FRAMES})
        found = read(self.result("rig.csv"))[1]
        self.assertEqual(found.pop("camera"), "right")
        for name, value in found.items():  # also the covariance
            self.assertLess(abs(float(value) - float(known[name])), 1e-4 if FLOAT else 1e-6)
        self.assertAlmostEqual(float(found["sigma_rot_deg"]) / float(known["sigma_rot_deg"]), 1,
                               delta=1e-2 if FLOAT else 1e-5)
        self.assertNotIn(frame, {r["frame"] for r in read(self.result("targets.csv"))})
        self.assertEqual({r["frame"] for r in read(self.result("residuals.csv"))
                          if r["left_out"] == "1"}, {frame})

    def test_all_views_of_a_camera_reversed(self):
        for camera in ("left", "right"):
            rows = self.rows()
            for (name, _), view in views_of(rows).items():
                if name == camera:
                    reverse(view)
            run = self.run_rows(rows, self.CAMERAS)
            first, second = run.stderr.splitlines()[:2]
            self.assertEqual(run.returncode, 1)
            self.assertTrue(first.startswith(
                "rigcal: there is no rig: most views contradict each other: "), first)
            self.assertIn("the points of all views of left or all views of right are "
                          "numbered in reverse", first)
            self.assertIn("number the points from the other end", second)
            self.assertEqual(list(transforms(self.result("rig.csv"), "camera")), ["left"])

    def test_as_it_is_no_view_is_named(self):
        self.calibrate_well(STEREO)
        self.assertEqual(set(self.verdicts().values()), {"fits"})


def board(rows=5, columns=7, square=0.04):
    return np.array([[j * square, i * square, 0.0] for i in range(rows) for j in range(columns)])


class Simulated(WrongViews):
    """A rig of four cameras, eight placements of a board, noise of 0.2 px."""
    NAMES = "abcd"
    FRAMES = [str(i) for i in range(8)]
    POSES = {"a": (np.eye(3), np.zeros(3)),
             "b": (rotation(0, 0.3, 0.05), np.array([-0.3, 0.02, 0.05])),
             "c": (rotation(0.1, -0.4, 0), np.array([0.4, 0.1, 0.1])),
             "d": (rotation(-0.3, 0.1, 0.1), np.array([-0.1, -0.3, 0.1]))}

    def setUp(self):
        super().setUp()
        rng = np.random.default_rng(11)
        self.camera_rows = {n: camera_row(n) for n in self.NAMES}
        X = board()
        self.rows = []
        for frame in self.FRAMES:
            R = rotation(*rng.uniform(-0.4, 0.4, 3))
            t = np.array([*rng.uniform(-0.1, 0.1, 2), rng.uniform(0.8, 1.2)])
            target = R, t - R @ X.mean(0)
            for name in self.NAMES:
                R_c, t_c = compose(self.POSES[name], target)
                uv = Camera(self.camera_rows[name]).project(X @ R_c.T + t_c)
                uv += rng.normal(0, 0.2, uv.shape)
                self.rows += [dict(frame=frame, camera=name, point=f"p{i}", X=x[0], Y=x[1],
                                   Z=x[2], u=p[0], v=p[1])
                              for i, (x, p) in enumerate(zip(X, uv))]

    def run_sim(self, *options):
        head = list(self.camera_rows["a"])
        path = write(self.folder, "cameras.csv", "\n".join(
            [",".join(head), *(",".join(str(r[k]) for k in head)
                               for r in self.camera_rows.values())]) + "\n")
        run = self.run_rows(self.rows, path, *options)
        lines = run.stderr.splitlines() + ["", ""]
        measured("\n".join(lines[:2]))
        return run, lines[0], lines[1]

    def view(self, camera, frame):
        return views_of(self.rows)[camera, frame]

    def give(self, camera, frame, pixels):
        for r, (u, v) in zip(self.view(camera, frame), pixels):
            r["u"], r["v"] = u, v

    def pixels(self, camera, frame):
        return [(r["u"], r["v"]) for r in self.view(camera, frame)]

    def assert_left_out(self, *views):
        found = {k for k, verdict in self.verdicts().items() if verdict != "fits"}
        self.assertEqual(found, set(views))

    def assert_right(self, names="bcd"):
        """The rig is the true one, within its own standard deviations."""
        rig = transforms(self.result("rig.csv"), "camera")
        rows = {r["camera"]: r for r in read(self.result("rig.csv"))}
        for name in names:
            self.assertLess(angle_deg(rig[name][0], self.POSES[name][0]),
                            4 * float(rows[name]["sigma_rot_deg"]))


class TestBrokenSets(Simulated):
    def test_nothing_is_wrong(self):
        run, first, _ = self.run_sim()
        self.assertEqual((run.returncode, first), (0, ""))
        self.assert_left_out()
        self.assert_right()

    def test_reversed(self):
        reverse(self.view("c", "3"))
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 3: camera c contradicts the others and is left "
                         "out: the points of c are numbered in reverse, as if the target were "
                         "turned by 180 degrees")
        self.assertEqual(second, "rigcal:   number the points from the other end of the target")
        self.assert_left_out(("c", "3"))
        self.assert_right()

    def test_swapped(self):
        b, d = self.pixels("b", "5"), self.pixels("d", "5")
        self.give("b", "5", d)
        self.give("d", "5", b)
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 5: cameras b and d contradict the others and are "
                         "left out: the views of b and d are swapped")
        self.assertEqual(second, "rigcal:   give each image the name of the camera that took it")
        self.assert_left_out(("b", "5"), ("d", "5"))
        self.assert_right()

    def test_late(self):
        """One view shows the frame before, in another image of it, so its pixels differ."""
        rng = np.random.default_rng(3)
        self.give("b", "4", (np.array(self.pixels("b", "3"))
                             + rng.normal(0, 0.2, (35, 2))).tolist())
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 4: camera b contradicts the others and is left "
                         "out: the view of b is of the frame before: the camera is late")
        self.assertEqual(second, "rigcal:   give each image the frame in which it was taken")
        self.assert_left_out(("b", "4"))
        self.assert_right()

    def test_late_in_all_frames(self):
        was = {f: self.pixels("b", f) for f in self.FRAMES}
        for before, frame in zip(self.FRAMES, self.FRAMES[1:]):
            self.give("b", frame, was[before])
        self.rows = [r for r in self.rows if (r["camera"], r["frame"]) != ("b", "0")]
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertRegex(first, r"\Arigcal: camera b contradicts the others in 7 of 7 frames, "
                         r"where it is left out: each view of b is of the frame before: the "
                         r"camera is late\Z")
        self.assertEqual(second, "rigcal:   give each image the frame in which it was taken")
        self.assertEqual(sorted(transforms(self.result("rig.csv"), "camera")), ["a", "c", "d"])
        self.assert_right("cd")

    def test_all_of_a_camera_reversed(self):
        for camera in "ad":  # the first camera, whose frame the rig would have, and another
                             # one
            for frame in self.FRAMES:
                reverse(self.view(camera, frame))
            run, first, second = self.run_sim()
            self.assertEqual(run.returncode, 1)
            self.assertRegex(first, rf"\Arigcal: camera {camera} contradicts the others in 8 of "
                             rf"8 frames, where it is left out: the points of all views of "
                             rf"{camera} are numbered in reverse")
            self.assertEqual(second,
                             "rigcal:   number the points from the other end of the target")
            self.assert_left_out(*((camera, f) for f in self.FRAMES))
            rig = transforms(self.result("rig.csv"), "camera")
            self.assertEqual(sorted(rig), sorted(set("abcd") - {camera}))
            self.assertLess(np.abs(rig["b" if camera == "a" else "a"][0] - np.eye(3)).max(),
                            1e-12)
            for frame in self.FRAMES:
                reverse(self.view(camera, frame))

    def test_all_of_one_of_three_cameras_reversed(self):
        del self.camera_rows["d"]
        self.rows = [r for r in self.rows if r["camera"] != "d"]
        for frame in self.FRAMES:
            reverse(self.view("b", frame))
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertRegex(first, r"\Arigcal: camera b contradicts the others in 8 of 8 frames, "
                         r"where it is left out: the points of all views of b are numbered in "
                         r"reverse")
        self.assertIn("number the points from the other end", second)
        self.assert_left_out(*(("b", f) for f in self.FRAMES))
        self.assert_right("c")

    def test_cameras_are_told_before_views(self):
        reverse(self.view("c", "3"))
        self.view("a", "1")[17]["u"] += 60
        self.camera_rows["e"] = camera_row("e")
        run, first, _ = self.run_sim()
        self.assertEqual(run.returncode, 1)
        lines = run.stderr.splitlines()
        self.assertIn("camera e is not in the rig", first)
        self.assertIn("camera a in frame 1: point p17 is wrong", lines[2])
        self.assertIn("frame 3: camera c contradicts the others", lines[4])
        self.assertEqual(len(lines), 6)

    def test_disconnected(self):
        self.rows = [r for r in self.rows
                     if (r["camera"] in "ab") == (int(r["frame"]) < 4)]
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertTrue(first.startswith("rigcal: the cameras are disconnected, these groups "
                                         "share no frame: a and b; c and d. "), first)
        self.assertRegex(second, r"\Arigcal:   show the target to [ab] and [cd] together|"
                         r"\Arigcal:   show the target to [cd] and [ab] together")

    def test_wrong_unit(self):
        """One camera in one frame has millimetres. Its points have other names."""
        for r in self.rows:
            r["point"] = f"{r['camera']}{r['point']}"
        for r in self.view("c", "2"):
            r["X"], r["Y"], r["Z"] = (1000 * r[k] for k in "XYZ")
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 2: camera c contradicts the others and is left "
                         "out: the target's coordinates for c are 1000 times those of the "
                         "others: a wrong unit")
        self.assertEqual(second, "rigcal:   give X, Y, Z of all observations in the same unit")
        self.assert_left_out(("c", "2"))
        self.assert_right()

    def test_wrong_unit_within_a_frame(self):
        for r in self.view("c", "2"):
            r["X"], r["Y"], r["Z"] = (25.4 * r[k] for k in "XYZ")
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 2)
        self.assertIn("frame 2: the coordinates for camera c are 25.4 times those for camera",
                      first)
        self.assertIn("a wrong unit", first)
        self.assertIn("give X, Y, Z of all observations in the same unit", second)

    def test_mirrored_within_a_frame(self):
        for r in self.view("c", "2"):
            r["Y"] = -r["Y"]
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 2)
        self.assertRegex(first, "frame 2: the coordinates for camera . are those for camera . "
                         "with other signs: one of the two is mirrored")
        self.assertIn("right-handed axes", second)

    def test_mirrored(self):
        """Observations in which one view has a mirrored image."""
        self.give("b", "6", [(1279 - u, v) for u, v in self.pixels("b", "6")])
        self.check_mirrored(*self.run_sim())

    def test_v_counts_upwards(self):
        self.give("b", "6", [(u, 959 - v) for u, v in self.pixels("b", "6")])
        self.check_mirrored(*self.run_sim())

    def check_mirrored(self, run, first, second):
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 6: camera b contradicts the others and is left "
                         "out: the image of b is mirrored")
        self.assertIn("do not mirror the image", second)
        self.assert_left_out(("b", "6"))
        self.assert_right()

    def test_numbered_as_in_a_mirror(self):
        """Names each row of the board from its other end."""
        pixels = np.array(self.pixels("b", "6")).reshape(5, 7, 2)[:, ::-1]
        self.give("b", "6", pixels.reshape(-1, 2).tolist())
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 6: camera b contradicts the others and is left "
                         "out: the points of b are numbered as in a mirror, or their "
                         "coordinates are mirrored")
        self.assertIn("not from behind it", second)
        self.assert_left_out(("b", "6"))
        self.assert_right()

    def test_wrong_intrinsics_of_one_camera(self):
        self.camera_rows["c"]["fx"] *= 1.2
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertRegex(first, r"\Arigcal: camera c contradicts the others in 8 of 8 frames, "
                         r"where it is left out: its intrinsics are wrong, its views fit by "
                         r"themselves to [\d.]+ px, those of other cameras to 0\.[12]\d* px\Z")
        self.assertIn("check its line of cameras.csv", second)

    def test_very_wrong_intrinsics_of_one_camera(self):
        self.camera_rows["c"]["k1"] = -0.9
        self.camera_rows["c"]["fx"] *= 1.6
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertRegex(first, r"\Arigcal: camera c: the intrinsics are wrong: its views fit by "
                         r"themselves to [\d.]+ px, those of the other cameras to 0\.[12]\d* px")
        self.assertIn("check its line of cameras.csv", second)
        self.assert_right("bd")

    def test_one_bad_point(self):
        for wrong in (10, 60):
            self.setUp()
            self.view("d", "1")[17]["u"] += wrong
            run, first, second = self.run_sim()
            left_out = "left out of the rig" in run.stderr
            self.assertEqual(run.returncode, 1 if left_out else 0)
            self.assertRegex(first, r"\Arigcal: camera d in frame 1: point p17 is wrong: without "
                             r"it the others fit to 0\.[23]\d* px rms, with it to ")
            self.assertIn("correct it, remove its line, or use --robust", second)
            run, first, second = self.run_sim("--robust")
            self.assertEqual(run.returncode, 0)
            self.assertIn("--robust leaves out 1 of 35 points: p17", first)
            self.assert_left_out()
            self.assert_right()

    def test_duplicate_frame(self):
        self.give("b", "6", self.pixels("b", "2"))
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: frame 6 is a duplicate of frame 2 in camera b: all "
                         "pixels are the same")
        self.assertIn("remove the lines of the frame", second)
        self.assert_left_out(("b", "6"))
        self.assert_right()

    def test_empty_camera(self):
        self.camera_rows["e"] = camera_row("e")
        run, first, second = self.run_sim()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(first, "rigcal: camera e is not in the rig: there are no observations "
                         "of it")
        self.assertIn("check its name in observations.csv", second)
        self.assert_left_out()
        self.assert_right()


class TestUnchecked(Simulated):
    def test_a_placement_that_one_camera_saw_is_unchecked(self):
        self.rows = [r for r in self.rows if r["frame"] not in "12" or r["camera"] == "b"]
        run, first, _ = self.run_sim()
        self.assertEqual((run.returncode, first), (0, ""))
        self.assertEqual(run.stdout.splitlines()[0],
                         "unchecked: 2 views, whose placement no other camera saw")
        self.assertEqual({k for k, v in self.verdicts().items() if v == "unchecked"},
                         {("b", "1"), ("b", "2")})
        self.assert_right()


class TestGraph(Simulated):
    def test_pairs_tell_what_they_share(self):
        """Camera d sees the target in one frame, which it shares with a alone."""
        self.rows = [r for r in self.rows if r["camera"] != "d" or r["frame"] == "0"]
        run, _, _ = self.run_sim()
        for a, b in itertools.combinations("abcd", 2):
            n = 1 if "d" in (a, b) else 8
            self.assertRegex(run.stdout, rf"(?m)^{a} +{b} .* 0\.\d+  over {n} placements?$")
        self.assertRegex(run.stdout, r"(?m)^weakest: camera d, \+- ")
        self.assertRegex(run.stdout, r"(?m)^next: show the target to d and [abc] together")


if __name__ == "__main__":
    unittest.main()
