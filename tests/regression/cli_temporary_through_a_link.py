"""calibrate --out followed links with the names of its temporary files, which can be
guessed, and wrote through them."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import BIN, OUTPUTS, STEREO, CliTest, content, sound, write  # noqa: E402


class TestTemporaryThroughALink(CliTest):
    def test_what_a_link_points_to_is_left_alone(self):
        os.mkdir(self.out)
        victim = write(self.folder, "victim", "as it was")
        # The shell's process number becomes that of the program.
        links = "; ".join(f"ln -s {victim} {self.out}/{name}.$$" for name in OUTPUTS)
        run = sound(subprocess.run(
            ["sh", "-c", links + "; exec \"$@\"", "sh", BIN, "calibrate", "--cameras",
             STEREO + "/cameras.csv", "--observations", STEREO + "/observations.csv",
             "--out", self.out], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True))
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(content(self.folder, "victim"), "as it was")


if __name__ == "__main__":
    unittest.main()
