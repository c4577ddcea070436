"""The shared library: loaded, checked, its functions with their types.

Pointers are handed over as addresses of NumPy arrays; None is NULL. ctypes lets other
threads run during every call.
"""

from __future__ import annotations

import ctypes
import pathlib
import sys
from typing import Any

import numpy.typing as npt

from ._layout import check_layout
from ._names import Status
from .errors import Error

__all__ = ["address", "lib", "must", "program"]

FOLDER = pathlib.Path(__file__).resolve().parent / "_c"
FILES = {"win32": "librigcal.dll", "darwin": "librigcal.dylib"}
REAL_BYTES = 8


def program() -> pathlib.Path:
    """The C program `rigcal` of this package; README.md of the library describes it."""
    path = FOLDER / ("rigcal.exe" if sys.platform == "win32" else "rigcal")
    if not path.is_file():
        raise Error(f"{path} is not there: install the package again")
    return path


STATUS, COUNT, REAL = ctypes.c_int32, ctypes.c_size_t, ctypes.c_double
POINTER, INTEGER = ctypes.c_void_p, ctypes.c_uint32

# A letter an argument: p a pointer, n a size_t, d a real, i an int32_t, u a uint32_t.
LETTERS = {"p": POINTER, "n": COUNT, "d": REAL, "i": STATUS, "u": INTEGER}
PROTOTYPES = {
    # name: (result, arguments)
    "version": ("i", ""),
    "sizeof_real": ("i", ""),
    "pose_defaults": ("i", "p"),
    "robust_defaults": ("i", "p"),
    "pose_blame": ("i", "pppp"),
    "pose_diagnose": ("i", "pppp"),
    "camera_check": ("i", "p"),
    "match_k": ("i", "pdi"),
    "store_size": ("n", "n"),
    "store_save": ("i", "pnppnuu"),
    "store_info": ("i", "ppn"),
    "calibrated_size": ("n", "n"),
    "calibrated_pair": ("i", "pppnn"),
    "calibrated_covariance": ("i", "ppnn"),
    "store_rig_size": ("n", "nn"),
    "store_save_rig": ("i", "pnppuu"),
    "store_load_rig": ("i", "pppn"),
    "point_work": ("n", "n"),
    "point_distance": ("i", "ppppp"),
    "monitor_size": ("n", "nn"),
    "monitor_defaults": ("i", "p"),
    "monitor_begin": ("i", "pnpnp"),
    "monitor_view": ("i", "ppnnpnd"),
    "monitor_lifted": ("i", "pn"),
    "monitor_frame": ("i", "ppd"),
    "monitor_ask": ("i", "pp"),
    "monitor_body": ("i", "ppn"),
    "monitor_moved": ("i", "pn"),
    "monitor_dismiss": ("i", "p"),
    "monitor_pair": ("i", "pppnn"),
    "monitor_rig": ("i", "pp"),
    "batch_poses": ("n", "pppnp"),
    "batch_robust": ("n", "pppnp"),
    "batch_tags": ("n", "pppdnp"),
    "batch_project": ("n", "pppppn"),
    "batch_rays": ("n", "ppppn"),
    "batch_undistort": ("n", "ppppn"),
    "batch_distort": ("n", "ppppn"),
    "batch_turning_rays": ("n", "ppppn"),
    "batch_points": ("n", "ppppppn"),
    "batch_transfers": ("n", "pppppppn"),
    "batch_bands": ("n", "ppppn"),
    "batch_curves": ("n", "pnpppn"),
    "batch_tests": ("n", "pppipn"),
    "batch_searches": ("n", "pnpppnpn"),
    "batch_spans": ("n", "pnppppn"),
    "batch_matches": ("n", "ppnpnpdn"),
}


def load(path: pathlib.Path) -> Any:
    """The library as an object: lib.pose_defaults is rigcal_pose_defaults."""
    if not path.is_file():
        raise ImportError(
            f"{path} is not there: install the package (pip install ./port/python)"
        )
    library: Any = ctypes.CDLL(str(path))
    if library.rigcal_sizeof_real() != REAL_BYTES:
        raise ImportError(f"{path} is a build in float; this package is for double")
    library.sizes = check_layout(library)
    for name, (result, arguments) in PROTOTYPES.items():
        function = getattr(library, f"rigcal_{name}")
        function.restype = LETTERS[result]
        function.argtypes = [LETTERS[letter] for letter in arguments]
        setattr(library, name, function)
    return library


lib = load(FOLDER / FILES.get(sys.platform, "librigcal.so"))


def address(array: npt.NDArray[Any]) -> int:
    """Where the first element of an array is; the caller keeps the array."""
    return array.ctypes.data


def must(status: int, what: str, bad: int | None = None) -> Status:
    """The status, if there is an answer with it. Else raises Error, whose text begins with
    `what`."""
    got = Status(status)
    if got < 0 or got == Status.RIGCAL_DISCONNECTED:
        raise Error(f"{what}: {got.text}", got.name, bad)
    return got
