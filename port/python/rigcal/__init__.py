"""Where each camera of a rig is, from a few points of known shape: see README.md.

All poses are X_b = R X_a + t, named b_from_a; x right, y down, z forward; pixel (0, 0) is
the centre of the top-left pixel; angles in radian, lengths in your unit.
"""

from ._calibrated import CalibratedRig, Pair
from ._library import lib as _lib
from ._names import (
    BlameVerdicts,
    Causes,
    ClockStates,
    DiagnosisVerdicts,
    FaultKinds,
    FaultsVerdicts,
    Status,
    ViewVerdicts,
)
from .calibrate import calibrate
from .camera import Camera
from .detect import AprilGrid, Charuco, Chessboard, Detections, Tag, Tags, detect
from .errors import Caveat, Error, FileError
from .formats import Target, load_cameras, load_target, save_cameras, save_target
from .measure import (
    Bands,
    Curves,
    Matches,
    Pixels,
    Points,
    Rays,
    Spans,
    Transfers,
    distort,
    pixel_to_ray,
    project,
    undistort,
)
from .monitor import BodyReport, Monitor, MonitorReport
from .plots import plot_monitor
from .poses import (
    Blame,
    Diagnosis,
    Pose,
    Poses,
    blame,
    diagnose,
    solve_pose,
    solve_poses,
    solve_tag,
    solve_tags,
)
from .rig import Clock, Fault, LeftOut, Rig, Sigma, load
from .transform import Transform

_number = _lib.version()
__version__ = f"{_number // 10000}.{_number // 100 % 100}.{_number % 100}"

__all__ = [
    "AprilGrid",
    "Bands",
    "Blame",
    "BlameVerdicts",
    "BodyReport",
    "CalibratedRig",
    "Camera",
    "Causes",
    "Caveat",
    "Charuco",
    "Chessboard",
    "Clock",
    "ClockStates",
    "Curves",
    "Detections",
    "Diagnosis",
    "DiagnosisVerdicts",
    "Error",
    "Fault",
    "FaultKinds",
    "FaultsVerdicts",
    "FileError",
    "LeftOut",
    "Matches",
    "Monitor",
    "MonitorReport",
    "Pair",
    "Pixels",
    "Points",
    "Pose",
    "Poses",
    "Rays",
    "Rig",
    "Sigma",
    "Spans",
    "Status",
    "Tag",
    "Tags",
    "Target",
    "Transfers",
    "Transform",
    "ViewVerdicts",
    "__version__",
    "blame",
    "calibrate",
    "detect",
    "diagnose",
    "distort",
    "load",
    "load_cameras",
    "load_target",
    "pixel_to_ray",
    "plot_monitor",
    "project",
    "save_cameras",
    "save_target",
    "solve_pose",
    "solve_poses",
    "solve_tag",
    "solve_tags",
    "undistort",
]
