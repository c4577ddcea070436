#!/usr/bin/env python3
"""The tables of BENCHMARKS.md, and of READMEs of port/: each is what one command prints.

    tables.py               runs every command and writes its table: hours
    tables.py NAME...       only these
    tables.py --list        the names, and their commands
    tables.py --short       runs the short form of each, and writes tests/bench/short.md
    tables.py --check       for CI: runs the short forms and compares them with short.md

A table stands in its document between two comments:

    <!-- table NAME: COMMAND; short: COMMAND; within 2 % -->
    <!-- end -->

`table 2 of NAME: COMMAND` takes the second table that the command prints. `short` is the
form of CI, with fewer scenes; `within` is how far a figure of it may be from that in
short.md. A table without `short` is made by hand only. A command is a bench of the preset
gcc-double, or PRESET/BENCH, or "sh FILE ..." or "python3 FILE ...", from the root of the project.
Below a table stands what made it: command, commit, day, compiler and processor. In the end
quoted.py writes the figures of README.md that are taken from the tables.

Exit status 1: a figure differs, or a command failed; the table stays as it was.
"""
import argparse
import datetime
import pathlib
import platform
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / "BENCHMARKS.md", ROOT / "port/cmsis_dsp/README.md", ROOT / "port/python/README.md"]
SHORT = ROOT / "tests/bench/short.md"

MARK = re.compile(
    r"<!-- table (?:(?P<number>\d+) of )?(?P<name>[\w-]+): (?P<command>[^;>]+?)"
    r"(?:; short: (?P<short>[^;>]+?); within (?P<within>[\d.]+) %)? -->\n"
    r"(?P<body>.*?)<!-- end -->", re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Failed(Exception):
    pass


def output_of(command: str, printed: dict[str, str]) -> str:
    """What a command prints. A command that several tables share runs once."""
    if command not in printed:
        words = shlex.split(command)
        if words[0] in ("sh", "python3"):
            words[0] = sys.executable if words[0] == "python3" else "sh"
        else:
            preset, _, bench = words[0].rpartition("/")
            words[0] = str(ROOT / "build" / (preset or "gcc-double") / "tests" / bench)
            if not pathlib.Path(words[0]).exists():
                raise Failed(f"{command}: there is no {words[0]}: build the preset {preset or 'gcc-double'}")
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            raise Failed(f"{command}: exit status {done.returncode}\n{done.stdout[-500:]}{done.stderr[-500:]}")
        printed[command] = done.stdout
    return printed[command]


def table_of(command: str, number: int, printed: dict[str, str]) -> str:
    tables = re.findall(r"(?:^\|.*\n)+", output_of(command, printed) + "\n", re.MULTILINE)
    if number > len(tables):
        raise Failed(f"{command}: prints {len(tables)} tables, not {number}")
    return tables[number - 1]


def by_gcc(command: str) -> bool:
    """Not for emulated targets and other platforms, which have another compiler."""
    return "port/" not in command and "hooks.sh" not in command


def made_by(command: str) -> str:
    git = ["git", "-C", str(ROOT)]
    commit = subprocess.run([*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    changed = subprocess.run([*git, "status", "--porcelain", "--", "src", "include", "tests/bench",
                              ":!tests/bench/figures", ":!tests/bench/short.md"],  # which benches write
                             capture_output=True, text=True).stdout
    gcc = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True).stdout.strip()
    built = f"gcc {gcc} -O2 -ffp-contract=off, " if by_gcc(command) else ""
    models = re.findall(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return (f"`{command}`, {datetime.date.today()}, commit {commit}{' with changes' * bool(changed)}, "
            f"{built}{platform.machine()}, {models[0] if models else 'processor unknown'}")


def numbers_of(text: str) -> list[str]:
    return NUMBER.findall(text)


def differences(expected: str, found: str, part: float) -> list[str]:
    """The places where two tables differ by more than the given part of a figure, or more
    than a unit of its last digit."""
    if NUMBER.sub("#", expected) != NUMBER.sub("#", found):
        return ["its words or lines differ"]
    wrong = []
    for row, (old, new) in enumerate(zip(expected.splitlines(), found.splitlines())):
        for a, b in zip(numbers_of(old), numbers_of(new)):
            last = 10.0 ** -len(a.partition(".")[2].partition("e")[0])
            if part > 0 and abs(float(a) - float(b)) <= max(part * abs(float(a)), 1.001 * last):
                continue
            if a != b:
                wrong.append(f"line {row + 1}: {a} was expected, {b} came: {new}")
    return wrong


def marks_of(document: pathlib.Path) -> list[re.Match[str]]:
    return list(MARK.finditer(document.read_text()))


def mark_named(name: str) -> tuple[pathlib.Path, re.Match[str]]:
    return next((document, m) for document in DOCUMENTS for m in marks_of(document) if m["name"] == name)


def write(names: list[str]) -> int:
    printed: dict[str, str] = {}
    failed = 0
    for name in names:
        _, mark = mark_named(name)
        print(f"{name}: {mark['command']}", flush=True)
        try:
            table = table_of(mark["command"], int(mark["number"] or 1), printed)
        except Failed as failure:
            print(failure, file=sys.stderr)
            failed = 1
            continue
        document, mark = mark_named(name)  # the document may have been edited meanwhile
        text, (start, end) = mark.string, mark.span("body")
        document.write_text(f"{text[:start]}{table}\n*{made_by(mark['command'])}*\n{text[end:]}")
    subprocess.run([sys.executable, ROOT / "tests/bench/quoted.py"], check=True)
    return failed


def shortened(marks: list[re.Match[str]]) -> dict[str, str]:
    printed: dict[str, str] = {}
    return {m["name"]: table_of(m["short"], int(m["number"] or 1), printed) for m in marks if m["short"]}


def check(marks: list[re.Match[str]]) -> int:
    kept = dict(re.findall(r"^## ([\w-]+)\n\n.*?\n\n(.*?\n)(?=\n|\Z)", SHORT.read_text(), re.MULTILINE | re.DOTALL))
    wrong = []
    found = shortened(marks)
    for mark in marks:
        if mark["short"]:
            name, part = mark["name"], float(mark["within"]) / 100
            if name not in kept:
                wrong.append(f"{name}: short.md has no such table; write it by tables.py --short")
            else:
                wrong += [f"{name}: {what}" for what in differences(kept[name], found[name], part)]
    wrong += [f"{name}: short.md has a table that no document has" for name in kept.keys() - found.keys()]
    print("\n".join(wrong) or f"tables: {len(found)} short tables as kept, of {len(marks)} in all")
    return bool(wrong)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    one = parser.add_mutually_exclusive_group()
    for option in ("list", "short", "check"):
        one.add_argument(f"--{option}", action="store_true")
    options = parser.parse_args()
    marks = [mark for document in DOCUMENTS for mark in marks_of(document)]
    known = [mark["name"] for mark in marks]
    for name in options.names:
        if name not in known:
            parser.error(f"there is no table {name}; there are {', '.join(known)}")
    try:
        if options.list:
            for mark in marks:
                print(f"{mark['name']}: {mark['command']}")
        elif options.check:
            return check(marks)
        elif options.short:
            parts = [f"## {name}\n\n`{next(m['short'] for m in marks if m['name'] == name)}`\n\n{table}"
                     for name, table in shortened(marks).items()]
            SHORT.write_text("# Short forms of the tables of BENCHMARKS.md\n\nWritten by `python3 "
                             "tests/bench/tables.py --short`; CI makes them again.\n\n" + "\n".join(parts))
        else:
            return write(options.names or known)
    except Failed as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
