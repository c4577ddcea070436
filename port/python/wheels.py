#!/usr/bin/env python3
"""Builds the wheels of all platforms on one machine, with the compiler of PyPI's ziglang.

    python3 port/python/wheels.py FOLDER [PLATFORM...]

It makes an environment, build/venv-wheels, with ziglang, build, wheel, scikit-build-core,
cmake and zopfli. Each wheel is made from one sdist. Those of this machine's kind are
installed in a new virtual environment, where a pose is solved; all others are only built:
"untried". Prints a Markdown table of README.md; fails if a wheel is larger than 400 KB,
but for those of LARGER.
"""

from __future__ import annotations

import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
VENV = HERE.parents[1] / "build/venv-wheels"
PACKAGES = ("ziglang", "build", "wheel", "scikit-build-core", "cmake", "zopfli")
# For each platform of a wheel: the target of zig, and the system and processor of CMake.
TARGETS = {
    "manylinux2014_x86_64": ("x86_64-linux-gnu.2.17", "Linux", "x86_64"),
    "manylinux2014_aarch64": ("aarch64-linux-gnu.2.17", "Linux", "aarch64"),
    "musllinux_1_1_x86_64": ("x86_64-linux-musl", "Linux", "x86_64"),
    "musllinux_1_1_aarch64": ("aarch64-linux-musl", "Linux", "aarch64"),
    "macosx_11_0_x86_64": ("x86_64-macos.11.0", "Darwin", "x86_64"),
    "macosx_11_0_arm64": ("aarch64-macos.11.0", "Darwin", "arm64"),
    "win_amd64": ("x86_64-windows-gnu", "Windows", "AMD64"),
    "win_arm64": ("aarch64-windows-gnu", "Windows", "ARM64"),
}
BYTES_MAX = 400 * 1024
# Functions must keep ten more registers by its calling convention, so the code is larger.
LARGER = ("win_amd64",)
# pip uses the last of these names that it knows.
OLD_NAMES = {
    "manylinux2014_x86_64": "manylinux2014_x86_64.manylinux_2_17_x86_64",
    "manylinux2014_aarch64": "manylinux2014_aarch64.manylinux_2_17_aarch64",
}
TRY = """
import numpy as np, rigcal, subprocess
from rigcal._library import program
camera = rigcal.Camera(800, 800, 320, 240, size=(640, 480))
X = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, .5], [.3, .6, 1]])
uv = rigcal.project(camera, X + [0, 0, 4]).uv
assert np.allclose(rigcal.solve_pose(camera, X, uv).cam_from_world.t, [0, 0, 4])
said = subprocess.run([program(), "--version"], capture_output=True, text=True)
print(said.stdout.strip())
"""


def run(*command: str | pathlib.Path, **env: str) -> str:
    done = subprocess.run(
        [str(part) for part in command],
        env={**os.environ, **env},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}")
    return done.stdout


def enter_environment() -> None:
    """Runs this script again by the environment's Python, which it makes first."""
    python = VENV / "bin/python"
    if pathlib.Path(sys.prefix) == VENV:
        return
    if not python.exists():
        run(sys.executable, "-m", "venv", VENV)
    run(python, "-m", "pip", "install", "-q", *PACKAGES)
    os.execv(python, [str(python), *sys.argv])


def compiler(folder: pathlib.Path, target: str) -> pathlib.Path:
    """A program that CMake accepts as a C compiler, without the sanitizer that zig adds."""
    path = folder / "zig-cc"
    path.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -m ziglang cc -target {target} '
        '-fno-sanitize=undefined "$@"\n'
    )
    path.chmod(0o755)
    return path


def archiver(folder: pathlib.Path, tool: str) -> pathlib.Path:
    path = folder / tool
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m ziglang {tool} "$@"\n')
    path.chmod(0o755)
    return path


class Squeezed:
    """A compressor for zipfile by zopfli: 4 % smaller than zlib at its best."""

    def __init__(self) -> None:
        self.data = bytearray()

    def compress(self, data: bytes) -> bytes:
        self.data += data
        return b""

    def flush(self) -> bytes:
        import zopfli.zlib

        head, check = 2, 4  # bytes of zlib around the deflated ones
        return bytes(zopfli.zlib.compress(bytes(self.data))[head:-check])


def squeeze(wheel: pathlib.Path) -> None:
    """Packs the same files again, in fewer bytes."""
    with zipfile.ZipFile(wheel) as packed:
        files = [(info, packed.read(info)) for info in packed.infolist()]
    plain = zipfile._get_compressor  # type: ignore[attr-defined]
    zipfile._get_compressor = lambda *_: Squeezed()  # type: ignore[attr-defined]
    try:
        with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as packed:
            for info, data in files:
                packed.writestr(info, data, zipfile.ZIP_DEFLATED)
    finally:
        zipfile._get_compressor = plain  # type: ignore[attr-defined]
    with zipfile.ZipFile(wheel) as packed:
        if [(info.filename, packed.read(info)) for info in packed.infolist()] != [
            (info.filename, data) for info, data in files
        ]:
            sys.exit(f"{wheel.name}: not the same files after squeezing")


def build(sdist: pathlib.Path, out: pathlib.Path, name: str) -> pathlib.Path:
    target, system, processor = TARGETS[name]
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work)
        defined = {
            "CMAKE_SYSTEM_NAME": system,
            "CMAKE_SYSTEM_PROCESSOR": processor,
            "CMAKE_C_COMPILER": compiler(folder, target),
            "CMAKE_AR": archiver(folder, "ar"),
            "CMAKE_RANLIB": archiver(folder, "ranlib"),
            "CMAKE_SHARED_LINKER_FLAGS": "-s",
            "CMAKE_EXE_LINKER_FLAGS": "-s",
        }
        run(
            sys.executable, "-m", "pip", "wheel", "-q", "--no-build-isolation", "--no-deps",
            "--config-settings=install.strip=false", "-w", folder, sdist,
            CMAKE_ARGS=" ".join(f"-D{key}={value}" for key, value in defined.items()),
        )  # fmt: skip
        (made,) = folder.glob("*.whl")
        tags = run(
            sys.executable, "-m", "wheel", "tags", "--remove",
            "--platform-tag", OLD_NAMES.get(name, name), made,
        )  # fmt: skip
        wheel = folder / tags.strip().splitlines()[-1]
        squeeze(wheel)
        return wheel.replace(out / wheel.name)


def is_tried(name: str, wheel: pathlib.Path) -> str:
    """What the wheel prints in a new virtual environment, if it can run."""
    libc = (
        "musl" if "musl" in platform.libc_ver()[0] or not platform.libc_ver()[0] else "many"
    )
    here = {"Linux": f"{libc}linux", "Darwin": "macosx", "Windows": "win"}
    system = here.get(platform.system(), "?")
    if not (name.startswith(system) and name.endswith(platform.machine().lower())):
        return "untried"
    with tempfile.TemporaryDirectory() as work:
        run(sys.executable, "-m", "venv", work)
        run(f"{work}/bin/pip", "install", "-q", wheel)
        return run(f"{work}/bin/python", "-I", "-c", TRY).strip()


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    out = pathlib.Path(sys.argv[1]).resolve()
    out.mkdir(parents=True, exist_ok=True)
    run(sys.executable, "-m", "build", "--no-isolation", "--sdist", "-o", out, HERE)
    sdist = max(out.glob("rigcal-*.tar.gz"), key=lambda path: path.stat().st_mtime)
    large = []
    print("| wheel | bytes | tried |\n| --- | ---: | --- |")
    for name in sys.argv[2:] or TARGETS:
        wheel = build(sdist, out, name)
        size = wheel.stat().st_size
        if size > BYTES_MAX and name not in LARGER:
            large.append(wheel.name)
        above = ", above the limit" if size > BYTES_MAX else ""
        print(f"| {name} | {size}{above} | {is_tried(name, wheel)} |", flush=True)
    if large:
        sys.exit(f"more than {BYTES_MAX} bytes: {', '.join(large)}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        enter_environment()
    main()
