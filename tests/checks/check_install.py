#!/usr/bin/env python3
"""Runs the commands of README.md's section "Install it on a PC" as they are printed.

The first ```sh block runs in a copy of the project; those after it run in a folder with
README.md's C program as app.c and the section's ```cmake block as CMakeLists.txt. The
program must print what README.md prints. What would be installed under / goes into a
folder (DESTDIR); sudo and apt-get are stand-ins, and so is every program that fetches
from a network, which must not be called.
"""
import os
import pathlib
import re
import shutil
import sys
import tempfile

import check_readme

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECTION = "### Install it on a PC"
STAND_INS = {
    "sudo": 'exec "$@"',
    "apt-get": 'echo "apt-get $*" >>"$CALLS"',
}
STAND_INS |= {name: f'echo "{name} $*" >>"$CALLS"; exit 1'
              for name in ("git", "curl", "wget", "apt", "pip", "pip3")}
# What the commands of the first block must do, besides apt-get.
COMMANDS = [r"cmake -S \. -B (\S+)", r"cmake --build (\S+)", r"sudo cmake --install (\S+)"]


def blocks(text):
    return [(m[1], m[2]) for m in check_readme.BLOCK.finditer(text)]


def main():
    readme = (ROOT / "README.md").read_text()
    if readme.count(SECTION) != 1:
        sys.exit(f"README.md: there is no section {SECTION}, or more than one")
    section = readme.split(SECTION)[1]
    section = re.split(r"^##", section, flags=re.M)[0]
    told = blocks(readme)
    at = next(k for k, (language, code) in enumerate(told)
              if language == "c" and re.search(r"\bmain\s*\(", code))
    program, expected = told[at][1], told[at + 1][1]
    commands = [code for language, code in blocks(section) if language == "sh"]
    cmake, = [code for language, code in blocks(section) if language == "cmake"]

    lines = commands[0].splitlines()
    install = [re.fullmatch(pattern, line) for pattern, line in zip(COMMANDS, lines[1:])]
    if len(lines) != 4 or not all(install) or len({m[1] for m in install}) != 1:
        sys.exit(f"README.md: the installation is not three commands after apt-get's:\n{commands[0]}")
    if len(commands) != 3:
        sys.exit(f"README.md: {len(commands)} sh blocks in {SECTION}, not 3")

    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        project, app, bin_ = work / "rigcal", work / "app", work / "bin"
        shutil.copytree(ROOT, project, symlinks=True, ignore=shutil.ignore_patterns(
            "build", ".git", "__pycache__"))
        app.mkdir()
        bin_.mkdir()
        (app / "app.c").write_text(program)
        (app / "CMakeLists.txt").write_text(cmake)
        for name, script in STAND_INS.items():
            (bin_ / name).write_text(f"#!/bin/sh\n{script}\n")
            (bin_ / name).chmod(0o755)
        calls = work / "calls.txt"
        root = work / "root"
        os.environ.update(
            PATH=f"{bin_}:{os.environ['PATH']}", CALLS=str(calls), DESTDIR=str(root),
            HOME=str(work), XDG_CACHE_HOME=str(work),
            CMAKE_PREFIX_PATH=str(root / "usr/local"),
            PKG_CONFIG_PATH=str(root / "usr/local/lib/pkgconfig"))

        def sh(text, folder):
            done = check_readme.run("sh", "-eu", "-c", f"cd '{folder}'\n{text}")
            if done.returncode:
                sys.exit(f"README.md: these commands fail:\n{text}\n{done.stdout}")
            return done.stdout

        sh(commands[0], project)
        if calls.read_text().splitlines() != [lines[0].replace("sudo ", "")]:
            sys.exit(f"README.md: the installation calls\n{calls.read_text()}")
        for text in commands[1:]:
            printed = sh(text, app)
            if expected not in printed:
                sys.exit(f"README.md: these commands:\n{text}\nprint\n{printed}\nnot\n{expected}")
        said = sh(f"'{root}/usr/local/bin/rigcal' --version", work)
        if not said.startswith("rigcal "):
            sys.exit(f"README.md: the command line says {said}")
    print("README.md's installation, its program by find_package and by pkg-config")


if __name__ == "__main__":
    main()
