"""A signal left the temporary files of calibrate --out behind."""
import os
import signal
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import OUTPUTS, STEREO, CliTest, with_fault, write  # noqa: E402


class TestSignalLeavesTemporaries(CliTest):
    def run_with_fault(self, fault):
        return with_fault(fault, "calibrate", "--cameras", STEREO + "/cameras.csv",
                          "--observations", STEREO + "/observations.csv",
                          "--out", self.out)

    def test_all_files_are_there_or_none(self):
        """A signal before the first rename, when it is too late to give up."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(signal=number):
                run = self.run_with_fault(f"rename:1:{-number}")
                self.assertEqual(run.returncode, -number)
                self.assertIn(sorted(os.listdir(self.folder)), ([], ["out"]))
                if os.path.exists(self.out):
                    self.assertEqual(sorted(os.listdir(self.out)), sorted(OUTPUTS))

    def test_one_that_is_ignored_does_not_matter(self):
        run = with_fault(f"fdopen:2:{-signal.SIGHUP}", "calibrate", "--cameras",
                         STEREO + "/cameras.csv", "--observations",
                         STEREO + "/observations.csv", "--out", self.out,
                         ignored=[signal.SIGHUP])
        self.assertEqual(run.returncode, 0)
        self.assertEqual(sorted(os.listdir(self.out)), sorted(OUTPUTS))

    def test_while_the_files_are_written(self):
        os.mkdir(self.out)
        write(self.out, "poses.csv", "as it was")
        for call in (1, 2, len(OUTPUTS)):
            run = self.run_with_fault(f"fdopen:{call}:{-signal.SIGTERM}")
            self.assertEqual(run.returncode, -signal.SIGTERM)
            self.assertEqual(self.files(), {self.result("poses.csv"): "as it was"})


if __name__ == "__main__":
    unittest.main()
