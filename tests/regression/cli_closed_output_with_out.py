"""With standard output closed, calibrate --out wrote its files, but denied it."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import BIN, OUTPUTS, STEREO, CliTest, sound, write  # noqa: E402


class TestClosedOutput(CliTest):
    def run_in_shell(self, redirection, observations=STEREO + "/observations.csv"):
        return sound(subprocess.run(
            ["sh", "-c", "exec \"$@\" " + redirection, "sh", BIN, "calibrate",
             "--cameras", STEREO + "/cameras.csv", "--observations", observations,
             "--out", self.out], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True))

    def test_no_file_is_written_when_the_summary_cannot_be(self):
        for redirection in (">&-", ">/dev/full"):
            with self.subTest(redirection=redirection):
                run = self.run_in_shell(redirection)
                self.assertEqual(run.returncode, 2)
                self.assertRegex(run.stderr, "standard output: .*; no file was written")
                self.assertFalse(os.path.exists(self.out))

    def test_earlier_files_stay(self):
        os.mkdir(self.out)
        write(self.out, "poses.csv", "as it was")
        self.assertEqual(self.run_in_shell(">&-").returncode, 2)
        self.assertEqual(self.files(), {self.result("poses.csv"): "as it was"})

    def test_closed_standard_files_are_not_taken_by_others(self):
        self.calibrate_well(STEREO)
        usual = self.files()
        self.assertEqual(self.run_in_shell("<&- 2>&-").returncode, 0)
        self.assertEqual(self.files(), usual)
        self.assertEqual(sorted(os.listdir(self.out)), sorted(OUTPUTS))


if __name__ == "__main__":
    unittest.main()
