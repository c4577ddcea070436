"""The library must be the one that this package was written for."""

from __future__ import annotations

import ctypes
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

import rigcal
from rigcal import _layout, _library, _names

HEADERS = {p.name: p.read_text() for p in sorted((ROOT / "include").glob("*.h"))}
BATCH = (ROOT / "port/python/batch.h").read_text()


def test_version_is_the_headers():
    parts = re.findall(r"define RIGCAL_VERSION_\w+ (\d+)", HEADERS["rigcal.h"])
    assert rigcal.__version__ == ".".join(parts)


def test_names_are_made_from_the_headers():
    made = subprocess.run(
        [sys.executable, ROOT / "port/python/make_names.py", "--check"], capture_output=True
    )
    assert made.returncode == 0, made.stderr


def test_the_library_knows_the_same_statuses():
    library = ctypes.CDLL(
        str(_library.FOLDER / _library.FILES.get(sys.platform, "librigcal.so"))
    )
    library.rigcal_status_name.restype = library.rigcal_status_text.restype = (
        ctypes.c_char_p
    )
    known = {
        number: (library.rigcal_status_name(number), library.rigcal_status_text(number))
        for number in range(-60, 60)
    }
    known = {n: v for n, v in known.items() if v[0].startswith(b"RIGCAL_")}
    assert {s.value: (s.name.encode(), s.text.encode()) for s in rigcal.Status} == known


def test_an_enum_has_the_headers_members():
    members = re.search(
        r"enum rigcal_fault_kinds \{(.*?)\}", HEADERS["rigcal_faults.h"], re.S
    )
    names = re.findall(r"^\s+(RIGCAL_\w+)", members[1], re.M)
    assert [m.name for m in _names.FaultKinds] == names


def without_comments(text):
    return re.sub(r"/\*.*?\*/", "", text, flags=re.S)


def letter(argument):
    """The letter of _library.PROTOTYPES for a C argument."""
    if "*" in argument or "[" in argument:
        return "p"
    for kind, found in (
        ("size_t", "n"),
        ("uint32_t", "u"),
        ("int32_t", "i"),
        ("rigcal_status", "i"),
        ("rigcal_real", "d"),
        ("void", ""),
    ):
        if argument.startswith(kind):
            return found
    return "?"


def test_prototypes_are_the_headers():
    text = without_comments("\n".join(HEADERS.values()) + BATCH)
    declared = {
        name: (letter(result), "".join(letter(a.strip()) for a in arguments.split(",")))
        for result, name, arguments in re.findall(
            r"RIGCAL_API (\w+)\s+rigcal_(\w+)\(([^)]*)\);", text
        )
    }
    for name, prototype in _library.PROTOTYPES.items():
        assert prototype == declared[name], name
    batches = {name for name in declared if name.startswith("batch_")}
    assert batches - {"batch_layout", "batch_layout_count"} <= set(_library.PROTOTYPES)


def test_every_function_of_batch_h_has_at_most_8_arguments():
    for arguments in re.findall(r"RIGCAL_API[^(]*\(([^)]*)\);", without_comments(BATCH)):
        assert len(arguments.split(",")) <= 8


def test_a_struct_that_is_not_the_librarys_is_refused():
    wrong = dict(_layout.STRUCTS)
    fields = [(name, "f4" if name == "fx" else "f8") for name in _layout.CAMERA.names]
    wrong["rigcal_camera"] = np.dtype(fields)
    with pytest.raises(ImportError, match=r"rigcal_camera.*_layout.py"):
        _layout.check_layout(_library.lib, wrong)
    missing = dict(_layout.STRUCTS)
    missing["rigcal_span"] = np.dtype([("row", "i4"), ("first", "i4")])
    with pytest.raises(ImportError, match=r"rigcal_span"):
        _layout.check_layout(_library.lib, missing)


def test_a_library_that_is_missing_is_named(tmp_path):
    with pytest.raises(ImportError, match=r"gone.so is not there"):
        _library.load(tmp_path / "gone.so")


def test_a_library_in_float_is_refused(monkeypatch):
    monkeypatch.setattr(_library, "REAL_BYTES", 4)
    with pytest.raises(ImportError, match="float"):
        _library.load(_library.FOLDER / _library.FILES.get(sys.platform, "librigcal.so"))


def test_the_program_runs():
    said = subprocess.run([_library.program(), "--version"], capture_output=True, text=True)
    assert said.returncode == 0
    assert rigcal.__version__ in said.stdout


def test_a_program_that_is_missing_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(_library, "FOLDER", tmp_path)
    with pytest.raises(rigcal.Error, match="is not there"):
        _library.program()


def test_everything_exported_is_there():
    assert all(hasattr(rigcal, name) for name in rigcal.__all__)
    assert len(set(_layout.STRUCTS)) >= 30
