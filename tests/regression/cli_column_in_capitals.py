"""A column K1 or Lens counted as absent, so that the lens had no distortion."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

from cli_support import STEREO, CliTest, content, write  # noqa: E402


class TestColumnInCapitals(CliTest):
    def test_a_column_that_is_nearly_ours_is_named(self):
        for name in ("K1", "P2", "Lens", " k3", "\"k2\""):
            with self.subTest(column=name):
                ours = name.strip().strip("\"").lower()
                head, *lines = content(STEREO, "cameras.csv").splitlines()
                columns = head.split(",")
                if ours in columns:
                    columns[columns.index(ours)] = name
                    table = [",".join(columns), *lines]
                else:
                    table = [head + "," + name] + [line + ",0" for line in lines]
                path = write(self.folder, "cameras.csv", "\n".join(table))
                run = self.calibrate(path, STEREO + "/observations.csv")
                self.assertEqual(run.returncode, 2)
                self.assertEqual(run.stderr, f"{path}:1: column \"{name}\" must be "
                                             f"spelled {ours}\n")


if __name__ == "__main__":
    unittest.main()
