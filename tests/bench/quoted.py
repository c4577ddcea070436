#!/usr/bin/env python3
"""The figures that README.md quotes: written from the tables of BENCHMARKS.md and
port/qemu/README.md, which scripts wrote.

    quoted.py            writes the lines of README.md's blocks of figures
    quoted.py --check    fails if a line is not what the tables say; the step readme does so

A block stands between "<!-- figures from FILE -->" and "<!-- end of figures -->". Its head
is README.md's own.
"""
import pathlib
import re
import sys
from collections.abc import Iterator

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tests/bench"), str(ROOT / "port/qemu")]
import figures  # noqa: E402 -- after the path
import tables  # noqa: E402

README = ROOT / "README.md"
BLOCK = re.compile(r"(<!-- figures from (\S+) -->\n(?:\|.*\n){2})((?:\|.*\n)*)(<!-- end of figures -->)")

# Line, table, row; and the columns.
CORES = [("flash of a pose", "Flash with libraries", "solve_pose"),
         ("flash of pose, triangulation and matching line", "Flash with libraries",
          "solve_pose, triangulate, epiline_px"),
         ("flash of pose, rig and its join", "Flash with libraries", "solve_pose and rig with join"),
         ("stack of a pose, eight points and a lens", "Stack", "solve_pose_8_lens"),
         ("instructions of a pose, eight points and a lens", "Instructions", "solve_pose_8_lens")]
CORE_COLUMNS = ("cortex-m4f float -Os", "cortex-m4f float -Os small", "cortex-m0 float -Os", "cortex-m7 double -O2")

METHODS = ("rigcal", "ITERATIVE", "EPNP+LM", "SQPNP+LM", "IPPE+LM")
WRONG = [("general", 4), ("general", 8), ("planar", 4), ("planar", 8), ("tag", 4), ("near-planar", 8),
         ("quasi-linear", 8)]
COUNTED = {"tag": "tag, 4", "general, 8 points": "general, 8"}
BESIDE_POSELIB = [("tag", 4), ("planar", 4), ("planar", 8), ("general", 8)]


def cells_of(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(name: str) -> list[dict[str, str]]:
    """The lines of a table of BENCHMARKS.md, as dictionaries by column."""
    _, mark = tables.mark_named(name)
    lines = [cells_of(line) for line in mark["body"].splitlines() if line.startswith("|")]
    return [dict(zip(lines[0], line)) for line in lines[2:]]


def scene(rows: list[dict[str, str]], target: str, points: int) -> dict[str, str]:
    return next(row for row in rows if row["target"] == target and row["points"] == str(points))


def cores() -> Iterator[list[str]]:
    text = figures.README.read_text().split(figures.BEGIN)[1].split(figures.END)[0]
    measured = figures.from_text(text)
    for line, name, row in CORES:
        yield [line, *(str(measured[name][row][column]) for column in CORE_COLUMNS)]


def accuracy() -> Iterator[list[str]]:
    for row in table("accuracy"):
        yield list(row.values())


def beside_opencv() -> Iterator[list[str]]:
    wrong = table("opencv-wrong")
    for target, points in WRONG:
        row = scene(wrong, target, points)
        yield [f"wrong: {target}, {points} points", *(row[method] for method in METHODS)]
    counts = {row["method"]: row for row in table("opencv-instructions")}
    for line, column in COUNTED.items():
        pairs = [counts[method][column].partition(" / ") for method in METHODS]
        yield [f"thousand instructions: {line}", *(pair[0] for pair in pairs)]
        yield [f"allocations: {line}", *(pair[2] for pair in pairs)]


def beside_poselib() -> Iterator[list[str]]:
    rows = table("poselib")
    for target, points in BESIDE_POSELIB:
        row = scene(rows, target, points)
        yield [f"{target}, {points} points", *(row[column] for column in ("wrong: rigcal", "one answer", "estimate",
                                                                          "time of estimate"))]


BLOCKS = (cores, accuracy, beside_opencv, beside_poselib)


def written(text: str) -> str:
    """README.md with the figures of the tables."""
    if len(BLOCK.findall(text)) != len(BLOCKS) or text.count("<!-- figures from") != len(BLOCKS):
        sys.exit(f"quoted.py: README.md has not {len(BLOCKS)} blocks of figures")
    lines = iter("".join(f"| {' | '.join(row)} |\n" for row in block()) for block in BLOCKS)
    return BLOCK.sub(lambda found: found[1] + next(lines) + found[4], text)


def main() -> None:
    text = README.read_text()
    right = written(text)
    if sys.argv[1:] == ["--check"]:
        wrong = [line for line in right.splitlines() if line not in text.splitlines()]
        if right != text:
            sys.exit("README.md: the tables say otherwise; python3 tests/bench/quoted.py writes\n" + "\n".join(wrong))
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        README.write_text(right)


if __name__ == "__main__":
    main()
