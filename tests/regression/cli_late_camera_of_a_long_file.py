"""If one camera was late, the time of calibrate grew with the square of the number of its
views: a million lines would have taken two days."""
import os
import resource
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import SANITIZED, CliTest, camera_row, made_up, rotation, write  # noqa: E402

NAMES = ("a", "b", "c")
MOST = 5.0  # times as much processor time for four times the frames; the square is 16


class TestLateCamera(CliTest):
    def record(self, n_frames):
        """Camera b's pictures have the number of the frame before."""
        rng = np.random.default_rng(5)
        cams = {name: (rotation(0, angle, 0), np.array([x, 0.0, 6.0]))
                for name, angle, x in zip(NAMES, (0.0, 0.2, -0.2), (0.0, -0.5, 0.5))}
        targets = {f: (rotation(*rng.uniform(-0.4, 0.4, 3)), rng.uniform(-0.5, 0.5, 3))
                   for f in range(n_frames)}
        table, text = made_up({name: camera_row(name) for name in NAMES}, cams, targets,
                              dict.fromkeys(targets, NAMES))
        head, *lines = text.splitlines()
        fields = [line.split(",") for line in lines]
        late = [",".join([str(int(f[0]) + 1) if f[1] == "b" else f[0], *f[1:]]) for f in fields]
        write(self.folder, "observations.csv", "\n".join([head, *late, ""]))
        return write(self.folder, "cameras.csv", table)

    def seconds(self, n_frames):
        """The processor's seconds, and what the program says."""
        table = self.record(n_frames)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = self.calibrate(table, os.path.join(self.folder, "observations.csv"))
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, run

    @unittest.skipIf(SANITIZED, "the time is that of the program alone")
    def test_time_grows_as_the_file_does(self):
        few, run = self.seconds(400)
        self.assertIn("contradicts the others in 399 of 399 frames, where it is left out: each "
                      "view of b is of the frame before: the camera is late", run.stderr)
        many, run = self.seconds(1600)
        self.assertIn("each view of b is of the frame before: the camera is late", run.stderr)
        self.assertLess(many, MOST * few)


if __name__ == "__main__":
    unittest.main()
