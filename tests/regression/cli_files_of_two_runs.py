"""calibrate --out left files of two runs side by side when it could not replace one,
or was killed before it had replaced them all."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import OUTPUTS, STEREO, CliTest, with_fault, write  # noqa: E402


EIO, SIGKILL = 5, 9


class TestFilesOfTwoRuns(CliTest):
    def run_with_fault(self, fault):
        return with_fault(fault, "calibrate", "--cameras", STEREO + "/cameras.csv",
                          "--observations", STEREO + "/observations.csv",
                          "--out", self.out)

    def earlier_files(self):
        os.makedirs(self.out, exist_ok=True)
        for name in OUTPUTS:
            write(self.out, name, "as it was")
        return self.files()

    def test_a_rename_that_fails_changes_nothing(self):
        for call in range(1, 2 * len(OUTPUTS) + 1):
            with self.subTest(call=call):
                earlier = self.earlier_files()
                run = self.run_with_fault(f"rename:{call}:{EIO}")
                if run.returncode != 0:  # otherwise the program makes no such call
                    self.assertEqual(run.returncode, 2)
                    self.assertRegex(run.stderr, "cannot write .*no file was written")
                    self.assertEqual(self.files(), earlier)

    def test_a_rename_that_fails_leaves_no_new_file(self):
        os.mkdir(self.out)
        write(self.out, "poses.csv", "as it was")
        earlier = self.files()
        run = self.run_with_fault(f"rename:{2 * len(OUTPUTS)}:{EIO}")
        self.assertEqual(run.returncode, 2)
        self.assertEqual(self.files(), earlier)

    def test_a_killed_run_leaves_no_new_file_beside_an_earlier_one(self):
        for call in range(1, 2 * len(OUTPUTS) + 1):
            with self.subTest(call=call):
                self.out = os.path.join(self.folder, str(call))
                self.earlier_files()
                self.run_with_fault(f"rename:{call}:{-SIGKILL}")
                files = {path: text for path, text in self.files().items() if text}
                here = [text == "as it was" for path, text in files.items()
                        if os.path.dirname(path) == self.out]
                self.assertIn(sum(here), (0, len(here)))
                self.assertEqual(list(files.values()).count("as it was"),
                                 len(OUTPUTS))

    def test_the_next_run_names_what_a_killed_one_left(self):
        self.earlier_files()
        self.run_with_fault(f"rename:3:{-SIGKILL}")
        run = self.run_with_fault("")
        self.assertEqual(run.returncode, 0)
        self.assertRegex(run.stderr, rf"{self.out}/rigcal-unfinished-\w+ is of a run "
                                     "that was killed")

    def test_a_killed_run_leaves_no_new_folder(self):
        self.run_with_fault(f"rename:1:{-SIGKILL}")
        self.assertFalse(os.path.exists(self.out))


if __name__ == "__main__":
    unittest.main()
