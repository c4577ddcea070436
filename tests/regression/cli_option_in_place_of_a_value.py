"""calibrate --out --robust made a folder named --robust, and ran without --robust."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import BIN, OUTPUTS, STEREO, CliTest, rigcal  # noqa: E402

FILES = ["--cameras", STEREO + "/cameras.csv", "--observations",
         STEREO + "/observations.csv"]
RIG = ["--cameras", STEREO + "/cameras.csv", "--rig", STEREO + "/reference_rig.csv"]


class TestOptionInPlaceOfAValue(CliTest):
    def run_in_folder(self, *arguments):
        return rigcal(*arguments, executable=os.path.abspath(BIN), cwd=self.folder)

    def check_refused(self, option, value, *arguments):
        run = self.run_in_folder(*arguments)
        self.assertEqual((run.returncode, run.stdout), (2, ""))
        self.assertIn(f"{option} needs a value, and {value} follows", run.stderr)
        self.assertEqual(os.listdir(self.folder), [])

    def test_every_option_that_takes_a_value(self):
        for option, value, arguments in (
                ("--out", "--robust", ["calibrate", *FILES, "--out", "--robust"]),
                ("--out", "--", ["calibrate", *FILES, "--out", "--"]),
                ("--sigma", "--out", ["calibrate", *FILES, "--sigma", "--out", "o"]),
                ("--method", "--robust", ["calibrate", *FILES, "--method", "--robust"]),
                ("--threshold", "--seed",
                 ["calibrate", *FILES, "--robust", "--threshold", "--seed", "1"]),
                ("--cameras", "--observations",
                 ["calibrate", "--cameras", "--observations", "o.csv"]),
                ("--observations", "--robust",
                 ["calibrate", *FILES[:2], "--observations", "--robust"]),
                ("--targets", "--sigma",
                 ["triangulate", *RIG, *FILES[2:], "--targets", "--sigma", "1"]),
                ("--rig", "--sigma",
                 ["triangulate", *FILES, "--rig", "--sigma", "1"]),
                ("--from", "--to", ["line", *RIG, "--from", "--to", "right"]),
                ("--pixel", "--depth",
                 ["line", *RIG, "--from", "left", "--to", "right", "--pixel", "--depth",
                  "1,2"])):
            with self.subTest(arguments=arguments):
                self.check_refused(option, value, *arguments)

    def test_an_abbreviation_is_named_in_full(self):
        self.check_refused("--out", "--robust", "calibrate", *FILES, "--ou", "--robust")

    def test_values_that_are_meant(self):
        for arguments, folder in ((["--out=--robust"], "--robust"),
                                  (["--out", "./--sigma"], "--sigma"),
                                  (["--out", "-one"], "-one")):
            with self.subTest(arguments=arguments):
                run = self.run_in_folder("calibrate", *FILES, *arguments)
                self.assertEqual((run.returncode, run.stderr), (0, ""))
                self.assertEqual(sorted(os.listdir(os.path.join(self.folder, folder))), sorted(OUTPUTS))


if __name__ == "__main__":
    unittest.main()
