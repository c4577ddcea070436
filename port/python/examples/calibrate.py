"""Calibrates a rig from two CSV files: a folder of examples/data, or your own."""

import pathlib
import sys

import rigcal

folder = pathlib.Path(sys.argv[1])
rig = rigcal.calibrate(folder / "cameras.csv", folder / "observations.csv")
print(rig.report, end="")
