"""calibrate --out made only the last folder of its path."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import OUTPUTS, STEREO, CliTest, rigcal, write  # noqa: E402


class TestOutMakesThePath(CliTest):
    def test_all_folders_are_made(self):
        for path in ("a/b/c", "d//e/", "f/../g", "h/./i/."):
            with self.subTest(path=path):
                out = os.path.join(self.folder, path)
                run = self.calibrate(STEREO + "/cameras.csv",
                                     STEREO + "/observations.csv", out)
                self.assertEqual((run.returncode, run.stderr), (0, ""))
                self.assertEqual(sorted(os.listdir(out)), sorted(OUTPUTS))

    def test_their_modes_are_those_of_mkdir(self):
        out = os.path.join(self.folder, "a", "b")
        before = os.umask(0o027)
        try:
            self.calibrate(STEREO + "/cameras.csv", STEREO + "/observations.csv", out)
        finally:
            os.umask(before)
        for path, mode in (("a", 0o750), ("a/b", 0o750), ("a/b/poses.csv", 0o640)):
            self.assertEqual(os.stat(os.path.join(self.folder, path)).st_mode & 0o777,
                             mode)

    def test_an_empty_path_is_named(self):
        run = rigcal("calibrate", "--cameras", STEREO + "/cameras.csv",
                     "--observations", STEREO + "/observations.csv", "--out", "")
        self.assertEqual(run.returncode, 2)
        self.assertIn("--out names no folder", run.stderr)

    def test_none_stays_when_one_cannot_be_made(self):
        write(self.folder, "file", "a file")
        for path in ("new/../file", "new/../file/b", "new/" + "x" * 300,
                     "new/x/" + "y" * 300 + "/z"):
            with self.subTest(path=path):
                run = self.calibrate(STEREO + "/cameras.csv",
                                     STEREO + "/observations.csv",
                                     os.path.join(self.folder, path))
                self.assertEqual(run.returncode, 2)
                self.assertRegex(run.stderr, "cannot write .*; no file was written")
                self.assertEqual(os.listdir(self.folder), ["file"])


if __name__ == "__main__":
    unittest.main()
