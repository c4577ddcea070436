"""Names that look alike are distinguished, and a message says so."""
import os
import unittest

from cli_support import STEREO, CliTest, content, read, rigcal, write


class TestNames(CliTest):
    def observations(self, change):
        """The observations of the stereo pair. `change` maps frame, camera and point."""
        head, *lines = content(STEREO, "observations.csv").splitlines()
        rows = [line.split(",") for line in lines]
        return write(self.folder, "o.csv", "\n".join([head] + [
            ",".join([*change(*row[:3]), *row[3:]]) for row in rows]))

    def run_with(self, change):
        path = self.observations(change)
        return path, self.calibrate(STEREO + "/cameras.csv", path)

    def note(self, path, kind, a, b):
        return (f"rigcal: {path}: {kind}s {a} and {b} are taken as two different "
                f"{kind}s: if they are one, spell them alike\n")

    def frames(self, *names):
        """The seven frames. The first ones get these names."""
        known = ["01", "03", "05", "07", "09", "12", "14"]
        new = {**{k: "f" + k for k in known}, **dict(zip(known, names))}
        return self.run_with(lambda f, c, p: [new[f], c, p])

    def test_frames_that_look_alike(self):
        for a, b in (("5", "05"), ("5", "0005"), ("5", "5.0"), ("shot1", "shot01"),
                     ("a01b2", "a1b02"), ("Shot", "shot"), ("\u00c9t\u00e9", "\u00e9T\u00c9"),
                     ("x", "x\u00a0"), ("x", "\u200bx"), ("2024-01-05", "2024-1-5")):
            with self.subTest(names=(a, b)):
                path, run = self.frames(a, b)
                self.assertEqual((run.returncode, run.stderr),
                                 (0, self.note(path, "frame", a, b)))
                found = [r["frame"] for r in read(self.result("targets.csv"))]
                self.assertEqual(found[:2], [a, b])

    def test_frames_that_do_not(self):
        for a, b in (("5", "50"), ("1.05", "1.5"), ("a10", "a1"), ("a0", "a"),
                     ("12345678901234567890", "12345678901234567891"),
                     ("5", "s"), ("a-1", "a1"), ("0", "00x")):
            with self.subTest(names=(a, b)):
                self.assertEqual(self.frames(a, b)[1].stderr, "")

    def test_points_that_look_alike(self):
        path, run = self.run_with(
            lambda f, c, p: [f, c, {"7": "P1", "9": "p1"}.get(p, "x" + p)])
        self.assertEqual((run.returncode, run.stderr),
                         (0, self.note(path, "point", "P1", "p1")))

    def test_of_many_pairs_three_are_named(self):
        path, run = self.run_with(lambda f, c, p: [f, c, "p" + p if int(p) % 2 else
                                                   f"P0{int(p) + 1}"])
        self.assertEqual(run.returncode, 0)
        *named, more = run.stderr.splitlines(keepends=True)
        self.assertEqual(named, [self.note(path, "point", f"P0{k}", f"p{k}")
                                 for k in (1, 3, 5)])
        self.assertEqual(more, f"rigcal: {path}: so are 24 more pairs of points\n")

    def test_cameras_that_look_alike(self):
        table = content(STEREO, "cameras.csv").replace("right", "LEFT")
        cameras = write(self.folder, "c.csv", table)
        path = self.observations(lambda f, c, p: [f, "left" if c == "left" else "LEFT",
                                                  p])
        run = self.calibrate(cameras, path)
        self.assertEqual((run.returncode, run.stderr),
                         (0, self.note(cameras, "camera", "left", "LEFT")))
        self.assertEqual([r["camera"] for r in read(self.result("rig.csv"))],
                         ["left", "LEFT"])

    def test_a_camera_in_another_spelling_is_not_guessed(self):
        path, run = self.run_with(lambda f, c, p: [f, c.upper(), p])
        self.assertEqual(run.returncode, 2)
        self.assertEqual(run.stderr, f"{path}:2: camera LEFT is not in {STEREO}/"
                                     "cameras.csv, but left is: spell them alike\n")
        run = rigcal("line", "--cameras", STEREO + "/cameras.csv", "--rig",
                     STEREO + "/reference_rig.csv", "--from", "Left", "--to", "right",
                     "--pixel", "300,200")
        self.assertEqual(run.returncode, 2)
        self.assertIn("camera Left is not in", run.stderr)
        self.assertIn("but this one is: left", run.stderr)

    def test_a_frame_in_another_spelling_has_no_place(self):
        path = self.observations(lambda f, c, p: [str(int(f)), c, p])
        run = rigcal("triangulate", "--cameras", STEREO + "/cameras.csv", "--rig",
                     STEREO + "/reference_rig.csv", "--targets",
                     STEREO + "/reference_targets.csv", "--observations", path)
        self.assertEqual(run.returncode, 1)
        self.assertIn(f"frame 1 has no place in {STEREO}/reference_targets.csv, which "
                      "has frame 01; its points are left out", run.stderr)

    def test_blanks_that_are_seen_are_refused(self):
        path, run = self.run_with(lambda f, c, p: [f, c, p + " " if p == "3" else p])
        self.assertEqual(run.returncode, 2)
        self.assertRegex(run.stderr, rf"{path}:\d+: column point: .*\[3 \]")

    def test_the_locale_does_not_matter(self):
        path = self.observations(lambda f, c, p: [{"01": "\u00c9", "03": "\u00e9"}.get(f, f),
                                                  c, p])
        for locale in ("C", "C.UTF-8", "none_such"):
            run = rigcal("calibrate", "--cameras", STEREO + "/cameras.csv",
                         "--observations", path, env={**os.environ, "LC_ALL": locale})
            self.assertEqual(run.stderr, self.note(path, "frame", "\u00c9", "\u00e9"))


if __name__ == "__main__":
    unittest.main()
