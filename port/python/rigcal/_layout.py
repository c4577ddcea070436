"""The C structs as NumPy types, compared with the library's own layout.

The order of fields is that of the headers, which describe them. Pointers and size_t are
unsigned integers of a pointer's size.
"""

from __future__ import annotations

import ctypes
from typing import Any, Union

import numpy as np

__all__ = [
    "BAND",
    "BAND_POINT",
    "BLAME",
    "BODY_REPORT",
    "CALIBRATED_RIG",
    "CAMERA",
    "DIAGNOSIS",
    "INTRINSICS_SIGMA",
    "MATCH",
    "MATCH_PAIR",
    "MEASURED_POINT",
    "MONITOR_OPTIONS",
    "MONITOR_REPORT",
    "MOUNTED_CAMERA",
    "OBSERVATION",
    "POINT_GAIN",
    "POSE",
    "POSE_OPTIONS",
    "RAY",
    "RESULT",
    "ROBUST_OPTIONS",
    "SAVED_INFO",
    "SIGHTINGS",
    "SOLVED",
    "SPAN",
    "TRANSFER",
    "TRANSFORM",
    "UNCERTAINTY",
    "VIEW",
    "VIEWS",
    "check_layout",
]

Kind = Union[str, "np.dtype[Any]", tuple[str, int]]

I4, U4, REAL, ADDRESS = "i4", "u4", "f8", "P"
STRUCTS: dict[str, np.dtype[Any]] = {}


def reals(names: str) -> list[tuple[str, Kind]]:
    return [(name, REAL) for name in names.split()]


def integers(names: str) -> list[tuple[str, Kind]]:
    return [(name, I4) for name in names.split()]


def struct(name: str, *fields: tuple[str, Kind] | list[tuple[str, Kind]]) -> np.dtype[Any]:
    """The type of struct rigcal_`name`; a field is (name, type) or (name, (type, n))."""
    flat: list[Any] = []
    for field in fields:
        for key, kind in field if isinstance(field, list) else [field]:
            flat.append((key, *kind) if isinstance(kind, tuple) else (key, kind))
    STRUCTS[f"rigcal_{name}"] = dtype = np.dtype(flat, align=True)
    return dtype


ENTRY = struct("layout_entry", ("name", "S48"), integers("offset size"))

# rigcal.h
TRANSFORM = struct("transform", ("R", (REAL, 9)), ("t", (REAL, 3)))
CAMERA = struct(
    "camera",
    integers("lens width height"),
    reals("fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
)
OBSERVATION = struct("observation", ("X_w", (REAL, 3)), ("uv", (REAL, 2)))
VIEW = struct(
    "view",
    ("camera", ADDRESS),
    ("observations", ADDRESS),
    ("sigma", ADDRESS),
    ("n", ADDRESS),
)
POSE = struct("pose", ("cam_from_world", TRANSFORM), reals("sse rms_px probability"))
POSE_OPTIONS = struct("pose_options", ("use_start", I4), ("sigma_px", REAL),
                      ("start", TRANSFORM))  # fmt: skip
UNCERTAINTY = struct(
    "pose_uncertainty",
    ("Sigma", (REAL, 36)),
    ("rotation", (REAL, 3)),
    ("translation", (REAL, 3)),
    ("center", (REAL, 3)),
    ("sigma_px", REAL),
)
ROBUST_OPTIONS = struct(
    "robust_options",
    reals("threshold_px sigma_px"),
    ("samples", I4),
    ("seed", U4),
    ("max_units", I4),
)
BLAME = struct(
    "blame",
    integers("verdict point is_rest_poor"),
    reals("rms_px rms_without_px chance probability"),
)
DIAGNOSIS = struct(
    "diagnosis",
    integers("verdict is_handed"),
    reals("rms_mirrored_px rms_flipped_px units"),
    ("blame", BLAME),
)
MOUNTED_CAMERA = struct(
    "mounted_camera",
    ("camera", CAMERA),
    ("cam_from_rig", TRANSFORM),
    ("Sigma", (REAL, 36)),
    ("has_Sigma", I4),
)
SAVED_INFO = struct(
    "saved_info",
    ("sequence", U4),
    ("tag", U4),
    integers("n_cameras n_free n_bytes real_bytes"),
)

# rigcal_rig.h
INTRINSICS_SIGMA = struct("intrinsics_sigma", reals("focal aspect centre k1 k2"))
CALIBRATED_RIG = struct(
    "calibrated_rig",
    ("cameras", ADDRESS),
    ("group", ADDRESS),
    ("held", ADDRESS),
    ("capacity", ADDRESS),
    ("Sigma", ADDRESS),
    ("Sigma_capacity", ADDRESS),
    ("n_cameras", ADDRESS),
    reals("sigma_px F freedom_between freedom_within"),
)

# rigcal_point.h
SIGHTING = struct("sighting", ("camera", I4), ("uv", (REAL, 2)))
SIGHTINGS = struct(
    "sightings",
    ("rig", ADDRESS),
    ("seen", ADDRESS),
    ("n", ADDRESS),
    ("sigma_px", ADDRESS),
    ("parallax_least", REAL),
    ("keep_all", I4),
    ("work", ADDRESS),
    ("work_capacity", ADDRESS),
)
POINT_GAIN = struct("point_gain", ("camera", I4), ("gain", (REAL, 18)))
MEASURED_POINT = struct(
    "measured_point",
    ("X", (REAL, 3)),
    ("Sigma", (REAL, 9)),
    ("Sigma_noise", (REAL, 9)),
    reals("chi2 freedom parallax rms_px"),
    ("n_used", ADDRESS),
    ("gains", ADDRESS),
    ("gains_capacity", ADDRESS),
)

# rigcal_match.h
RAY = struct("ray", ("m", (REAL, 3)), ("D", (REAL, 6)))
MATCH_PAIR = struct(
    "match_pair",
    ("camera_a", ADDRESS),
    ("camera_b", ADDRESS),
    ("b_from_a", TRANSFORM),
    ("Sigma", (REAL, 36)),
    reals("sigma_a sigma_b k near_a far_a"),
)
BAND = struct(
    "band",
    ("camera_b", CAMERA),
    ("ray", (REAL, 3)),
    ("towards", (REAL, 3)),
    reals("along across"),
    ("line", (REAL, 3)),
    ("Sigma_line", (REAL, 6)),
    reals("epipole2 sigma_b k near_a far_a"),
)
BAND_POINT = struct(
    "band_point", ("uv", (REAL, 2)), ("across", (REAL, 2)), reals("half_width depth_a")
)
MATCH = struct(
    "match",
    integers("index is_inside"),
    reals("chi2 distance_px half_width_px score depth_a"),
)
SPAN = struct("span", integers("row first last"))
TRANSFER = struct(
    "transfer",
    ("uv", (REAL, 2)),
    ("Sigma", (REAL, 4)),
    ("X", (REAL, 3)),
    ("Sigma_X", (REAL, 9)),
    ("chi2", REAL),
)

# rigcal_monitor.h
MONITOR_OPTIONS = struct(
    "monitor_options",
    reals("arl0_frames common wrong walk_rad walk_t move_rad move_t"),
)
MONITOR_REPORT = struct(
    "monitor_report",
    integers("alarm body"),
    reals("confidence evidence noise smallest_rad"),
    ("n_blind", I4),
    ("frames", U4),
    ("rows", U4),
    ("doubted", U4),
    ("frames_since", U4),
)
BODY_REPORT = struct(
    "body_report",
    ("is_blind", I4),
    reals("share blame smallest_rad"),
    ("weakest", (REAL, 6)),
    ("weakest_sigma", REAL),
)

# batch.h
VIEWS = struct(
    "batch_views",
    ("cameras", ADDRESS),
    ("camera_of", ADDRESS),
    ("X", ADDRESS),
    ("uv", ADDRESS),
    ("sigma", ADDRESS),
    ("first", ADDRESS),
    ("is_one_target", I4),
)
RESULT = struct("batch_result", integers("status covariance at_fault n_found n_inliers"))
SOLVED = struct(
    "batch_solved",
    ("poses", ADDRESS),
    ("most", ADDRESS),
    ("results", ADDRESS),
    ("uncertainties", ADDRESS),
    ("inliers", ADDRESS),
)


def declared(structs: dict[str, np.dtype[Any]]) -> dict[str, tuple[int, int]]:
    """(offset, size) of each struct and "struct.field"."""
    found = {}
    for name, dtype in structs.items():
        found[name] = (0, dtype.itemsize)
        for field, (kind, offset, *_) in (dtype.fields or {}).items():
            found[f"{name}.{field}"] = (offset, kind.itemsize)
    return found


def accounted(library: ctypes.CDLL) -> dict[str, tuple[int, int]]:
    """The same by the library's list."""
    found = {}
    entry = np.zeros(1, ENTRY)
    for account in ("rigcal_layout", "rigcal_batch_layout"):
        for index in range(getattr(library, f"{account}_count")()):
            line = getattr(library, account)
            line(ctypes.c_void_p(entry.ctypes.data), ctypes.c_int32(index))
            found[entry["name"][0].decode()] = (
                int(entry["offset"][0]),
                int(entry["size"][0]),
            )
    return found


def check_layout(
    library: ctypes.CDLL, structs: dict[str, np.dtype[Any]] = STRUCTS
) -> dict[str, int]:
    """Sizes of all of the library's structs, solvers too; ImportError names the first
    field that is not the library's."""
    here, there = declared(structs), accounted(library)
    known = {name: at for name, at in there.items() if name.split(".")[0] in structs}
    for name in sorted(here.keys() | known.keys()):
        if here.get(name) != known.get(name):
            raise ImportError(
                f"{name}: (offset, size) is {here.get(name)} in rigcal/_layout.py and "
                f"{known.get(name)} in the library"
            )
    return {name: size for name, (_, size) in there.items() if "." not in name}
