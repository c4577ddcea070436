"""Builds the package: scikit-build-core, and what it does not do.

The C sources lie two folders up in a checkout and in c/ of an sdist, which is made to
build alone. The version is that of include/rigcal.h.
"""

from __future__ import annotations

import contextlib
import pathlib
import re
import shutil
from collections.abc import Iterator
from typing import Any

from scikit_build_core import build as _build
from scikit_build_core.build import *  # noqa: F403

HERE = pathlib.Path(__file__).resolve().parent
OWN = HERE / "c"  # of an sdist
CHECKOUT = HERE.parents[1]
# What the build takes from the checkout.
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
    """What scikit-build-core asks for the version."""
    if field != "version" or settings:
        raise RuntimeError(f"there is no {field} here")
    return version()


@contextlib.contextmanager
def copied_sources() -> Iterator[None]:
    """c/ with all that the build takes, as long as an sdist is made."""
    if sources() == OWN:
        yield
        return
    try:
        for pattern in TAKEN:
            for path in CHECKOUT.glob(pattern):
                target = OWN / path.relative_to(CHECKOUT)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
        yield
    finally:
        shutil.rmtree(OWN, ignore_errors=True)


def build_sdist(sdist_directory: str, config_settings: Any = None) -> str:
    with copied_sources():
        return str(_build.build_sdist(sdist_directory, config_settings))
