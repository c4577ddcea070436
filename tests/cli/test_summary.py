"""summary.json says what is printed; --progress says how much of the work is done."""
import json
import unittest

from cli_support import (CAVITY, STEREO, CliTest, camera_row, content, made_up, read, rotation,
                         write)


class TestSummary(CliTest):
    def summary(self):
        return json.loads(content(self.out, "summary.json"))

    def stereo(self, change):
        """The stereo pair after a change of its observations. The function gets the columns
        of each, and returns them or None."""
        head, *lines = content(STEREO, "observations.csv").splitlines()
        rows = [change(line.split(",")) for line in lines]
        path = write(self.folder, "o.csv", "\n".join(
            [head, *(",".join(row) for row in rows if row is not None)]) + "\n")
        return self.calibrate(STEREO + "/cameras.csv", path)

    def told(self, run):
        """The messages in pairs: what is wrong, and what to do."""
        lines = run.stderr.splitlines()
        return [(a.split("rigcal: ", 1)[1], b.split("rigcal:   ", 1)[1])
                for a, b in zip(lines, lines[1:]) if b.startswith("rigcal:   ")]

    def test_numbers_are_those_that_are_printed(self):
        run = self.calibrate_well(STEREO)
        s = self.summary()
        self.assertEqual((s["exit_status"], s["frame"], s["findings"]), (0, "left", []))
        self.assertIn(f"rig: {s['n_views']} views, {s['n_points']} points, sigma "
                      f"{s['sigma_px']:.3g} px", run.stdout)
        self.assertIn(f"sqrt(F) {s['sqrt_F']:.2f}: the views", run.stdout)
        self.assertIn(f"F has {s['freedom_between']:.0f} and {s['freedom_within']:.0f} degrees",
                      run.stdout)
        self.assertIn(f"for noise of {s['noise_px']:.3g} px", run.stdout)
        self.assertAlmostEqual(s["sqrt_F"]**2, s["F"], delta=1e-6 * s["F"])
        self.assertEqual(s["verdict"], "found")
        self.assertIn("\n" + s["sentences"] + "\n", run.stdout)
        self.assertIn("\nnext: " + s["next"] + "\n", run.stdout)
        self.assertIn(f"\nweakest: camera {s['weakest']},", run.stdout)

    def test_what_is_not_known_is_null(self):
        self.calibrate_well(CAVITY)
        s = self.summary()
        for key in ("F", "sqrt_F", "verdict", "sentences"):
            self.assertIsNone(s[key], key)
        self.assertEqual(s["freedom_between"], 0)
        self.calibrate_set(STEREO, "--method", "paper")
        s = self.summary()
        for key in ("n_points", "sigma_px", "noise_px", "F", "freedom_within", "verdict", "next",
                    "weakest"):
            self.assertIsNone(s[key], key)

    def test_a_view_left_out_has_its_reason(self):
        cameras = {n: camera_row(n) for n in "abc"}
        poses = {n: (rotation(0, 0.1 * k, 0), [0.2 * k, 0, 5.0]) for k, n in enumerate("abc")}
        targets = {f: (rotation(0.1 * k, 0.2, 0), [0, 0, 0.1 * k]) for k, f in enumerate("uvwx")}
        c, o = made_up(cameras, poses, targets, {f: "abc" for f in targets})
        rows = [line.split(",") for line in o.splitlines()]
        for row in rows:  # view b of w gets the pixels of another placement
            if row[:2] == ["w", "b"]:
                row[6] = repr(float(row[6]) + 30)
        run = self.calibrate(write(self.folder, "c.csv", c),
                             write(self.folder, "o.csv", "\n".join(map(",".join, rows)) + "\n"))
        left_out = [(r["camera"], r["frame"]) for r in read(self.result("poses.csv"))
                    if r["verdict"] == "contradicts"]
        s = self.summary()
        self.assertEqual((run.returncode, s["exit_status"], left_out), (1, 1, [("b", "w")]))
        found, = s["findings"]
        self.assertEqual((found["about"], found["cameras"], found["frames"]),
                         ("view", ["b"], ["w"]))
        self.assertEqual(self.told(run), [(found["what"], found["advice"])])

    def test_findings_are_the_messages_in_their_order(self):
        run = self.stereo(lambda r: [r[0], r[1], r[2], *r[3:]] if r[:2] != ["05", "left"]
                          else [*r[:3], *r[3:6], repr(float(r[6]) + 40), r[7]])
        s = self.summary()
        self.assertEqual(run.returncode, 1)
        self.assertEqual(self.told(run), [(f["what"], f["advice"]) for f in s["findings"]])
        found, = s["findings"]
        self.assertEqual((found["cameras"], found["frames"]), (["left", "right"], ["05"]))

    def test_a_view_without_a_pose_has_its_reason(self):
        run = self.stereo(lambda r: r if r[:2] != ["05", "left"] or int(r[2]) < 2 else None)
        found = [f for f in self.summary()["findings"] if f["frames"] == ["05"]]
        self.assertEqual([f["cameras"] for f in found], [["left"]])
        self.assertIn("rigcal: " + found[0]["what"] + "\n", run.stderr)
        self.assertEqual(run.stderr.count("has no pose"), 1)

    def test_a_duplicate_has_both_frames(self):
        seen = {}
        def change(r):
            if r[1] == "left" and r[0] == "03":
                seen[r[2]] = r[6:]
            return [*r[:6], *seen[r[2]]] if r[:2] == ["07", "left"] else r
        self.stereo(change)
        found = [f for f in self.summary()["findings"] if "duplicate" in f["what"]]
        self.assertEqual([(f["cameras"], f["frames"]) for f in found], [(["left"], ["07", "03"])])

    def test_a_camera_without_observations_has_its_reason(self):
        c = write(self.folder, "c.csv", content(STEREO, "cameras.csv").rstrip("\n") + "\n"
                  + content(STEREO, "cameras.csv").splitlines()[1].replace("left", "third") + "\n")
        self.calibrate(c, STEREO + "/observations.csv")
        self.assertEqual([(f["about"], f["cameras"]) for f in self.summary()["findings"]],
                         [("camera", ["third"])])

    def test_wrong_intrinsics_are_of_the_camera_and_its_views_are_not_told(self):
        rows = read(STEREO + "/cameras.csv")
        rows[1]["k1"] = "0.6"
        c = write(self.folder, "c.csv", "\n".join(
            [",".join(rows[0]), *(",".join(r.values()) for r in rows)]) + "\n")
        run = self.calibrate(c, STEREO + "/observations.csv")
        findings = self.summary()["findings"]
        self.assertIn(("camera", ["right"], []),
                      [(f["about"], f["cameras"], f["frames"]) for f in findings])
        told = [what.replace("; the view is left out of the rig", "")
                for what, _ in self.told(run)]
        self.assertEqual(told, [f["what"] for f in findings])

    def test_names_of_any_text(self):
        NAME = "l\\\u00e9ft"
        def named(text):
            return text.replace("left", NAME)
        c = write(self.folder, "c.csv", named(content(STEREO, "cameras.csv")))
        o = write(self.folder, "o.csv", named(content(STEREO, "observations.csv")))
        self.assertEqual(self.calibrate(c, o).returncode, 0)
        self.assertEqual(self.summary()["frame"], NAME)


class TestProgress(CliTest):
    def test_lines_when_asked_and_the_same_result(self):
        plain = self.calibrate_well(STEREO)
        before = content(self.out, "rig.csv")
        self.assertEqual(plain.stderr, "")
        run = self.calibrate_set(STEREO, "--progress")
        self.assertEqual((run.returncode, run.stdout), (0, plain.stdout))
        self.assertEqual(content(self.out, "rig.csv"), before)
        lines = run.stderr.splitlines()
        self.assertTrue(all(line.startswith("rigcal-progress: ") for line in lines))
        self.assertEqual([line for line in lines if "view " in line],
                         [f"rigcal-progress: view {k} of 14" for k in range(1, 15)])
        self.assertNotIn("\033", run.stderr)


if __name__ == "__main__":
    unittest.main()
