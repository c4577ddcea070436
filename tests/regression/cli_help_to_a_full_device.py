"""calibrate --help ended with status 0 when its text could not be written."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import BIN, sound  # noqa: E402


@unittest.skipUnless(os.path.exists("/dev/full"), "needs /dev/full")
class TestHelpToAFullDevice(unittest.TestCase):
    def test_what_cannot_be_printed_is_an_error(self):
        for arguments in (["--help"], ["--version"], ["calibrate", "--help"],
                          ["triangulate", "--help"], ["line", "--help"]):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                run = sound(subprocess.run([BIN, *arguments], stdout=full,
                                           stderr=subprocess.PIPE, text=True))
                self.assertEqual(run.returncode, 2)
                self.assertRegex(run.stderr, "standard output: No space left")


if __name__ == "__main__":
    unittest.main()
