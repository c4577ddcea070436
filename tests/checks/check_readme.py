#!/usr/bin/env python3
"""Compiles and runs the C programs of README.md, examples/README.md and CONTRIBUTING.md.

A ```c block that defines main is a program. Any other ```c block is a part of the file that
the link before it names, word for word; if that is a program of examples/, the program is
meant. Programs are compiled as strictly as the library itself, and run. What a program prints
must be the ```text block that follows it, word for word.

The first programs, examples/*.c besides the command line, have at most 40 lines each, and
examples/README.md shows all of them.

A ```sh block of CONTRIBUTING.md that a ```text block follows is run as it is printed, in a
copy of the project; it must print that text.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
FLAGS = ["-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic",
         "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror", f"-I{ROOT}/include"]
BLOCK = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.S | re.M)
LINK = re.compile(r"\]\(([\w./-]+\.[ch])\)")
MAIN = re.compile(r"\bmain\s*\(")
LINES_MOST = 40


def run(*command, cwd=ROOT):
    return subprocess.run([str(c) for c in command], cwd=cwd,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=3600)


def blocks_of(text):
    """The blocks: (language, content, line, text since the block before)."""
    found, end = [], 0
    for m in BLOCK.finditer(text):
        found.append((m[1], m[2], text.count("\n", 0, m.start()) + 1, text[end:m.start()]))
        end = m.end()
    return found


def first_programs():
    return [path for path in sorted((ROOT / "examples").glob("*.c"))
            if not re.match(r"(cli_|rigcal_cli)", path.name)]


def build_library(work):
    for source in sorted((ROOT / "src").glob("*.c")):
        built = run("gcc", *FLAGS, "-c", source, "-o", work / (source.stem + ".o"))
        if built.returncode:
            sys.exit(f"{source.name} does not compile\n{built.stdout}")


def output_of(source, where, work):
    program = work / "program"
    built = run("gcc", *FLAGS, source, *sorted(work.glob("*.o")), "-lm", "-o", program)
    if built.returncode:
        sys.exit(f"{where}: the program does not compile\n{built.stdout}")
    ran = run(program)
    if ran.returncode:
        sys.exit(f"{where}: the program ends with status {ran.returncode}\n{ran.stdout}")
    return ran.stdout


def compare(where, printed, text):
    if printed != text:
        sys.exit(f"{where}: this is printed:\n{printed}\nand the text block says:\n{text}")


def named_file(before, where, folder):
    names = LINK.findall(before)
    if not names:
        sys.exit(f"{where}: a ```c block without main, and no link before it names its file")
    path = folder / names[-1]
    if not path.is_file():
        sys.exit(f"{where}: there is no {names[-1]}")
    return path


def check_part(code, path, where):
    """`code`, whatever its indentation, is a run of lines of the file."""
    lines = [line.rstrip() for line in path.read_text().split("\n")]
    part = [line.rstrip() for line in code.rstrip("\n").split("\n")]
    for at in range(len(lines) - len(part) + 1):
        piece = "\n".join(lines[at:at + len(part)])
        if textwrap.dedent(piece) == textwrap.dedent("\n".join(part)):
            return
    sys.exit(f"{where}: these lines are not in {path.relative_to(ROOT)}:\n{code}")


def check_document(name, work, shown):
    """Returns the number of blocks compared. Adds programs that are shown to `shown`."""
    folder = (ROOT / name).parent
    blocks = blocks_of((ROOT / name).read_text())
    count = 0
    for k, (language, code, line, before) in enumerate(blocks):
        where = f"{name}:{line}"
        text = blocks[k + 1][1] if k + 1 < len(blocks) and blocks[k + 1][0] == "text" else None
        if language == "c":
            if MAIN.search(code):
                source = work / "document.c"
                source.write_text(code)
            else:
                source = named_file(before, where, folder)
                check_part(code, source, where)
                if not MAIN.search(source.read_text()):
                    continue
                shown.add(source)
            if text is None:
                sys.exit(f"{where}: no ```text block with the output follows the program")
            compare(where, output_of(source, where, work), text)
            count += 1
        elif language == "sh" and text is not None:
            copy = work / "copy"
            shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns("build", ".git"))
            ran = run("sh", "-eu", "-c", "mkdir -p build\n" + code, cwd=copy)
            shutil.rmtree(copy)
            compare(where, ran.stdout, text)
            count += 1
    return count


def main():
    shown = set()
    programs = first_programs()
    for path in programs:
        n_lines = path.read_text().count("\n")
        if n_lines > LINES_MOST:
            sys.exit(f"examples/{path.name} has {n_lines} lines; {LINES_MOST} are allowed")
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        build_library(work)
        count = check_document("README.md", work, shown)
        count += check_document("examples/README.md", work, shown)
        for path in programs:
            if path not in shown:
                sys.exit(f"examples/README.md does not show examples/{path.name}")
        count += check_document("CONTRIBUTING.md", work, shown)
    print(f"{count} outputs as printed, {len(programs)} programs of at most {LINES_MOST} lines")


if __name__ == "__main__":
    main()
