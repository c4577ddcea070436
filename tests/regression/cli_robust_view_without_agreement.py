"""calibrate --robust freed a view's memory twice when none of its points agreed."""
import os
import random
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import STEREO, CliTest, content, read, write  # noqa: E402


class TestRobustViewWithoutAgreement(CliTest):
    def test_the_view_is_named_and_the_others_are_solved(self):
        number = random.Random(1)
        lines = content(STEREO, "observations.csv").splitlines()
        for i, line in enumerate(lines):
            if line.startswith("01,left,"):
                lines[i] = ",".join(line.split(",")[:6] + [
                    f"{number.uniform(0, 640):.3f}", f"{number.uniform(0, 480):.3f}"])
        run = self.calibrate(STEREO + "/cameras.csv",
                             write(self.folder, "o.csv", "\n".join(lines)), None,
                             "--robust")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("camera left has no pose in frame 01", run.stderr)
        self.assertEqual(len(read(self.result("poses.csv"))), 13)


if __name__ == "__main__":
    unittest.main()
