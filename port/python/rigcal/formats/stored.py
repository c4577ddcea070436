"""The stored bytes of the library, rig.bin: rigcal_store_save and rigcal_store_load.

Their form is the library's alone, so the compiled library reads and writes them. What
binds it sets these two functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Callable

from ..camera import Camera
from ..errors import Error
from ._common import Document, Files, Options, each

MAGIC = b"RIGC"

# Bytes to cameras, and back. Names are not stored: cameras come as "cam0", "cam1", ...
load_bytes: Callable[[bytes], Sequence[Camera]] | None = None
save_bytes: Callable[[Sequence[Camera]], bytes] | None = None

MISSING = "stored bytes need the compiled library, which is not here"


def _read(document: Document, options: Options) -> Sequence[Camera]:
    if load_bytes is None:
        raise Error(MISSING)
    return load_bytes(document.data)


read = each(_read)


def write(cameras: Sequence[Camera], options: Options) -> Files:
    if save_bytes is None:
        raise Error(MISSING)
    return {"": save_bytes(cameras)}
