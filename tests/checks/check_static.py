#!/usr/bin/env python3
"""What the static analysers find in src/ and the command line, beside deviations.txt.

    check_static.py            gcc -fanalyzer (double and float), clang --analyze, cppcheck's
                               MISRA addon; fails where a finding is not in deviations.txt,
                               or where a deviation is found no more
    check_static.py short      gcc -fanalyzer in double alone: what CI has time for
    check_static.py --list     prints every finding as a line of deviations.txt

A deviation is `TOOL FINDING FILE: LINE OF SOURCE => REASON`. Of the MISRA C:2012 rules a
deviation is `misra RULE => REASON`, for all of src/. clang-tidy and cppcheck's own checks have
steps of their own and no deviations file.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEVIATIONS = ROOT / "tests/checks/deviations.txt"
FLAGS = ["-std=c99", "-D_POSIX_C_SOURCE=200809L", "-DRIGCAL_BUILD", "-Iinclude", "-Isrc", "-Iexamples"]
CHECKERS = "core,deadcode,security,unix,nullability,optin.portability"
FOUND = re.compile(r"^([\w./]+):(\d+):(?:\d+:)? warning: .*\[([\w.-]+)\]$", re.MULTILINE)
MISRA = re.compile(r"misra-c2012-(\d+\.\d+)")

Finding = collections.namedtuple("Finding", "key where")


def run(command: list[str]) -> str:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"check_static: {' '.join(command)}: exit status {done.returncode}\n{done.stderr[-2000:]}")
    return done.stdout + done.stderr


def of_compiler(tool: str, command: list[str]) -> list[Finding]:
    found = []
    for path, line, what in FOUND.findall(run(command)):
        text = (ROOT / path).read_text().splitlines()[int(line) - 1].strip()
        found.append(Finding(f"{tool} {what} {path}: {text}", f"{path}:{line}"))
    return found


def of_misra(path: str) -> list[Finding]:
    work = ROOT / "build/static" / pathlib.Path(path).stem  # otherwise it writes its dumps
                                                            # beside the sources
    work.mkdir(parents=True, exist_ok=True)
    text = run(["cppcheck", f"--cppcheck-build-dir={work}", "--quiet", "--std=c99", "--language=c",
                "--addon=misra", "--suppress=missingIncludeSystem", "--template={file}:{line}: {id}",
                "-Iinclude", "-Isrc", "-DRIGCAL_BUILD", "-D__GNUC__", "-URIGCAL_USE_FLOAT",
                "-URIGCAL_CONFIG_FILE", "-U_WIN32", "-URIGCAL_SHARED", path])
    return [Finding(f"misra {rule}", line.rpartition(": ")[0])
            for line in text.splitlines() for rule in MISRA.findall(line)]


def tasks(short: bool) -> list[tuple]:
    sources = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "src").glob("*.c"))
    programs = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "examples").glob("*.c"))
    gcc = ["gcc", *FLAGS, "-O1", "-fanalyzer", "-fdiagnostics-plain-output", "-c", "-o", os.devnull]
    clang = ["clang-19", *FLAGS, "--analyze", "-Xclang", "-analyzer-output=text", "-Xclang",
             f"-analyzer-checker={CHECKERS}"]
    if short:
        return [(of_compiler, "gcc", [*gcc, path]) for path in sources + programs]
    todo = [(of_misra, path) for path in sources]
    for path in sources + programs:
        todo.append((of_compiler, "gcc", [*gcc, path]))
        todo.append((of_compiler, "clang", [*clang, path]))
    return todo + [(of_compiler, "gcc", [*gcc, "-DRIGCAL_USE_FLOAT=1", path]) for path in sources]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("form", nargs="?", choices=["full", "short"], default="full")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    short = options.form == "short"
    jobs = int(os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", os.cpu_count() or 1))
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        found = [f for part in pool.map(lambda task: task[0](*task[1:]), tasks(short)) for f in part]
    keys = sorted({f.key for f in found})
    if options.list:
        print("\n".join(keys))
        return 0
    reasons = {}
    wrong = []
    for line in DEVIATIONS.read_text().splitlines():
        if line and not line.startswith("#"):
            key, _, reason = line.partition(" => ")
            reasons[key] = reason
            if not reason:
                wrong.append(f"deviations.txt: no reason: {line}")
    wrong += sorted({f"{f.where}: {f.key}" for f in found if f.key not in reasons})
    wrong += [f"deviations.txt: is found no more: {key}" for key in reasons if not short and key not in keys]
    print("\n".join(wrong) or f"static: {len(keys)} kinds of findings, each with its reason in deviations.txt")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
