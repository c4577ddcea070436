"""Builds the package: scikit-build-core, and what it does not do.

The C sources are two folders up in a checkout, and in c/ of an sdist, which must build
without the checkout. The version is that of include/rigcal.h.
"""

from __future__ import annotations

import contextlib
import os
import pathlib
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from typing import Any

from scikit_build_core import build as _build
from scikit_build_core.build import *  # noqa: F403

HERE = pathlib.Path(__file__).resolve().parent
OWN = HERE / "c"  # of an sdist
CHECKOUT = HERE.parents[1]
# Files that the build takes from the checkout.
TAKEN = ("LICENSE", "CMakeLists.txt", "include/*.h", "src/*.[ch]", "examples/cli*.[ch]",
         "examples/rigcal_cli.c")  # fmt: skip


def sources() -> pathlib.Path:
    return OWN if (OWN / "include/rigcal.h").is_file() else CHECKOUT


def version() -> str:
    text = (sources() / "include/rigcal.h").read_text(encoding="utf-8")
    return ".".join(
        re.findall(r"^#define RIGCAL_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", text, re.M)
    )


def dynamic_metadata(field: str, settings: dict[str, Any]) -> str:
    """Answers scikit-build-core's question for the version."""
    if field != "version" or settings:
        raise RuntimeError(f"there is no {field} here")
    return version()


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Builds in a copy of this folder, with all C sources in c/, as in an sdist."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as work:
        copy = pathlib.Path(work) / HERE.name
        shutil.copytree(HERE, copy, ignore=shutil.ignore_patterns("c", "__pycache__", ".*"))
        for pattern in TAKEN:
            for path in sources().glob(pattern):
                target = copy / OWN.name / path.relative_to(sources())
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
        os.chdir(copy)
        try:
            yield
        finally:
            os.chdir(before)


def pack(wheel: pathlib.Path) -> None:
    """Compresses a wheel as far as its format goes: some 1400 bytes less."""
    with zipfile.ZipFile(wheel) as loose:
        files = [(item, loose.read(item)) for item in loose.infolist()]
    with zipfile.ZipFile(wheel, "w") as tight:
        for item, data in files:
            tight.writestr(item, data, zipfile.ZIP_DEFLATED, 9)


def build_wheel(
    wheel_directory: str, config_settings: Any = None, metadata_directory: Any = None
) -> str:
    name = str(_build.build_wheel(wheel_directory, config_settings, metadata_directory))
    pack(pathlib.Path(wheel_directory) / name)
    return name


def build_sdist(sdist_directory: str, config_settings: Any = None) -> str:
    folder = os.path.abspath(sdist_directory)
    with alone():
        return str(_build.build_sdist(folder, config_settings))
